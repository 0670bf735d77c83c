"""Each misbehaviour of a controller in docs/machines.md has its test."""

from __future__ import annotations

import re
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "tests/adapters/opcua"

sys.path.insert(0, str(FOLDER))

LEAST = 20
"""Behaviours that must be written down."""


def rows() -> list[tuple[str, str]]:
    """Behaviour and test of each row."""
    text = (ROOT / "docs/machines.md").read_text(encoding="utf-8")
    section = text.partition("\n### What controllers do wrong\n")[2].partition("\n## ")[0]
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in section.splitlines()]
    return [(row[0], row[2].strip("`")) for row in cells if len(row) == 3 and "---" not in row[0]][1:]


def test_each_misbehaviour_that_is_written_down_has_its_test() -> None:
    from odd_controllers import ODD  # noqa: PLC0415  It is found by the line above.

    odd = {each.name for each in ODD}
    tests = {
        name
        for file in sorted(FOLDER.glob("test_*.py"))
        for name in re.findall(r"^def (test_\w+)", file.read_text(encoding="utf-8"), re.MULTILINE)
    }
    written = rows()
    assert len(written) >= LEAST
    assert len({behaviour for behaviour, _ in written}) == len(written)
    for behaviour, test in written:
        assert behaviour in odd if test == "odd" else test in tests, (behaviour, test)
