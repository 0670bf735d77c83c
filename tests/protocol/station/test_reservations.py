"""Reservations at a station: what is promised lies there, and is fetched by the vehicle of that task."""

from __future__ import annotations

import msgspec
import pytest
from defaults import KEYS
from effects import committed, instructed, listening, sent
from msgspec import UNSET
from msgspec.structs import replace
from spoken import rhb
from station_rig import ITEM, StationRig, started

from dray.body import Book, CloseDock, DockReady, OpenDock, Refill
from dray.memory import StationMemory
from dray.messages import (
    DockHeld,
    DockOpened,
    Phase,
    StationHeartbeat,
    StockAsked,
    StockFreed,
    StockLevel,
    StockReserved,
    StockShort,
)
from dray.messages.base import COUNT_MAX
from dray.messages.heartbeat import DockWait
from dray.protocol.runtime.events import Effect, Ignore
from dray.protocol.transports.dock_door import NOT_READY, SAFE_WITHIN_S
from dray.protocol.transports.reservations import LEASE_S, MAX_ASKED, QUEUED_S, REFUTED_S


def test_it_tells_what_lies_there_and_what_is_promised() -> None:
    rig = started()
    assert rig.level == StockLevel(item=ITEM, level=100, capacity=400)
    rig.asks("M8-1")
    assert rig.level == StockLevel(item=ITEM, level=100, capacity=400, promised=40)
    assert listening(rig.all) == {KEYS.closures, KEYS.all_free}


def test_what_is_promised_is_not_promised_again() -> None:
    rig = started(100)
    assert sent(rig.asks("M8-1"), StockReserved, to="M8") == [StockReserved("M8-1", 1, ITEM, 40)]
    assert len(sent(rig.asks("M8-2"), StockReserved, to="M8")) == 1
    effects = rig.asks("M9-1", machine="M9")
    assert sent(effects, StockReserved) == []
    assert sent(effects, StockShort, to="M9") == [StockShort("M9-1", 1, ITEM, 20)]
    assert instructed(effects, Refill) == [Refill(item=ITEM)]
    assert (rig.level.promised, rig.level.wanted) == (80, 40)


def test_who_has_asked_first_is_served_first_and_nobody_smaller_overtakes() -> None:
    rig = started(30)
    rig.asks("M8-1", 40)
    assert sent(rig.asks("M9-1", 10, machine="M9"), StockReserved) == []
    effects = rig.changes(10)
    assert [message.task for message in sent(effects, StockReserved)] == ["M8-1"]
    assert [message.task for message in sent(rig.changes(10), StockReserved)] == ["M9-1"]


def test_asking_again_promises_nothing_more() -> None:
    rig = started(100)
    rig.asks("M8-1")
    assert len(sent(rig.asks("M8-1"), StockReserved)) == 1
    assert rig.level.promised == 40


def test_a_reservation_lapses_when_nobody_asks_again() -> None:
    rig = started(40)
    rig.asks("M8-1")
    rig.asks("M9-1", machine="M9")
    for _ in range(20):
        rig.run(rig.now_s + QUEUED_S - 1.0)
        if rig.now_s > LEASE_S:
            break
        rig.asks("M9-1", machine="M9")
    assert [message.task for message in sent(rig.all, StockReserved, to="M9")] == ["M9-1"]


def test_a_reservation_that_is_renewed_does_not_lapse() -> None:
    rig = started(40)
    for _ in range(5):
        rig.asks("M8-1")
        rig.run(rig.now_s + LEASE_S - 1.0)
    assert rig.level.promised == 40


def test_a_place_in_the_queue_lapses_when_nobody_asks_again() -> None:
    rig = started(0)
    rig.asks("M8-1")
    rig.run(QUEUED_S + 1.0)
    assert sent(rig.changes(100), StockReserved) == []


def where_the_dock_takes_time() -> StationRig:
    rig = StationRig()
    rig.answers = True
    rig.start()
    rig.asks("M8-1")
    return rig


def test_where_the_dock_takes_time_to_open_a_vehicle_loads_when_it_is_ready() -> None:
    rig = where_the_dock_takes_time()
    effects = rig.docks("ATV2", "M8-1")
    assert instructed(effects, OpenDock)
    assert [held.reason for held in sent(effects, DockHeld, to="ATV2")] == [NOT_READY]
    assert sent(rig.report(DockReady(vehicle="ATV7")), DockOpened) == []
    assert sent(rig.report(DockReady(vehicle="ATV2")), DockOpened, to="ATV2")


