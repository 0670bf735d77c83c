"""A load of which nobody can tell is not in the books, and a person is asked to count."""

from __future__ import annotations

import pytest
from dock_parts import blind_dock
from effects import facts, instructed, published, sent
from m7 import NO_HOUSINGS, handover
from msgspec.structs import replace
from next_life import next_life
from rigs import BlindRig, MachineRig
from seals import granted
from spoken import rhb

from dray.body import Book, DockReady, OpenDock
from dray.memory import DepartureMemory
from dray.messages import (
    CallState,
    CommandAnswered,
    CommandRefusal,
    Docked,
    DoubtfulLoad,
    HelpCall,
    MachineCommand,
    MachineCommandKind,
    MachineHeartbeat,
    Phase,
    StockAsked,
    StockFreed,
)
from dray.messages.fact import LoadDoubted
from dray.protocol.runtime.life import Life
from dray.protocol.transports.doubts import ASKS_AFTER_S
from dray.protocol.transports.visit import UNHEARD_S

KIND = MachineCommandKind
PUMPS = "pump-p3"
NAME = "M7.2-load-1"
TAKEN = DoubtfulLoad(NAME, "ATV2", PUMPS, 8)
BROUGHT = DoubtfulLoad(NAME, "ATV2", "housing", 24, brought=True)
OUT = Book("ATV2", PUMPS, -8, task="", epoch=2)
TICKS_S = 6.0
"""Longer than an idle machine's heartbeat interval."""


def without_notes(item: str = PUMPS, quantity: int = 8, *, counts: bool = False) -> MachineRig:
    """M7 has lost its notes; its body knows that it let ATV2 in."""
    stock = NO_HOUSINGS | {PUMPS: 8}
    rig = (MachineRig if counts else BlindRig)("M7", stock, incarnation=2)
    rig.answers, rig.opened, rig.let_in = True, ("ATV2",), OpenDock("ATV2", item, quantity)
    rig.start()
    return rig


def elsewhere(rig: MachineRig, *, load: str = "", left_empty: str = "") -> None:
    """ATV2 is heard at another node without a task."""
    rig.run(rig.now_s + 1.0)
    beat = rhb("ATV2", 1000 + int(rig.now_s), rig.now_s)
    quantity = 8 if load else 0
    rig.on_message("ATV2", replace(beat, node="c1", load=load, load_quantity=quantity, left_empty=left_empty))


def asked(rig: MachineRig) -> tuple[DoubtfulLoad, ...]:
    """What the heartbeats ask for, once a vehicle that remembers would have told."""
    rig.run(rig.now_s + ASKS_AFTER_S + 2 * TICKS_S)
    return rig.heartbeats(MachineHeartbeat)[-1].doubts


def in_doubt() -> MachineRig:
    """8 pumps were booked out in doubt."""
    rig = without_notes()
    elsewhere(rig)
    assert instructed(rig.all, Book) == [OUT]
    rig.stocked(PUMPS, -8, "ATV2")
    assert asked(rig) == (TAKEN,)
    return rig


def owed() -> MachineRig:
    """24 housings were perhaps put down, and are not booked in."""
    rig = without_notes("housing", 24)
    rig.run(rig.now_s + 2 * UNHEARD_S)
    elsewhere(rig)
    assert asked(rig) == (BROUGHT,)
    return rig


def says(rig: MachineRig, kind: MachineCommandKind, name: str = NAME) -> CommandRefusal | None:
    """A person's word; why it was refused."""
    command = MachineCommand(command=f"C{len(rig.all)}", kind=kind, task=name, issued_by="Maria")
    [answer] = sent(rig.on_message("gateway", granted("M7", command)), CommandAnswered)
    return answer.reason


def calls(rig: MachineRig) -> list[HelpCall]:
    return [each for each in published(rig.all, HelpCall) if each.goods == NAME]


def ends(rig: MachineRig) -> bool:
    """Whether nobody is asked any more."""
    return asked(rig) == () and calls(rig)[-1].state is CallState.ENDED


