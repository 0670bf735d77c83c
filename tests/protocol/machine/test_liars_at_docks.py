"""A lying vehicle at the dock of a machine without notes: nothing counts but the load for which the body has let it in."""

from __future__ import annotations

from typing import Any

import pytest
from effects import instructed, sent
from m7 import FULL, NO_HOUSINGS, handover
from msgspec.structs import replace
from rigs import BlindRig, MachineRig
from spoken import rhb

from dray.body import Book, DockReady, OpenDock
from dray.messages import Docked, Phase, Withdrawn
from dray.messages.base import COUNT_MAX
from dray.protocol.runtime.events import Effect

DOCK = "m7"
KITS = 60


def blind() -> MachineRig:
    """M7 without its notes, not started; its body knows that it let ATV2 in."""
    rig = BlindRig("M7", NO_HOUSINGS | {"seal-kit": KITS}, incarnation=2)
    rig.answers, rig.opened = True, ("ATV2",)
    return rig


def without_notes() -> MachineRig:
    """M7 without its notes; its body remembers that it let ATV2 bring 24 housings."""
    rig = blind()
    rig.let_in = OpenDock("ATV2", "housing", 24)
    rig.start()
    return rig


def says(
    rig: MachineRig,
    phase: Phase | None,
    item: str,
    quantity: int,
    *,
    task: str = "M7-1",
    coordinator: str = "M7",
    **changes: Any,
) -> list[Effect]:
    """ATV2 says in a heartbeat what it does at the dock."""
    rig.run(rig.now_s + 1.0)
    beat = rhb("ATV2", 1000 + int(rig.now_s), rig.now_s, task=task, coordinator=coordinator)
    assert beat.task is not None
    does = None if phase is None else replace(beat.task, phase=phase, item=item, quantity=quantity)
    return rig.on_message("ATV2", replace(beat, task=does, **{"node": DOCK} | changes))


@pytest.mark.parametrize(
    ("item", "quantity", "booked"),
    [("housing", COUNT_MAX, 24), ("impeller", 24, 0), ("impeller", COUNT_MAX, 0)],
)
def test_who_was_let_in_for_one_load_hands_over_no_other_and_no_more(
    item: str, quantity: int, booked: int
) -> None:
    rig = without_notes()
    books = instructed(says(rig, Phase.HANDING_OVER, item, quantity), Book)
    assert [(each.item, each.change) for each in books] == ([("housing", booked)] if booked else [])


def test_who_was_let_in_to_bring_a_load_takes_none_away() -> None:
    rig = without_notes()
    effects = says(
        rig, Phase.CARRYING, "seal-kit", KITS, coordinator="S1", load="seal-kit", load_quantity=KITS
    )
    assert instructed(effects, Book) == []


def test_of_whom_the_body_remembers_no_load_brings_no_more_than_finds_room() -> None:
    rig = blind()
    rig.start()
    [book] = instructed(says(rig, Phase.HANDING_OVER, "housing", COUNT_MAX), Book)
    assert book.change == FULL["housing"]


def test_a_load_that_was_booked_once_is_not_booked_again_whatever_its_vehicle_says() -> None:
    rig = without_notes()
    assert len(instructed(says(rig, None, "", 0, node="c1", left_empty=DOCK), Book)) == 1
    rig.stocked("housing", 24, "ATV2")
    before = len(rig.all)
    for number in range(5):
        rig.on_message("ATV2", handover(f"M7-{number}"))
        says(rig, Phase.HANDING_OVER, "housing", 24, task=f"M7-{number}")
        says(rig, None, "", 0, node="c1", left_empty=DOCK)
    assert instructed(rig.all[before:], Book) == []


def claims(rig: MachineRig, atv: str, item: str, quantity: int) -> list[Effect]:
    """A vehicle says to a machine without notes that it comes with a load, as its fifth carrier."""
    beat = rhb(atv, 1, rig.now_s, task="M7-9", coordinator="M7")
    assert beat.task is not None
    brings = replace(beat.task, epoch=5, phase=Phase.APPROACHING, item=item, quantity=quantity, due_s=900.0)
    return rig.on_message(atv, replace(beat, task=brings))


def test_a_report_for_another_vehicles_task_ends_it_only_if_its_load_has_come() -> None:
    rig = without_notes()
    claims(rig, "ATV3", "impeller", 20)
    says(rig, None, "", 0, node="c1")
    assert instructed(rig.on_message("ATV2", handover("M7-9", 4)), Book)
    rig.stocked("housing", 24, "ATV2")
    assert sent(rig.all, Withdrawn, to="ATV3") == []
    assert rig.agent._flow.tasks.get("M7-9") is not None


@pytest.mark.parametrize(("quantity", "believed"), [(FULL["housing"], True), (FULL["housing"] + 1, False)])
def test_no_vehicle_carries_more_to_a_machine_without_notes_than_it_keeps(
    quantity: int, *, believed: bool
) -> None:
    rig = without_notes()
    claims(rig, "ATV3", "housing", quantity)
    assert (rig.agent._flow.tasks.get("M7-9") is not None) is believed


@pytest.mark.parametrize(("atv", "item"), [("ATV3", "housing"), ("ATV2", "impeller")])
def test_whoever_claims_to_carry_for_a_machine_without_notes_has_brought_nothing_before_it_was_let_in(
    atv: str, item: str
) -> None:
    rig = without_notes()
    claims(rig, atv, item, 24)
    assert instructed(rig.on_message(atv, handover("M7-9", 5)), Book) == []


def test_who_carries_for_a_machine_without_notes_has_brought_its_load_once_it_was_let_in() -> None:
    rig = without_notes()
    claims(rig, "ATV3", "housing", 24)
    rig.on_message("ATV3", Docked("M7-9", 5, "M7"))
    rig.report(DockReady(vehicle="ATV3"))
    effects = rig.on_message("ATV3", handover("M7-9", 5))
    assert instructed(effects, Book) == [Book("ATV3", "housing", 24, task="M7-9", epoch=5)]


def test_who_was_let_in_before_the_notes_were_lost_and_says_that_it_still_carries_is_booked_in_once() -> None:
    rig = without_notes()
    says(rig, Phase.UNLOADING, "housing", 24)
    assert rig.agent._flow.tasks.get("M7-1") is not None
    effects = rig.on_message("ATV2", handover())
    assert instructed(effects, Book) == [Book("ATV2", "housing", 24, task="M7-1", epoch=1)]
    rig.stocked("housing", 24, "ATV2")
    before = len(rig.all)
    says(rig, None, "", 0, node="c1", left_empty=DOCK)
    rig.on_message("ATV2", handover())
    assert instructed(rig.all[before:], Book) == []
