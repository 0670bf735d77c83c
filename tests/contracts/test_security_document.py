"""docs/security.md: each line of what a stolen thing costs names a test, and each test that it names is there, once."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

DOCUMENT = (ROOT / "docs/security.md").read_text(encoding="utf-8")

NAMED = re.compile(r"`(test_\w+)`")

WORDS_MAX = 1_300
"""A page, printed small: who is asked what a stolen key costs reads it at once."""


def rows() -> list[str]:
    section = DOCUMENT.split("## What is stolen")[1]
    table = [line for line in section.split("\n## ")[0].splitlines() if line.startswith("| ")]
    return table[2:]


@cache
def names() -> list[str]:
    """Of all tests."""
    sources = (file.read_text(encoding="utf-8") for file in (ROOT / "tests").rglob("test_*.py"))
    return [
        name
        for source in sources
        for name in re.findall(r"^(?:async )?def (test_\w+)\(", source, re.MULTILINE)
    ]


@pytest.mark.parametrize("row", rows(), ids=lambda row: row.split("|")[1].strip()[:40])
def test_each_line_names_a_test(row: str) -> None:
    cells = [cell.strip() for cell in row.strip("|").split(" | ")]
    assert len(cells) == 4, row
    assert NAMED.search(cells[3]), f"no test is named: {row}"


@pytest.mark.parametrize("name", sorted(set(NAMED.findall(DOCUMENT))))
def test_each_test_that_is_named_is_there_once(name: str) -> None:
    assert names().count(name) == 1


def test_it_is_one_page() -> None:
    assert len(DOCUMENT.split()) <= WORDS_MAX