def test_a_dock_that_does_not_get_ready_is_told_by_the_station() -> None:
    rig = where_the_dock_takes_time()
    rig.docks("ATV2", "M8-1")
    since_s = rig.now_s
    while rig.now_s < since_s + SAFE_WITHIN_S:
        rig.run(rig.now_s + 5.0)
        rig.docks("ATV2", "M8-1")
    assert {beat.dock_wait for beat in rig.heartbeats(StationHeartbeat)} == {UNSET}
    rig.run(rig.now_s + 6.0)
    assert rig.heartbeats(StationHeartbeat)[-1].dock_wait == DockWait(vehicle="ATV2", since_s=since_s)
    rig.report(DockReady(vehicle="ATV2"))
    rig.run(rig.now_s)
    assert rig.heartbeats(StationHeartbeat)[-1].dock_wait is UNSET


def asks_in_vain(rig: StationRig, atv: str, task: str, span_s: float) -> None:
    """A vehicle asks every five seconds for a dock that does not open, and then has left for other work."""
    rig.asks(task, 20)
    until_s = rig.now_s + span_s
    while rig.now_s < until_s:
        rig.docks(atv, task, quantity=20)
        rig.run(rig.now_s + 5.0)


def test_a_dock_at_which_one_vehicle_after_the_other_gives_up_is_told_although_none_waits_for_long() -> None:
    rig = where_the_dock_takes_time()
    asks_in_vain(rig, "ATV2", "M8-2", 30.0)
    rig.on_message("M8", StockFreed("M8-2"))
    asks_in_vain(rig, "ATV3", "M8-3", 30.0)
    rig.on_message("M8", StockFreed("M8-3"))
    assert {beat.dock_wait for beat in rig.heartbeats(StationHeartbeat)} == {UNSET}
    asks_in_vain(rig, "ATV4", "M8-4", 20.0)
    [wait] = {beat.dock_wait for beat in rig.heartbeats(StationHeartbeat)} - {UNSET}
    assert wait == DockWait(vehicle="ATV4", since_s=10.0)


def test_a_dock_that_has_opened_in_between_is_given_its_time_again() -> None:
    rig = where_the_dock_takes_time()
    asks_in_vain(rig, "ATV2", "M8-2", 50.0)
    rig.report(DockReady(vehicle="ATV2"))
    rig.on_message("M8", StockFreed("M8-2"))
    asks_in_vain(rig, "ATV3", "M8-3", 40.0)
    assert {beat.dock_wait for beat in rig.heartbeats(StationHeartbeat)} == {UNSET}


def test_a_station_that_begins_anew_while_its_dock_opens_keeps_what_is_promised() -> None:
    first = where_the_dock_takes_time()
    first.docks("ATV2", "M8-1")
    rig = StationRig(incarnation=2)
    rig.answers, rig.opened, rig.memory = True, {"ATV2": None}, committed(first.all)
    rig.start()
    assert rig.level.promised == 40
    rig.docks("ATV2", "M8-1")
    assert sent(rig.report(DockReady(vehicle="ATV2")), DockOpened, to="ATV2")


def blind() -> StationRig:
    """A station whose body does not count; a vehicle stands there to fetch 40."""
    rig = StationRig()
    rig.counts = False
    rig.start()
    rig.asks("M8-1")
    rig.docks("ATV2", "M8-1")
    return rig


def carries(rig: StationRig) -> list[Effect]:
    rig.run(rig.now_s + 1.0)
    beat = rhb("ATV2", 100, rig.now_s, task="M8-1")
    assert beat.task is not None
    return rig.on_message("ATV2", replace(beat, task=replace(beat.task, phase=Phase.CARRYING)))


def test_where_the_body_does_not_count_a_load_is_booked_out_when_its_vehicle_has_it() -> None:
    rig = blind()
    assert instructed(carries(rig), Book) == [Book("ATV2", ITEM, -40, task="M8-1", epoch=1)]
    rig.changes(-40, "ATV2")
    assert (rig.level.level, rig.level.promised) == (60, 0)


