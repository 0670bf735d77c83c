"""Loads that vehicles bring back to a station: who may put one down, when it is booked, and that it is booked once."""

from __future__ import annotations

import msgspec
import pytest
from defaults import PLANT
from effects import committed, instructed, sent
from msgspec import UNSET
from msgspec.structs import replace
from spoken import rhb
from station_rig import ITEM, StationRig

from dray.body import Book, CloseDock, DockReady, FillTo, Instruction, OpenDock
from dray.messages import Docked, DockOpened, Phase, StationHeartbeat, StockFreed
from dray.messages.heartbeat import DockWait
from dray.protocol.runtime.events import Effect, Ignore, Instruct
from dray.protocol.transports.dock_door import SAFE_WITHIN_S
from dray.protocol.transports.transport_flow import NOT_KEPT


def brought_back(*, counts: bool, answers: bool = True) -> tuple[StationRig, list[Effect]]:
    """ATV1 stands at the dock with 40 shafts that nobody wants any more; the dock makes itself safe where it answers."""
    rig = StationRig()
    rig.answers, rig.counts = answers, counts
    rig.start()
    back = Docked(task="M8-1", epoch=1, station="S1", item=ITEM, quantity=40, returns=True)
    return rig, rig.on_message("ATV1", back)


def returns(rig: StationRig, *, aboard: bool, ended: bool = False, node: str = "") -> list[Effect]:
    """ATV1 tells how far it is."""
    rig.run(rig.now_s + 1.0)
    beat = rhb("ATV1", 100 + int(rig.now_s), rig.now_s, task="M8-1")
    assert beat.task is not None
    brief = None if ended else msgspec.structs.replace(beat.task, phase=Phase.RETURNING)
    where = node or PLANT.node_of("S1")
    load, quantity = (ITEM, 40) if aboard else ("", 0)
    said = msgspec.structs.replace(beat, task=brief, node=where, load=load, load_quantity=quantity)
    return rig.on_message("ATV1", said)


def test_a_body_that_counts_and_opens_at_once_takes_what_is_brought_back_without_a_question() -> None:
    _, effects = brought_back(counts=True, answers=False)
    assert sent(effects, DockOpened, to="ATV1") == [DockOpened("M8-1", 1, "S1")]
    assert instructed(effects, OpenDock) == []


def test_a_body_that_counts_and_makes_its_dock_safe_is_asked_for_what_is_brought_back() -> None:
    rig, effects = brought_back(counts=True)
    assert (sent(effects, DockOpened), instructed(effects, OpenDock)) == ([], [OpenDock("ATV1", ITEM, 40)])
    assert sent(rig.report(DockReady("ATV1")), DockOpened, to="ATV1")
    returns(rig, aboard=True)
    rig.changes(40, "ATV1")
    effects = returns(rig, aboard=False, ended=True)
    assert (instructed(effects, Book), instructed(effects, CloseDock)) == ([], [CloseDock("ATV1")])


def test_where_the_body_does_not_count_what_is_brought_back_gets_a_permit_and_is_booked_in() -> None:
    rig, effects = brought_back(counts=False)
    assert sent(effects, DockOpened) == []
    assert instructed(effects, OpenDock) == [OpenDock("ATV1", ITEM, 40)]
    assert sent(rig.report(DockReady("ATV1")), DockOpened, to="ATV1")
    assert instructed(returns(rig, aboard=True), CloseDock) == []
    effects = returns(rig, aboard=False, ended=True)
    assert instructed(effects, Book) == [Book("ATV1", ITEM, 40, task="M8-1", epoch=1)]
    assert instructed(effects, CloseDock) == [CloseDock("ATV1")]
    rig.changes(40, "ATV1")
    assert rig.level.level == 140


def test_a_vehicle_that_goes_elsewhere_with_what_it_brings_back_is_not_booked_in() -> None:
    rig, _ = brought_back(counts=False)
    rig.report(DockReady("ATV1"))
    effects = returns(rig, aboard=True, node="c1")
    assert (instructed(effects, Book), instructed(effects, CloseDock)) == ([], [CloseDock("ATV1")])


def test_the_next_life_books_in_what_was_brought_back_to_this_one() -> None:
    first, _ = brought_back(counts=False)
    first.report(DockReady("ATV1"))
    rig = StationRig(incarnation=2)
    rig.answers, rig.counts, rig.opened = True, False, {"ATV1": None}
    rig.memory = committed(first.all)
    rig.start()
    assert instructed(returns(rig, aboard=True), Book) == []
    assert instructed(returns(rig, aboard=False, ended=True), Book)


def test_the_next_life_does_not_book_in_what_it_has_not_seen_at_its_dock() -> None:
    first, _ = brought_back(counts=False)
    rig = StationRig(incarnation=2)
    rig.answers, rig.counts, rig.opened = True, False, {"ATV1": None}
    rig.memory = committed(first.all)
    rig.start()
    effects = returns(rig, aboard=False, ended=True)
    assert (instructed(effects, Book), instructed(effects, CloseDock)) == ([], [CloseDock("ATV1")])


@pytest.mark.parametrize(("item", "quantity"), [("ghost", 40), (ITEM, 401), (ITEM, 0)])
def test_what_cannot_lie_here_is_put_down_and_not_booked(item: str, quantity: int) -> None:
    rig = StationRig()
    rig.answers, rig.counts = True, False
    rig.start()
    effects = rig.on_message("ATV1", replace(BACK, item=item, quantity=quantity))
    assert Ignore(NOT_KEPT) in effects
    assert told(effects) == [OpenDock("ATV1", item, quantity)]
    assert sent(rig.report(DockReady("ATV1")), DockOpened, to="ATV1")
    returns(rig, aboard=True)
    assert told(returns(rig, aboard=False, ended=True)) == [CloseDock("ATV1")]


