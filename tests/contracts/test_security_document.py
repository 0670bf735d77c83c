"""docs/security.md: each line of what a stolen thing costs names a test, and that test is there."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

NAMED = re.compile(r"`(tests/[\w/]+\.py)::(test_\w+)`")


def rows() -> list[str]:
    section = (ROOT / "docs/security.md").read_text(encoding="utf-8").split("## What is stolen")[1]
    table = [line for line in section.split("\n## ")[0].splitlines() if line.startswith("| ")]
    return table[2:]


@pytest.mark.parametrize("row", rows(), ids=lambda row: row.split("|")[1].strip()[:40])
def test_each_line_names_a_test_that_is_there(row: str) -> None:
    cells = [cell.strip() for cell in row.strip("|").split(" | ")]
    assert len(cells) == 4, row
    named = NAMED.search(cells[3])
    assert named is not None, f"no test is named: {row}"
    file, test = named.groups()
    source = (ROOT / file).read_text(encoding="utf-8")
    assert re.search(rf"^(?:async )?def {test}\(", source, re.MULTILINE), f"{file} has no {test}"