def test_where_the_body_does_not_count_the_next_life_books_what_was_being_fetched() -> None:
    first = blind()
    rig = StationRig(incarnation=2)
    rig.counts, rig.opened, rig.memory = False, {"ATV2": None}, committed(first.all)
    rig.start()
    assert instructed(carries(rig), Book) == [Book("ATV2", ITEM, -40, task="M8-1", epoch=1)]


def test_what_is_given_back_goes_to_the_next() -> None:
    rig = started(40)
    rig.asks("M8-1")
    rig.asks("M9-1", machine="M9")
    assert rig.on_message("M9", StockFreed(task="M8-1"))[-1] == Ignore(
        "a release of a reservation that the sender does not have"
    )
    assert [
        message.task for message in sent(rig.on_message("M8", StockFreed(task="M8-1")), StockReserved)
    ] == ["M9-1"]


def test_the_dock_opens_for_what_was_promised_and_the_reservation_ends_with_the_fetching() -> None:
    rig = started(100)
    rig.asks("M8-1")
    effects = rig.docks("ATV1", "M8-1")
    assert instructed(effects, OpenDock) == [OpenDock(vehicle="ATV1", item=ITEM, quantity=40)]
    assert len(sent(effects, DockOpened, to="ATV1")) == 1
    rig.changes(-40, "ATV1")
    assert rig.level == StockLevel(item=ITEM, level=60, capacity=400)
    assert sent(rig.asks("M8-1"), StockReserved) == [], "a renewal that was under way"
    assert len(sent(rig.asks("M8-1", epoch=2), StockReserved)) == 1, "its carrier has failed with the load"


def test_who_has_asked_for_a_later_carrier_asks_for_other_pieces_when_the_earlier_one_has_fetched_these() -> (
    None
):
    rig = started(100)
    rig.asks("M8-1")
    rig.docks("ATV1", "M8-1")
    assert sent(rig.asks("M8-1", epoch=2), StockReserved)
    rig.changes(-40, "ATV1")
    assert rig.level.promised == 0
    assert sent(rig.asks("M8-1"), StockReserved) == []
    assert sent(rig.asks("M8-1", epoch=2), StockReserved)
    assert (rig.level.level, rig.level.promised) == (60, 40)


def test_what_is_promised_to_others_is_not_given_to_a_vehicle_without_a_reservation() -> None:
    rig = started(50)
    rig.asks("M8-1")
    effects = rig.docks("ATV2", "M9-1")
    assert instructed(effects, OpenDock) == []
    assert [held.reason for held in sent(effects, DockHeld, to="ATV2")] == ["S1 has no shaft"]
    assert instructed(effects, Refill) == [Refill(item=ITEM)]


def test_a_vehicle_at_the_dock_goes_before_all_who_wait() -> None:
    rig = started(0)
    rig.asks("M8-1")
    rig.docks("ATV2", "M9-1")
    assert sent(rig.changes(40), StockReserved) == []
    assert len(sent(rig.docks("ATV2", "M9-1"), DockOpened)) == 1


def test_what_a_vehicle_that_has_left_the_dock_waited_for_goes_to_others() -> None:
    rig = started(0)
    rig.docks("ATV2", "M9-1")
    rig.run(20.0)
    rig.asks("M8-1")
    rig.run(QUEUED_S + 1.0)
    rig.asks("M8-1")
    assert len(sent(rig.changes(40), StockReserved, to="M8")) == 1


def test_a_second_vehicle_of_the_same_epoch_waits_and_one_of_a_higher_epoch_replaces_the_first() -> None:
    rig = started(100)
    rig.asks("M8-1")
    rig.docks("ATV1", "M8-1")
    assert [held.reason for held in sent(rig.docks("ATV2", "M8-1"), DockHeld)] == [
        "another vehicle fetches it"
    ]
    effects = rig.docks("ATV2", "M8-1", epoch=2)
    assert instructed(effects, CloseDock) == [CloseDock(vehicle="ATV1")]
    assert len(sent(effects, DockOpened, to="ATV2")) == 1


@pytest.mark.parametrize("reserved", [True, False], ids=["set aside", "waiting"])
def test_an_epoch_of_the_far_future_gets_no_load_and_keeps_it_from_no_carrier(reserved: bool) -> None:
    """Any vehicle can state it, for any task."""
    rig = started(100 if reserved else 0)
    rig.asks("M8-1")
    assert sent(rig.docks("ATV9", "M8-1", epoch=COUNT_MAX), DockOpened) == []
    rig.changes(100)
    assert len(sent(rig.docks("ATV1", "M8-1"), DockOpened, to="ATV1")) == 1
    rig.changes(-40, "ATV1")
    assert len(sent(rig.asks("M8-1", epoch=2), StockReserved)) == 1, "its carrier has failed with the load"


