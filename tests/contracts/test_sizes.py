"""Sizes: no file of Python is longer than 400 lines, and no kit of the tests hides another."""

from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).parents[2]
ROOMS = ("backend", "sim", "tests", "migrations")
MAX_LINES = 400
"""What is longer has more than one subject, as a rule."""


def test_no_file_of_python_is_longer_than_400_lines() -> None:
    lines = {
        str(path.relative_to(ROOT)): len(path.read_text(encoding="utf-8").splitlines())
        for room in ROOMS
        for path in (ROOT / room).rglob("*.py")
    }
    assert len(lines) > 100
    assert {path: count for path, count in lines.items() if count > MAX_LINES} == {}


def test_no_kit_of_the_tests_hides_another_or_a_module_of_python() -> None:
    # Kits of all rooms are found on one path when all tests run together.
    kits = Counter(
        path.stem
        for path in (ROOT / "tests").rglob("*.py")
        if path.stem != "conftest" and not path.stem.startswith("test_")
    )
    assert kits
    assert [kit for kit, count in kits.items() if count > 1 or kit in sys.stdlib_module_names] == []