def spare(rig: MachineRig) -> int:
    _, goods = rig.reported_stock()
    return sum(level.spare for level in goods if level.item == PUMPS)


def test_what_was_booked_out_in_doubt_is_told_to_people_until_one_has_looked() -> None:
    rig = in_doubt()
    assert facts(rig.all, LoadDoubted) == [LoadDoubted(NAME, "ATV2", PUMPS, 8, brought=False)]
    assert calls(rig)[-1].reason == "8 pump-p3 perhaps not taken by ATV2: count, they are not in the books"
    rig.run(rig.now_s + 1800.0)
    assert rig.heartbeats(MachineHeartbeat)[-1].doubts == (TAKEN,)
    assert len(facts(rig.all, LoadDoubted)) == 1


def test_a_load_that_a_person_has_found_is_booked_in_again_and_is_spare() -> None:
    rig = in_doubt()
    assert spare(rig) == 0
    assert says(rig, KIND.LOAD_THERE) is None
    found = Book("ATV2", PUMPS, 8, task=NAME, epoch=1)
    assert instructed(rig.all, Book) == [OUT, found]
    rig.stocked(PUMPS, 8, "ATV2")
    assert ends(rig)
    assert spare(rig) == 8
    assert says(rig, KIND.LOAD_THERE) is CommandRefusal.NOT_HELD


def test_a_load_that_a_person_has_not_found_stays_booked_out() -> None:
    rig = in_doubt()
    assert says(rig, KIND.LOAD_MISSING) is None
    assert ends(rig)
    assert instructed(rig.all, Book) == [OUT]


def test_what_was_perhaps_put_down_is_booked_in_once_a_person_has_found_it() -> None:
    rig = owed()
    assert calls(rig)[-1].reason == "24 housing perhaps put down by ATV2: count, they are not in the books"
    assert says(rig, KIND.LOAD_THERE) is None
    assert instructed(rig.all, Book) == [Book("ATV2", "housing", 24, task=NAME, epoch=1)]
    rig.stocked("housing", 24, "ATV2")
    assert ends(rig)
    assert instructed(rig.on_message("ATV2", handover()), Book) == []


def test_a_vehicle_that_tells_after_all_ends_the_doubt() -> None:
    rig = owed()
    assert instructed(rig.on_message("ATV2", handover()), Book) == [
        Book("ATV2", "housing", 24, task="M7-1", epoch=1)
    ]
    assert ends(rig)


def test_a_vehicle_that_tells_soon_is_believed_and_nobody_is_asked() -> None:
    rig = without_notes("housing", 24)
    rig.run(rig.now_s + 2 * UNHEARD_S)
    elsewhere(rig)
    rig.run(rig.now_s + ASKS_AFTER_S / 2)
    rig.on_message("ATV2", handover())
    assert asked(rig) == ()
    assert (facts(rig.all, LoadDoubted), calls(rig)) == ([], [])


@pytest.mark.parametrize(("load", "left_empty"), [(PUMPS, ""), ("", "m7")], ids=["took it", "left empty"])
def test_where_a_vehicle_has_told_nobody_is_asked(load: str, left_empty: str) -> None:
    rig = without_notes()
    elsewhere(rig, load=load, left_empty=left_empty)
    assert asked(rig) == ()


def test_where_a_body_counts_nobody_is_asked() -> None:
    rig = without_notes(counts=True)
    elsewhere(rig)
    assert asked(rig) == ()


@pytest.mark.parametrize("begin", [in_doubt, owed])
def test_the_next_life_asks_on_and_tells_no_history_twice(begin: object) -> None:
    assert callable(begin)
    before = begin()
    told = before.heartbeats(MachineHeartbeat)[-1].doubts
    rig = next_life(before)
    rig.run(rig.now_s + 2 * TICKS_S)
    assert (rig.heartbeats(MachineHeartbeat)[0].doubts, facts(rig.all, LoadDoubted)) == (told, [])
    assert says(rig, KIND.LOAD_THERE) is None
    assert len(instructed(rig.all, Book)) == 1


