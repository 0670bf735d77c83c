"""docs/vehicles.md says what is: its table of behaviours names tests that are there, its drawing is that of the states."""

from __future__ import annotations

import re
from pathlib import Path

from dray.adapters.vda5050.control.order_state import ACTIVE, OVER, TRANSITIONS, OrderState
from dray.states import diagram

ROOT = Path(__file__).parents[3]
DOCUMENT = (ROOT / "docs/vehicles.md").read_text(encoding="utf-8")


def written() -> set[str]:
    """Of the driver, by their names."""
    return {
        name
        for file in Path(__file__).parent.glob("test_*.py")
        for name in re.findall(r"^def (test_\w+)", file.read_text(encoding="utf-8"), re.MULTILINE)
    }


def test_each_of_the_25_behaviours_has_tests_and_each_of_them_is_listed() -> None:
    rows = re.findall(r"^\| (\d+) \| .* \| `(\w+)` \|$", DOCUMENT, re.MULTILINE)
    assert [int(number) for number, _ in rows] == list(range(1, 26))
    for number, test in rows:
        assert test.startswith(f"test_{int(number):02}_")
        assert test in written()


def test_each_thing_that_is_waited_for_and_each_value_that_is_doubted_has_a_test() -> None:
    rows = re.findall(r"^\| (?!\d+ ).* \| `(test_\w+)` \|$", DOCUMENT, re.MULTILINE)
    assert len(rows) >= 28
    assert set(rows) <= written()


def test_the_drawing_of_the_states_is_that_of_the_table() -> None:
    assert diagram(TRANSITIONS) in DOCUMENT


def test_every_state_is_left_for_one_of_the_table_and_all_lead_to_an_end() -> None:
    assert set(TRANSITIONS) == set(OrderState)
    assert {state for state, row in TRANSITIONS.items() if not row} == OVER
    ends = set(OVER)
    while more := {state for state, row in TRANSITIONS.items() if ends & row.keys()} - ends:
        ends |= more
    assert ends == set(OrderState)
    assert set(OrderState) - OVER > ACTIVE
