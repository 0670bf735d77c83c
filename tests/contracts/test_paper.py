"""docs/paper.md stays true: what it names exists, and its count is right."""

from __future__ import annotations

import ast
import re
from collections import Counter
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / "docs" / "paper.md").read_text(encoding="utf-8")
VERDICTS = ("yes", "part", "other", "no")
ROWS = [
    cells
    for line in TEXT.splitlines()
    if line.startswith("| ")
    and len(cells := [cell.strip() for cell in line.strip().strip("|").split("|")]) == 5
    and cells[1] in VERDICTS
    and cells[0]
]


@cache
def names_of(path: Path) -> frozenset[str]:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    defined = (ast.FunctionDef, ast.AsyncFunctionDef)
    return frozenset(node.name for node in ast.walk(tree) if isinstance(node, defined))


def missing(cell: str) -> list[str]:
    """What a cell names and is not there."""
    gone: list[str] = []
    for name in re.findall(r"`([^`]+)`", cell):
        place, _, test = name.partition("::")
        found = [root / place for root in (ROOT / "backend/dray", ROOT) if (root / place).is_file()]
        if not found or (test and test not in names_of(found[0])):
            gone.append(name)
    return gone


def test_all_sections_are_there() -> None:
    assert re.findall(r"^## (\S+)", TEXT, re.MULTILINE) == ["3.1", "3.2", "4.1", "4.2", "4.3"]
    assert len(ROWS) > 100


def faults(row: list[str]) -> list[str]:
    claim, verdict, where, test, remark = row
    wrong = [f"{name} is not there" for name in missing(where) + missing(test)]
    if verdict != "no" and ("`" not in where or "`tests/" not in test):
        wrong.append("where is it, and by which test is it seen?")
    if verdict != "yes" and not remark:
        wrong.append("what differs, and why?")
    return [f"{claim}: {each}" for each in wrong]


def test_what_is_named_exists_and_what_is_not_so_is_explained() -> None:
    assert [fault for row in ROWS for fault in faults(row)] == []


def test_a_row_that_names_what_is_not_there_is_found() -> None:
    row = ["A claim", "part", "`protocol/nothing.py`", "`tests/contracts/test_paper.py::test_nothing`", ""]
    assert len(faults(row)) == 3


def test_the_count_is_right() -> None:
    counted = Counter(row[1] for row in ROWS)
    assert f"| sentences | {' | '.join(str(counted[verdict]) for verdict in VERDICTS)} |" in TEXT
