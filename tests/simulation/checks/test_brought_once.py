"""The check of plain transports, on words that were never said: it must find what it is there for."""

from __future__ import annotations

import pytest

from dray.messages import Event, TransportOrdered, TransportState
from dray.messages.fact import TaskClosed, TransportProgressed
from dray_sim.checks.broken import InvariantBroken
from dray_sim.checks.brought_once import BroughtOnce


def carried_by(carrier: str, vehicle: str, until_s: float | None, ability: str = "") -> None:
    """One transport is asked for, for one vehicle, and another vehicle or that one has it."""
    check = BroughtOnce({"ATV1": ("tote", "pallet"), "ATV2": ("tote",)})
    order = TransportOrdered("T-1", "S3", "shaft", 40, 600.0, vehicle, until_s, ability)
    check.on_message(1.0, "gateway", "M8", order)
    fact = TransportProgressed(
        transport="T-1",
        state=TransportState.ASSIGNED,
        item="shaft",
        quantity=40,
        source="S3",
        destination="M8",
        task="T-1-1",
        carrier=carrier,
    )
    event = Event(agent="M8", incarnation=1, number=1, at_s=2.0, fact=fact)
    check.on_message(2.0, "M8", "", event)


def test_a_strict_choice_that_another_one_carries_is_found() -> None:
    with pytest.raises(InvariantBroken, match="for ATV1 alone"):
        carried_by("ATV2", "ATV1", None)


@pytest.mark.parametrize(
    ("carrier", "vehicle", "until_s"), [("ATV1", "ATV1", None), ("ATV2", "ATV1", 9.0), ("ATV2", "", None)]
)
def test_who_may_carry_it_is_no_finding(carrier: str, vehicle: str, until_s: float | None) -> None:
    carried_by(carrier, vehicle, until_s)


def test_a_carrier_that_lacks_what_was_wanted_of_it_is_found() -> None:
    with pytest.raises(InvariantBroken, match="wants pallet of its vehicle, and ATV2 has it"):
        carried_by("ATV2", "", None, "pallet")
    carried_by("ATV1", "", None, "pallet")


def test_what_was_called_off_and_is_brought_is_found() -> None:
    check = BroughtOnce({"ATV1": ("tote",)})
    check.on_message(1.0, "gateway", "M8", TransportOrdered("T-1", "S3", "shaft", 40, 600.0))

    def tells(number: int, state: TransportState, task: str = "") -> None:
        fact = TransportProgressed(
            "T-1", state, item="shaft", quantity=40, source="S3", destination="M8", task=task
        )
        event = Event(agent="M8", incarnation=1, number=number, at_s=2.0, fact=fact)
        check.on_message(2.0, "M8", "", event)

    tells(1, TransportState.ASSIGNED, "T-1-1")
    tells(2, TransportState.CANCELLED)
    closed = TaskClosed(task="T-1-1", epoch=1, outcome="delivered", carrier="ATV1")
    with pytest.raises(InvariantBroken, match="T-1 was called off, and T-1-1 of it is delivered"):
        check.on_message(3.0, "M8", "", Event(agent="M8", incarnation=1, number=3, at_s=3.0, fact=closed))
