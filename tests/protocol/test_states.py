"""The tables of states: what is drawn of them, and what they do not let happen."""

from __future__ import annotations

from pathlib import Path

import pytest

from dray.errors import ProtocolViolation
from dray.protocol.states import TABLES, document
from dray.states import States, Transitions

DRAWN = Path(__file__).parents[2] / "docs" / "states.md"


def test_the_drawing_is_that_of_the_tables() -> None:
    assert DRAWN.read_text() == document(), "draw it again: python -m dray.protocol.states > docs/states.md"


@pytest.mark.parametrize("title", TABLES)
def test_a_table_knows_each_of_its_states_and_all_lead_to_an_end(title: str) -> None:
    transitions: Transitions[str] = TABLES[title][2]
    assert {after for row in transitions.values() for after in row} <= transitions.keys()
    ends = {state for state, row in transitions.items() if not row}
    assert ends
    while more := {state for state, row in transitions.items() if ends & row.keys()} - ends:
        ends |= more
    assert ends == transitions.keys()


@pytest.mark.parametrize("title", TABLES)
def test_what_a_table_does_not_have_is_our_own_fault_and_changes_nothing(title: str) -> None:
    transitions = TABLES[title][2]
    first = next(iter(transitions))
    states = States("a thing", transitions, first)
    with pytest.raises(ProtocolViolation, match=f"a thing that is {first} cannot become"):
        states.enter(next(state for state in transitions if state not in transitions[first]))
    assert states.now is first
