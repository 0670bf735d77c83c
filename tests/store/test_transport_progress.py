"""A plain transport's state in SQL follows its destination's newest event."""

from __future__ import annotations

import pytest

from dray.messages import Event, TransportState
from dray.messages.base import COUNT_MAX
from dray.messages.fact import TransportProgressed
from dray.messages.overtaken import OVERTAKES_S
from dray.store.orders.transports import TransportRow, progressed

CALLED = TransportRow(
    id="T1",
    source="S1",
    destination="M1",
    item="steel",
    quantity=4,
    priority="normal",
    called_by="A",
    caller="key:1",
    created_at_s=0.0,
    due_at_s=900.0,
    updated_at_s=0.0,
)


def after(row: TransportRow, number: int, state: TransportState, at_s: float, life: int = 1) -> TransportRow:
    fact = TransportProgressed("T1", state, "steel", 4, "S1", "M1")
    return progressed(row, Event("M1", life, number, at_s, fact), fact, lambda at_s: at_s)


@pytest.mark.parametrize("life", [1, 2], ids=["the same life", "the next life"])
def test_a_number_of_the_far_future_does_not_keep_a_transport_open_for_ever(life: int) -> None:
    """A thief of the destination's certificate has told it."""
    row = after(CALLED, COUNT_MAX, TransportState.ASSIGNED, 10.0, COUNT_MAX)
    assert after(row, 7, TransportState.DELIVERED, 10.0 + OVERTAKES_S, life) is row, "perhaps it came late"
    row = after(row, 8, TransportState.DELIVERED, 10.0 + OVERTAKES_S + 0.1, life)
    assert row.status is TransportState.DELIVERED
    assert row.ended_at_s is not None


def test_an_event_that_was_fetched_later_changes_nothing() -> None:
    row = after(CALLED, 9, TransportState.ON_BOARD, 100.0)
    assert after(row, 8, TransportState.ASSIGNED, 50.0) is row