def fetched(rig: MachineRig, *, known: bool) -> list[Book]:
    """ATV2 was let in to load 8 seal kits for S1-1, and is heard much later elsewhere without the task. S1 has needed them no more."""
    lets_in(rig, "ATV2", "S1-1")
    rig.run(rig.now_s + 2 * UNHEARD_S)
    elsewhere(rig)
    effects = rig.on_message("S1", StockFreed("S1-1", fetched=True, known=known))
    rig.stocked("seal-kit", -8, "ATV2")
    return instructed(effects, Book)


def lets_in(rig: MachineRig, atv: str, task: str) -> None:
    """A vehicle is let in to load 8 seal kits."""
    rig.on_message("S1", StockAsked(task, 1, "seal-kit", 8))
    rig.on_message(atv, Docked(task, 1, "M7", "seal-kit", 8))
    rig.report(DockReady(vehicle=atv))


def with_notes() -> MachineRig:
    """M7's first life."""
    rig = BlindRig("M7", NO_HOUSINGS)
    rig.answers = True
    rig.start()
    return rig


@pytest.mark.parametrize(
    ("known", "doubted"), [(True, ()), (False, (DoubtfulLoad("M7-load-1", "ATV2", "seal-kit", 8),))]
)
def test_a_person_is_asked_only_where_the_coordinator_does_not_know(
    known: bool, doubted: tuple[DoubtfulLoad, ...]
) -> None:
    rig = with_notes()
    assert fetched(rig, known=known) == [Book("ATV2", "seal-kit", -8, task="S1-1", epoch=1)]
    assert asked(rig) == doubted


def test_nobody_counts_while_a_vehicle_moves_the_same_item() -> None:
    rig = with_notes()
    fetched(rig, known=False)
    doubted = asked(rig)
    lets_in(rig, "ATV3", "S1-2")
    for kind in (KIND.LOAD_THERE, KIND.LOAD_MISSING):
        assert says(rig, kind, "M7-load-1") is CommandRefusal.DOCK_OPEN
    assert asked(rig) == doubted


BROUGHT_BY_CART = DepartureMemory("CART", "T1", 1, "shaft", 6, let_in=False)
"""As far as is known the dock was not opened for it."""


@pytest.mark.parametrize(
    ("load", "is_in_doubt"),
    [
        pytest.param(BROUGHT_BY_CART, True, id="it stands there empty all the same"),
        pytest.param(
            replace(BROUGHT_BY_CART, task="", epoch=0), False, id="its vehicle will say for what it came"
        ),
        pytest.param(replace(BROUGHT_BY_CART, change=-6), False, id="it cannot have been taken"),
        pytest.param(replace(BROUGHT_BY_CART, returns=True), False, id="it was on its way back"),
    ],
)
def test_what_was_not_let_in_is_in_doubt_only_if_it_seems_to_be_down(
    load: DepartureMemory, *, is_in_doubt: bool
) -> None:
    _, visits = blind_dock("dock", Life())
    visits.answers = True
    visits.restore([load])
    beat = replace(rhb("CART", 1, 60.0, task="T9"), node="dock")
    assert beat.task is not None
    # Of one without a name its vehicle's task may be the one.
    beat = replace(beat, task=None if load.task else replace(beat.task, phase=Phase.APPROACHING))
    visits.on_vehicle(beat, 60.0)
    visits.on_vehicle(replace(beat, seq=2, node="elsewhere"), 120.0)
    assert visits.get("CART") is None
    assert bool(visits.doubts.memories()) is is_in_doubt


def test_what_waited_to_be_put_back_and_is_heard_elsewhere_is_not_in_doubt() -> None:
    _, visits = blind_dock("dock", Life())
    visits.answers = True
    visits.restore([replace(BROUGHT_BY_CART, returns=True)])
    visits.on_vehicle(replace(rhb("CART", 1, 60.0), node="elsewhere"), 60.0)
    assert visits.get("CART") is None
    assert visits.doubts.memories() == ()
