"""The station of a storage: what is promised lies there, and is fetched by whom it was promised to."""

from __future__ import annotations

import msgspec
import pytest
from defaults import KEYS, PLANT
from effects import committed, instructed, listening, sent
from msgspec import UNSET
from msgspec.structs import replace
from rigs import Rig
from spoken import rhb

from dray.body import Book, CloseDock, DockReady, Instruction, OpenDock, Refill, StockChanged, StorageState
from dray.memory import StationMemory
from dray.messages import (
    Docked,
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
from dray.protocol.runtime.events import Effect, Ignore, Instruct
from dray.protocol.station.station import Station
from dray.protocol.transports.dock_door import NOT_READY, SAFE_WITHIN_S
from dray.protocol.transports.reservations import LEASE_S, MAX_ASKED, QUEUED_S, REFUTED_S
from dray.protocol.transports.transport_flow import NOT_KEPT

SPEC = PLANT.storages["S1"]
ITEM = "shaft"


class StationRig(Rig):
    """The station of S1, with a storage of paper."""

    def __init__(self, stock: int = 100, incarnation: int = 1) -> None:
        super().__init__(Station("S1", PLANT, incarnation=incarnation))
        self.stock = {kept.material: 0 for kept in SPEC.stocks} | {ITEM: stock}
        self.seq = 0
        self.opened: dict[str, None] = {}
        self.answers, self.counts = False, True

    def sense(self) -> StorageState:
        return StorageState(
            stock=dict(self.stock),
            seq=self.seq,
            opened=tuple(self.opened),
            answers=self.answers,
            counts=self.counts,
        )

    def asks(self, task: str, quantity: int = 40, *, machine: str = "M8", epoch: int = 1) -> list[Effect]:
        return self.on_message(machine, StockAsked(task=task, epoch=epoch, item=ITEM, quantity=quantity))

    def docks(self, atv: str, task: str, *, epoch: int = 1, quantity: int = 40) -> list[Effect]:
        effects = self.on_message(
            atv, Docked(task=task, epoch=epoch, station="S1", item=ITEM, quantity=quantity)
        )
        self.opened |= {opening.vehicle: None for opening in instructed(effects, OpenDock)}
        return effects

    def changes(self, pieces: int, vehicle: str = "") -> list[Effect]:
        """The storage is refilled, or a vehicle has taken something out."""
        self.stock[ITEM] += pieces
        self.seq += 1
        self.opened.pop(vehicle, None)
        return self.report(StockChanged(item=ITEM, change=pieces, seq=self.seq, vehicle=vehicle))

    @property
    def level(self) -> StockLevel:
        """Of the shafts, as the newest heartbeat tells."""
        self.run(self.now_s)
        newest = self.heartbeats(StationHeartbeat)[-1]
        return next(level for level in newest.stocks if level.item == ITEM)


def started(stock: int = 100) -> StationRig:
    rig = StationRig(stock)
    rig.start()
    return rig


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
    rig.run(since_s + SAFE_WITHIN_S)
    assert {beat.dock_wait for beat in rig.heartbeats(StationHeartbeat)} == {UNSET}
    rig.docks("ATV2", "M8-1")
    rig.run(rig.now_s + 6.0)
    assert rig.heartbeats(StationHeartbeat)[-1].dock_wait == DockWait(vehicle="ATV2", since_s=since_s)
    rig.report(DockReady(vehicle="ATV2"))
    rig.run(rig.now_s)
    assert rig.heartbeats(StationHeartbeat)[-1].dock_wait is UNSET


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


# --- what is brought back ---


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
    """All that the body was told."""
    return [effect.instruction for effect in effects if isinstance(effect, Instruct)]


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
