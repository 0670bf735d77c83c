"""Names of kits: no kit of the tests hides another."""

from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).parents[2]


def test_no_kit_of_the_tests_hides_another_or_a_module_of_python() -> None:
    # Kits of all rooms are found on one path when all tests run together.
    kits = Counter(
        path.stem
        for path in (ROOT / "tests").rglob("*.py")
        if path.stem != "conftest" and not path.stem.startswith("test_")
    )
    assert kits
    assert [kit for kit, count in kits.items() if count > 1 or kit in sys.stdlib_module_names] == []
