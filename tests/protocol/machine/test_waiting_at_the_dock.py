"""A vehicle that has only waited for the dock has moved nothing, as far as the notes of the machine's agent reach."""

from __future__ import annotations

from collections.abc import Callable

import msgspec
import pytest
from effects import committed, instructed, published, sent
from lathe1 import TASK, before_a_shut_dock, opens
from m7 import FULL, NO_HOUSINGS, docked, hiring
from msgspec.structs import replace
from next_life import next_life
from rigs import BlindRig, MachineRig
from spoken import production, rhb

from dray.body import Book, CloseDock, DockReady, OpenDock
from dray.memory import WHOLE, DepartureMemory, MachineMemory, Memory, visits_of
from dray.messages import (
    DockHeld,
    DockOpened,
    HelpCall,
    StockFreed,
    TaskAnnounced,
    Transport,
)
from dray.protocol.liveness.failure_detector import UNNAMED_S

CART = "ATV2"
SHUT = [CloseDock(vehicle=CART)]


def fetching() -> MachineRig:
    """ATV2 stands at M7 for 24 pumps, and waits for the dock to open. The body does not count."""
    rig = BlindRig("M7", FULL)
    rig.answers = True
    rig.start()
    rig.take_goal("G1", production(quantity=24))
    rig.cycles(24)
    rig.hire(lot(rig), CART)
    return waiting(rig, lot(rig))


def bringing() -> MachineRig:
    """ATV2 stands at M7 with 24 housings, and waits for the dock to open. The body does not count."""
    return waiting(hiring(BlindRig("M7", NO_HOUSINGS), CART, answers=True), "M7-1")


def waiting(rig: MachineRig, task: str) -> MachineRig:
    effects = rig.on_message(CART, docked(task))
    assert instructed(effects, OpenDock)
    assert sent(effects, DockHeld, to=CART)
    return rig


def lot(rig: MachineRig) -> str:
    """The transport of the pumps."""
    works = [each for each in published(rig.all, TaskAnnounced) if isinstance(each.work, Transport)]
    return next(each.task for each in works if each.work.item == "pump-p3")


def works_elsewhere(rig: MachineRig) -> None:
    """ATV2 is heard far away without the task, for longer than a message can take."""
    until_s = rig.now_s + UNNAMED_S + 2.0
    while rig.now_s < until_s:
        rig.run(rig.now_s + 1.0)
        beat = rhb(CART, 1000 + int(rig.now_s), rig.now_s, task="M8-1", coordinator="M8")
        rig.on_message(CART, replace(beat, node="c1"))


def is_sought(rig: MachineRig, task: str) -> bool:
    """Whether another carrier was sought."""
    return any((each.task, each.epoch) == (task, 2) for each in published(rig.all, TaskAnnounced))


def older(memory: Memory) -> Memory:
    """The notes of a version that did not tell who waits."""
    note = memory[WHOLE]
    assert isinstance(note, MachineMemory)
    return {**memory, WHOLE: replace(note, visits=())}


@pytest.mark.parametrize("lives", [1, 2, 3])
def test_goods_that_its_vehicle_only_waited_for_are_not_booked_out_by_a_later_life(lives: int) -> None:
    rig = fetching()
    task = lot(rig)
    for _ in range(lives):
        rig = next_life(rig, opened=(CART,))
    # The body opens it only now, and nobody waits any more.
    assert not sent(rig.report(DockReady(vehicle=CART)), DockOpened)
    works_elsewhere(rig)
    assert (instructed(rig.all, Book), instructed(rig.all, CloseDock)) == ([], SHUT)
    assert is_sought(rig, task)
    assert rig.reported_stock()[1][0].level == 24


