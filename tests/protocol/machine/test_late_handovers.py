"""A load whose carrier was superseded before its report was heard is booked once, and no second one is brought for it."""

from __future__ import annotations

import pytest
from effects import award_number, committed, facts, instructed, sent
from m7 import NO_HOUSINGS, docked, handover, unloading
from msgspec.structs import replace
from rigs import BlindRig, MachineRig
from spoken import accepted, bid, rhb

from dray.body import Book, DockReady, OpenDock
from dray.messages import (
    Award,
    Docked,
    Handover,
    HandoverAccepted,
    Phase,
    StockAsked,
    Superseded,
    TaskAnnounced,
    Withdrawn,
)
from dray.messages.fact import CarrierChanged, TaskClosed
from dray.protocol.runtime.events import Effect

SILENT_S = 60.0
"""Seconds after which a carrier that is not heard was replaced."""

BROUGHT = [Book("ATV2", "housing", 24, task="M7-1", epoch=1)]


def beats(rig: MachineRig, vehicle: str, phase: Phase | None = None, *, node: str = "c1") -> list[Effect]:
    """A vehicle tells what it does in M7-1; without a phase it has no task."""
    rig.run(rig.now_s + 1.0)
    beat = rhb(vehicle, 1000 + int(rig.now_s), rig.now_s, task="M7-1", coordinator="M7")
    assert beat.task is not None
    doing = None if phase is None else replace(beat.task, epoch=2, phase=phase, item="housing", quantity=24)
    return rig.on_message(vehicle, replace(beat, task=doing, node=node))


def superseded(*, opened: tuple[str, ...] = ("ATV2",)) -> MachineRig:
    """M7 was down while ATV2 put 24 housings down (M7-1) and went on; it hears nothing of ATV2, and seeks a carrier."""
    return unheard(unloading(), opened=opened)


def unheard(before: MachineRig, *, opened: tuple[str, ...]) -> MachineRig:
    rig = reborn(before, 2, opened)
    rig.run(rig.now_s + SILENT_S)
    assert [each.replaced for each in facts(rig.all, CarrierChanged)] == ["ATV2"]
    return rig


def reborn(before: MachineRig, life: int, opened: tuple[str, ...] = ()) -> MachineRig:
    rig = BlindRig("M7", NO_HOUSINGS, incarnation=life)
    rig.answers, rig.opened, rig.memory, rig.now_s = True, opened, committed(before.all), before.now_s
    machine = rig.agent
    # It compares reports with counts as it does in service; prices are plain numbers all the same.
    handovers = {Handover: machine._flow.message_handlers[Handover]}
    machine._message_handlers = {**machine._message_handlers, **handovers}
    rig.start()
    return rig


def hired(rig: MachineRig) -> None:
    """ATV3 is the new carrier."""
    effects = rig.on_message("ATV3", bid(50.0, task="M7-1", epoch=2))
    while not sent(effects, Award, to="ATV3"):
        effects = rig.run(rig.agent.wake_at_s)
    rig.on_message("ATV3", accepted("M7-1", epoch=2, number=award_number(effects, "ATV3", "M7-1")))


def booked(rig: MachineRig, epoch: int = 1) -> list[Effect]:
    """ATV2 tells of its load; the body books it."""
    assert instructed(rig.on_message("ATV2", handover(epoch=epoch)), Book) == BROUGHT
    return rig.stocked("housing", 24, "ATV2")


def ended(effects: list[Effect]) -> list[tuple[str, str]]:
    return [(each.outcome, each.carrier) for each in facts(effects, TaskClosed) if each.task == "M7-1"]


def test_a_load_that_lies_here_ends_its_transport_while_a_carrier_is_sought() -> None:
    rig = superseded()
    effects = booked(rig)
    assert ended(effects) == [("delivered", "ATV2")]
    assert sent(rig.run(rig.now_s + 60.0), TaskAnnounced) == []
    assert sent(rig.on_message("ATV3", bid(50.0, task="M7-1", epoch=2)), Award) == []


