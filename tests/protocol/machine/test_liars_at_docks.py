"""A lying vehicle at the dock of a machine without notes: nothing counts but the load for which the body has let it in."""

from __future__ import annotations

import pytest
from effects import instructed, sent
from m7 import NO_HOUSINGS, handover
from msgspec.structs import replace
from rigs import BlindRig, MachineRig
from spoken import rhb

from dray.body import Book, OpenDock
from dray.messages import Phase, Withdrawn
from dray.messages.base import COUNT_MAX
from dray.protocol.runtime.events import Effect

DOCK = "m7"
PUMPS = "pump-p3"


def without_notes(item: str = "housing") -> MachineRig:
    """M7's agent has lost its notes; its body remembers that it let ATV2 bring 24 pieces. 8 pumps and 60 seal kits lie there."""
    rig = BlindRig("M7", NO_HOUSINGS | {PUMPS: 8, "seal-kit": 60}, incarnation=2)
    rig.answers, rig.opened, rig.let_in = True, ("ATV2",), OpenDock("ATV2", item, 24)
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
    **changes: object,
) -> list[Effect]:
    """ATV2 says in a heartbeat what it does at the dock."""
    rig.run(rig.now_s + 1.0)
    beat = rhb("ATV2", 1000 + int(rig.now_s), rig.now_s, task=task, coordinator=coordinator)
    assert beat.task is not None
    does = None if phase is None else replace(beat.task, phase=phase, item=item, quantity=quantity)
    return rig.on_message("ATV2", replace(beat, task=does, **{"node": DOCK} | changes))


@pytest.mark.parametrize(("item", "quantity"), [("housing", COUNT_MAX), ("impeller", 24), ("impeller", COUNT_MAX)])
def test_who_was_let_in_for_one_load_hands_over_no_other_and_no_more(item: str, quantity: int) -> None:
    rig = without_notes()
    booked = instructed(says(rig, Phase.HANDING_OVER, item, quantity), Book)
    print(booked)
    assert all(each.item == "housing" and each.change <= 24 for each in booked)


def test_who_was_let_in_to_bring_a_load_takes_none_away() -> None:
    rig = without_notes()
    effects = says(rig, Phase.CARRYING, "seal-kit", 60, coordinator="S1", load="seal-kit", load_quantity=60)
    assert instructed(effects, Book) == []


def test_without_memory_of_body_bound() -> None:
    rig = BlindRig("M7", NO_HOUSINGS | {PUMPS: 8, "seal-kit": 60}, incarnation=2)
    rig.answers, rig.opened = True, ("ATV2",)
    rig.start()
    print(instructed(says(rig, Phase.HANDING_OVER, "housing", COUNT_MAX), Book))


def test_double() -> None:
    rig = without_notes()
    first = instructed(says(rig, None, "", 0, node="c1", left_empty=DOCK), Book)
    rig.stocked("housing", 24, "ATV2")
    more = [b for t in range(5) for b in instructed(rig.on_message("ATV2", handover(f"M7-{t}", 1 )), Book)]
    for t in range(5):
        more += instructed(says(rig, Phase.HANDING_OVER, "housing", 24, task=f"M7-{t}"), Book)
        more += instructed(says(rig, None, "", 0, node="c1", left_empty=DOCK), Book)
    print(first, more)
    assert not more


def test_who_reports_for_anothers_task_ends_only_one_of_the_same_load() -> None:
    rig = without_notes()
    beat = rhb("ATV3", 1, rig.now_s, task="M7-9", coordinator="M7")
    assert beat.task is not None
    brings = replace(beat.task, epoch=5, phase=Phase.APPROACHING, item="impeller", quantity=20, due_s=900.0)
    rig.on_message("ATV3", replace(beat, task=brings))
    assert rig.agent._flow.tasks.get("M7-9") is not None
    says(rig, None, "", 0, node="c1")
    effects = rig.on_message("ATV2", handover("M7-9", 4))
    print(instructed(effects, Book))
    effects = rig.stocked("housing", 24, "ATV2")
    assert sent(rig.all, Withdrawn, to="ATV3") == []
    assert rig.agent._flow.tasks.get("M7-9") is not None