@pytest.mark.parametrize(
    ("begins", "notes"),
    [
        (lambda rig: rig.report(DockReady(vehicle=CART)), lambda memory: memory),
        (lambda _: None, older),
    ],
)
def test_goods_are_booked_out_in_doubt_if_their_vehicle_was_let_in_or_older_notes_do_not_tell(
    begins: Callable[[MachineRig], object], notes: Callable[[Memory], Memory]
) -> None:
    first = fetching()
    begins(first)
    rig = next_life(first, opened=(CART,), memory=notes(committed(first.all)))
    works_elsewhere(rig)
    assert instructed(rig.all, Book) == [Book(CART, "pump-p3", -24, task=lot(first), epoch=1)]


@pytest.mark.parametrize("was_let_in", [False, True])
def test_a_coordinator_without_notes_is_believed_only_about_a_vehicle_that_was_let_in(
    *, was_let_in: bool
) -> None:
    first = before_a_shut_dock(cart=CART)
    if was_let_in:
        opens(first, CART)
    rig = next_life(first, opened=(CART,))
    works_elsewhere(rig)
    rig.on_message("PRESS1", StockFreed(TASK, fetched=True))
    taken = [Book(CART, "shaft", -6, task=TASK, epoch=1)]
    assert SHUT[0] in instructed(rig.all, CloseDock)
    assert instructed(rig.all, Book) == (taken if was_let_in else [])


def test_it_is_noted_that_a_vehicle_is_let_in_before_it_hears_that() -> None:
    first = fetching()
    effects = first.report(DockReady(vehicle=CART))
    assert sent(effects, DockOpened, to=CART)
    note = committed(effects)[WHOLE]
    assert isinstance(note, MachineMemory)
    assert not [each for each in note.visits if each.only_waits]


def test_nobody_is_asked_for_a_load_whose_vehicle_only_waited_to_bring_it() -> None:
    rig = next_life(bringing(), opened=(CART,))
    works_elsewhere(rig)
    assert is_sought(rig, "M7-1")
    assert (instructed(rig.all, Book), published(rig.all, HelpCall)) == ([], [])


def test_who_waits_still_is_let_in_by_the_next_life() -> None:
    first = fetching()
    rig = waiting(next_life(first, opened=(CART,)), lot(first))
    assert sent(rig.report(DockReady(vehicle=CART)), DockOpened, to=CART)
    works_elsewhere(later := next_life(rig, opened=(CART,)))
    assert instructed(later.all, Book) == [Book(CART, "pump-p3", -24, task=lot(first), epoch=1)]


def test_who_waited_is_unknown_once_the_body_opens_for_it_no_more() -> None:
    rig = next_life(fetching())
    assert not rig.agent._flow.visits.is_here(CART)


def test_what_an_older_version_has_noted_of_loads_to_take_and_of_vehicles_that_leave_is_read() -> None:
    taken = {"task": "P-1", "epoch": 1, "item": "shaft", "quantity": 6, "coordinator": "P", "vehicle": "ATV1"}
    written = {
        "kind": "machine",
        "let_in": [
            taken | {"opened": 2},
            taken | {"vehicle": "ATV2", "opened": 3, "ended": True, "gone": True},
        ],
        "leaving": [
            {"vehicle": "ATV1"},
            {"vehicle": "ATV3", "task": "M7-1", "epoch": 1, "item": "housing", "change": 24},
            {"vehicle": "ATV2", "task": "M7-2", "epoch": 1, "item": "housing", "change": 24, "gone": True},
        ],
    }
    note = msgspec.convert(written, MachineMemory)
    assert visits_of(note) == (
        DepartureMemory("ATV1", "P-1", 2, "shaft", -6, coordinator="P"),
        DepartureMemory(
            "ATV2", "P-1", 3, "shaft", -6, gone=True, permitted=True, coordinator="P", ended=True
        ),
        DepartureMemory("ATV3", "M7-1", 1, "housing", 24),
        DepartureMemory("ATV2", "M7-2", 1, "housing", 24, gone=True),
    )
    again = msgspec.convert(msgspec.to_builtins(MachineMemory(visits=visits_of(note))), MachineMemory)
    assert visits_of(again) == visits_of(note)