@pytest.mark.parametrize("phase", [None, Phase.APPROACHING, Phase.LOADING])
def test_the_new_carrier_is_called_off_while_it_has_no_load_on_board(phase: Phase | None) -> None:
    rig = superseded()
    hired(rig)
    if phase is not None:
        beats(rig, "ATV3", phase)
    effects = booked(rig)
    assert [each.epoch for each in sent(effects, Withdrawn, to="ATV3")] == [2]
    assert ended(effects) == [("delivered", "ATV2")]
    assert sent(rig.on_message("ATV2", handover()), HandoverAccepted, to="ATV2")


def test_a_new_carrier_with_a_load_on_board_brings_it_as_surplus() -> None:
    rig = superseded()
    hired(rig)
    beats(rig, "ATV3", Phase.CARRYING)
    effects = booked(rig)
    assert (sent(effects, Withdrawn), ended(effects)) == ([], [])
    rig.on_message("ATV3", docked(epoch=2))
    rig.report(DockReady(vehicle="ATV3"))
    out = Book("ATV3", "housing", 24, task="M7-1", epoch=2)
    assert instructed(rig.on_message("ATV3", handover(epoch=2)), Book) == [out]
    assert ended(rig.stocked("housing", 24, "ATV3")) == [("delivered", "ATV3")]


def test_it_is_booked_once() -> None:
    rig = superseded()
    assert instructed(rig.on_message("ATV2", handover()), Book) == BROUGHT
    assert instructed(rig.on_message("ATV2", handover()), Book) == []
    rig.stocked("housing", 24, "ATV2")
    assert instructed(rig.on_message("ATV2", handover()), Book) == []


@pytest.mark.parametrize(
    ("vehicle", "epoch", "task"),
    [("ATV9", 1, "M7-1"), ("ATV2", 2, "M7-1"), ("ATV2", 1, "M7-9")],
    ids=["another-vehicle", "another-epoch", "another-task"],
)
def test_a_load_that_it_was_not_hired_for_is_not_booked(vehicle: str, epoch: int, task: str) -> None:
    rig = superseded()
    effects = rig.on_message(vehicle, handover(task, epoch))
    assert instructed(effects, Book) == []
    assert sent(effects, Superseded, to=vehicle)


def test_a_load_of_a_vehicle_that_was_never_let_in_is_not_booked() -> None:
    rig = superseded(opened=())
    assert instructed(rig.on_message("ATV2", handover()), Book) == []


def test_no_more_is_booked_than_it_was_to_bring_and_a_part_ends_nothing() -> None:
    rig = superseded()
    assert instructed(rig.on_message("ATV2", handover(quantity=10)), Book) == [replace(BROUGHT[0], change=10)]
    assert ended(rig.stocked("housing", 10, "ATV2")) == []
    rig = superseded()
    assert instructed(rig.on_message("ATV2", handover(quantity=240)), Book) == BROUGHT


def test_a_load_of_a_transport_that_nobody_needs_any_more_is_booked_too() -> None:
    rig = superseded()
    [task] = [each for each in rig.agent._flow.tasks if each.id == "M7-1"]
    rig.agent._flow.cancel(task)
    assert ended(booked(rig)) == []


def test_the_next_life_books_it_too() -> None:
    rig = reborn(superseded(), 3)
    beats(rig, "ATV2")
    assert ended(booked(rig)) == [("delivered", "ATV2")]


def test_a_vehicle_that_is_here_for_another_load_is_asked_to_tell_again() -> None:
    rig = superseded()
    rig.on_message("S1", StockAsked("S1-1", 1, "seal-kit", 1))
    assert instructed(rig.on_message("ATV2", Docked("S1-1", 1, "M7", "seal-kit", 1)), OpenDock)
    # A body shuts its dock when it books.
    effects = rig.on_message("ATV2", handover())
    assert (instructed(effects, Book), sent(effects, Superseded)) == ([], [])
    beats(rig, "ATV2")
    assert instructed(rig.on_message("ATV2", handover()), Book) == BROUGHT