def cancelled_while_it_loads() -> tuple[StationRig, list[Effect]]:
    """ATV1 was let in to load 40 shafts for M8; they are given back, and it has them: it asks to put them down where it stands."""
    rig = StationRig()
    rig.answers, rig.counts = True, False
    rig.start()
    rig.asks("M8-1")
    rig.docks("ATV1", "M8-1")
    assert sent(rig.report(DockReady("ATV1")), DockOpened)
    assert instructed(rig.on_message("M8", StockFreed("M8-1")), CloseDock) == []
    return rig, rig.on_message("ATV1", BACK)


BACK = Docked(task="M8-1", epoch=1, station="S1", item=ITEM, quantity=40, returns=True)
OUT, IN = Book("ATV1", ITEM, -40, task="M8-1", epoch=1), Book("ATV1", ITEM, 40, task="M8-1", epoch=1)


def told(effects: list[Effect]) -> list[Instruction]:
    """All that the body was told of its dock and of loads."""
    said = [effect.instruction for effect in effects if isinstance(effect, Instruct)]
    return [each for each in said if not isinstance(each, FillTo)]


def test_what_is_put_back_where_it_was_loaded_is_booked_out_before_the_dock_is_opened_for_it() -> None:
    rig, effects = cancelled_while_it_loads()
    assert told(effects) == [OUT, OpenDock("ATV1", ITEM, 40)]
    rig.changes(-40, "ATV1")
    assert sent(rig.report(DockReady("ATV1")), DockOpened, to="ATV1")
    # Its forks are inside: nothing more is booked, and the dock stays open.
    assert told(returns(rig, aboard=True)) == []


def test_what_is_put_back_where_it_was_loaded_is_booked_in_again() -> None:
    rig, _ = cancelled_while_it_loads()
    rig.changes(-40, "ATV1")
    rig.report(DockReady("ATV1"))
    returns(rig, aboard=True)
    effects = returns(rig, aboard=False, ended=True)
    assert (instructed(effects, Book), instructed(effects, CloseDock)) == ([IN], [CloseDock("ATV1")])


def test_a_vehicle_that_asks_again_to_put_its_load_back_changes_nothing() -> None:
    rig, _ = cancelled_while_it_loads()
    rig.changes(-40, "ATV1")
    assert told(rig.on_message("ATV1", BACK)) == [OpenDock("ATV1", ITEM, 40)]


def test_a_vehicle_that_gives_up_waiting_for_the_dock_is_no_alarm_any_more() -> None:
    rig, _ = brought_back(counts=False)
    rig.run(rig.now_s + SAFE_WITHIN_S + 10.0)
    assert isinstance(rig.heartbeats(StationHeartbeat)[-1].dock_wait, DockWait)
    assert told(returns(rig, aboard=True, node="c1")) == [CloseDock("ATV1")]
    rig.run(rig.now_s + 10.0)
    assert rig.heartbeats(StationHeartbeat)[-1].dock_wait is UNSET
    assert sent(rig.report(DockReady("ATV1")), DockOpened) == []


def test_what_a_person_takes_off_a_vehicle_before_the_dock_is_ready_was_not_put_down_there() -> None:
    rig, _ = brought_back(counts=False)
    returns(rig, aboard=True)
    effects = returns(rig, aboard=False, ended=True)
    assert (instructed(effects, Book), instructed(effects, CloseDock)) == ([], [CloseDock("ATV1")])


def test_what_is_put_down_is_booked_also_where_the_vehicle_has_asked_again_or_its_agent_was_killed() -> None:
    first, _ = brought_back(counts=False)
    first.report(DockReady("ATV1"))
    first.on_message("ATV1", BACK)
    rig = StationRig(incarnation=2)
    rig.answers, rig.counts, rig.opened = True, False, {"ATV1": None}
    rig.memory = committed(first.all)
    rig.start()
    returns(rig, aboard=True)
    assert instructed(returns(rig, aboard=False, ended=True), Book) == [IN]


def test_what_was_not_let_in_is_not_booked_by_the_next_life_either() -> None:
    first, _ = brought_back(counts=False)
    rig = StationRig(incarnation=2)
    rig.answers, rig.counts, rig.opened = True, False, {"ATV1": None}
    rig.memory = committed(first.all)
    rig.start()
    returns(rig, aboard=True)
    assert instructed(returns(rig, aboard=False, ended=True), Book) == []


def test_who_puts_back_something_else_keeps_the_dock_until_it_has_whatever_is_heard_of_its_load_before() -> (
    None
):
    rig = StationRig()
    rig.answers, rig.counts = True, False
    rig.start()
    rig.asks("M8-1")
    rig.docks("ATV1", "M8-1")
    rig.report(DockReady("ATV1"))
    rig.run(rig.now_s + 60.0)
    rig.on_message("ATV1", rhb("ATV1", 100, rig.now_s, task="M9-1"))
    # Nobody has said yet whether it has fetched the load for M8. It is booked before the dock is opened: a body that books shuts its dock.
    effects = rig.on_message("ATV1", replace(BACK, task="M9-1", item="other"))
    assert told(effects) == [OUT, OpenDock("ATV1", "other", 40)]
    rig.report(DockReady("ATV1"))
    assert told(rig.on_message("M8", StockFreed("M8-1", fetched=True))) == []