def test_a_vehicle_that_states_a_higher_epoch_keeps_the_dock_until_the_coordinator_names_the_lower_one() -> (
    None
):
    rig = started(100)
    rig.asks("M8-1")
    assert len(sent(rig.docks("ATV9", "M8-1", epoch=2), DockOpened)) == 1, "its takeover may be under way"
    rig.run(rig.now_s + 5.0)
    rig.asks("M8-1")
    assert sent(rig.docks("ATV1", "M8-1"), DockOpened) == []
    rig.run(rig.now_s + REFUTED_S)
    rig.asks("M8-1")
    effects = rig.docks("ATV1", "M8-1")
    assert instructed(effects, CloseDock) == [CloseDock(vehicle="ATV9")]
    assert len(sent(effects, DockOpened, to="ATV1")) == 1


def test_promises_that_cannot_be_kept_are_taken_back_the_latest_first() -> None:
    rig = started(80)
    rig.asks("M8-1")
    rig.asks("M9-1", machine="M9")
    effects = rig.changes(-40)
    assert [(message.task, message.free) for message in sent(effects, StockShort)] == [("M9-1", 0)]
    assert rig.level.promised == 40 == rig.level.level


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"item": "gold"}, "a request for material that is not kept here"),
        ({"quantity": 0}, "a request for material that is not kept here"),
        ({"quantity": 401}, "a request for material that is not kept here"),
    ],
)
def test_what_can_never_be_is_not_answered(changes: dict[str, object], reason: str) -> None:
    rig = started()
    asked = msgspec.structs.replace(StockAsked("M8-1", 1, ITEM, 40), **changes)
    assert rig.on_message("M8", asked) == [Ignore(reason)]


def test_nobody_takes_over_another_ones_reservation() -> None:
    rig = started()
    rig.asks("M8-1")
    assert rig.asks("M8-1", machine="M9") == [
        Ignore("a request that differs from the first one for its task, or comes from another agent")
    ]


def test_one_that_invents_tasks_is_bounded() -> None:
    rig = started(400)
    for number in range(MAX_ASKED):
        rig.asks(f"M8-{number}", 1)
    assert rig.asks("M8-one-more", 1) == [Ignore("a request above the limit of one coordinator")]
    assert len(sent(rig.asks("M9-1", 1, machine="M9"), StockReserved)) == 1


def test_a_promise_outlives_a_restart() -> None:
    rig = started(100)
    rig.asks("M8-1")
    rig.asks("M8-2")
    rig.docks("ATV2", "M8-2")
    again = StationRig(100, incarnation=2)
    again.memory, again.opened = committed(rig.all), {"ATV2": None}
    again.start()
    assert again.level.promised == 80
    assert sent(again.asks("M9-1", machine="M9"), StockReserved) == []
    assert len(sent(again.docks("ATV1", "M8-1"), DockOpened)) == 1


def test_what_was_fetched_while_it_was_away_is_promised_no_more() -> None:
    rig = started(100)
    rig.asks("M8-1")
    rig.docks("ATV1", "M8-1")
    again = StationRig(60, incarnation=2)
    again.memory = committed(rig.all)
    again.start()
    assert again.level == StockLevel(item=ITEM, level=60, capacity=400)
    assert sent(again.asks("M8-1"), StockReserved) == []


def test_a_promise_is_written_down_before_it_is_said() -> None:
    effects = started().asks("M8-1")
    [note] = committed(effects).values()
    assert isinstance(note, StationMemory)
    assert [reserved.task for reserved in note.reserved] == ["M8-1"]


def test_asked_to_leave_it_promises_nothing_more_and_waits_for_the_vehicle_at_its_dock() -> None:
    rig = started(100)
    rig.asks("M8-1")
    rig.docks("ATV1", "M8-1")
    rig.leave()
    assert not rig.has_left
    assert rig.asks("M8-2") == [Ignore("a request while the station is draining")]
    rig.changes(-40, "ATV1")
    assert rig.has_left
