"""A storage that vehicles refill: it orders by reorder point and lot, once, and neither restarts nor lost warehouses make it order twice."""

from __future__ import annotations

import msgspec
import pytest
from defaults import PLANT
from effects import award_number, committed, instructed, published, sent
from rigs import Rig
from spoken import accepted, bid, rhb

from dray.body import Refill, StockChanged, StorageState
from dray.messages import (
    Brief,
    Docked,
    Handover,
    Phase,
    Role,
    StationHeartbeat,
    StockAsked,
    StockLevel,
    StockReserved,
    StockShort,
    TaskAnnounced,
    TransportOrdered,
)
from dray.plant import Plant, PlantFile, Stock, Warehouse
from dray.protocol.runtime.events import Effect
from dray.protocol.station.station import Station
from dray.protocol.transports.sourcing import ANSWER_S
from dray.protocol.transports.transports import RECOVERY_WAIT_S

ITEM, LOT = "shaft", PLANT.materials["shaft"].lot
CAPACITY, POINT = 5 * LOT, 2 * LOT


def with_two_warehouses(file: PlantFile) -> Plant:
    """S1 keeps shafts, and has them brought from two source warehouses."""
    source = next(each for each in file.warehouses if each.kind == "source")
    stocks = (Stock(ITEM, 100 * LOT),)
    second = Warehouse("SOURCE2", "Second", "source", PLANT.node_of("S3"), source.box, stocks=stocks)
    storages = tuple(
        msgspec.structs.replace(each, refill="vehicles", stocks=(Stock(ITEM, CAPACITY, POINT),))
        if each.id == "S1"
        else each
        for each in file.storages
    )
    warehouses = tuple(
        msgspec.structs.replace(each, stocks=stocks) if each is source else each for each in file.warehouses
    )
    return Plant(msgspec.structs.replace(file, storages=storages, warehouses=(*warehouses, second)))


REFILLED = with_two_warehouses(PLANT.file)
WAREHOUSES = REFILLED.supplies_of(ITEM)


class RefilledRig(Rig):
    """The station of S1, and one vehicle."""

    def __init__(self, stock: int, incarnation: int = 1) -> None:
        super().__init__(Station("S1", REFILLED, incarnation=incarnation))
        self.stock, self.seq, self.beats = stock, 0, 0
        self.uncounted: tuple[str, ...] = ()

    def sense(self) -> StorageState:
        return StorageState(stock={ITEM: self.stock}, seq=self.seq, opened=(), uncounted=self.uncounted)

    @property
    def ordered(self) -> list[StockAsked]:
        """What was asked for, each once."""
        return list({asked.task: asked for asked in sent(self.all, StockAsked)}.values())

    @property
    def level(self) -> StockLevel:
        self.run(self.now_s)
        return self.heartbeats(StationHeartbeat)[-1].stocks[0]

    def changes(self, pieces: int, vehicle: str = "") -> list[Effect]:
        self.stock += pieces
        self.seq += 1
        return self.report(StockChanged(item=ITEM, change=pieces, seq=self.seq, vehicle=vehicle))

    def reserved(self, task: str) -> None:
        for warehouse in WAREHOUSES:
            self.on_message(warehouse, StockReserved(task, 1, ITEM, LOT))

    def carried(self, task: str) -> None:
        """ATV1 has taken it."""
        self.on_message("ATV1", bid(200.0, task=task, source="SOURCE", finish_s=self.now_s + 300.0))
        self.run(self.now_s + 1.2)
        self.on_message("ATV1", accepted(task, number=award_number(self.all, "ATV1", task)))

    def beats_in(self, phase: Phase, task: str) -> None:
        self.beats += 1
        brief = Brief(task, 1, Role.PRIMARY, "S1", phase=phase, item=ITEM, quantity=LOT)
        self.on_message("ATV1", msgspec.structs.replace(rhb("ATV1", self.beats, self.now_s), task=brief))

    def put_down(self, task: str) -> None:
        self.on_message("ATV1", Docked(task, 1, "S1"))
        self.changes(LOT, "ATV1")
        self.on_message("ATV1", Handover(task, 1, LOT))


def started(stock: int) -> RefilledRig:
    rig = RefilledRig(stock)
    rig.start()
    return rig


def test_nothing_is_ordered_above_the_reorder_point() -> None:
    rig = started(POINT + 1)
    assert rig.ordered == []
    assert rig.level == StockLevel(ITEM, POINT + 1, CAPACITY)


def test_at_the_reorder_point_one_lot_is_ordered_of_all_warehouses() -> None:
    rig = started(POINT)
    assert rig.ordered == [StockAsked("S1-refill-1", 1, ITEM, LOT)]
    asked = [warehouse for warehouse in WAREHOUSES if sent(rig.all, StockAsked, to=warehouse)]
    assert asked == list(WAREHOUSES) == ["SOURCE", "SOURCE2"]
    assert rig.level == StockLevel(ITEM, POINT, CAPACITY, on_order=LOT)
    assert not instructed(rig.all, Refill)


def test_far_below_it_several_lots_are_ordered_and_no_more_than_find_room() -> None:
    rig = started(0)
    assert [asked.task for asked in rig.ordered] == ["S1-refill-1", "S1-refill-2", "S1-refill-3"]
    rig.changes(CAPACITY - 4 * LOT)
    rig.on_message("M8", StockAsked("M8-1", 1, ITEM, LOT))
    rig.on_message("M8", StockAsked("M8-2", 1, ITEM, LOT))
    assert len(rig.ordered) * LOT + rig.stock <= CAPACITY


def test_what_others_have_had_set_aside_does_not_count_as_there() -> None:
    rig = started(POINT + 1)
    rig.on_message("M8", StockAsked("M8-1", 1, ITEM, LOT))
    assert len(rig.ordered) == 1


def test_who_is_asked_for_more_than_lies_there_does_not_wait_until_a_lot_finds_room() -> None:
    rig = started(CAPACITY - LOT + 1)
    assert rig.ordered == []
    rig.on_message("M8", StockAsked("M8-1", 1, ITEM, CAPACITY))
    assert rig.ordered == [StockAsked("S1-refill-1", 1, ITEM, LOT - 1)]


def test_what_was_brought_is_counted_once_and_the_next_lot_ordered_when_it_is_needed() -> None:
    rig = started(POINT)
    rig.reserved("S1-refill-1")
    rig.carried("S1-refill-1")
    rig.beats_in(Phase.CARRYING, "S1-refill-1")
    rig.put_down("S1-refill-1")
    assert rig.level == StockLevel(ITEM, POINT + LOT, CAPACITY)
    rig.changes(-LOT, "ATV2")
    assert [asked.task for asked in rig.ordered] == ["S1-refill-1", "S1-refill-2"]


def test_of_two_warehouses_one_that_is_silent_or_has_none_is_left_out() -> None:
    rig = started(POINT)
    rig.on_message("SOURCE2", StockReserved("S1-refill-1", 1, ITEM, LOT))
    rig.run(rig.now_s + ANSWER_S + 1.0)
    assert published(rig.all, TaskAnnounced)[-1].work.sources == ("SOURCE2",)  # type: ignore[union-attr]


def test_with_none_at_any_warehouse_it_waits_and_says_so() -> None:
    rig = started(POINT)
    for warehouse in WAREHOUSES:
        rig.on_message(warehouse, StockShort("S1-refill-1", 1, ITEM, 0))
    rig.run(rig.now_s + 6.0)
    [wait] = rig.heartbeats(StationHeartbeat)[-1].waits
    assert (wait.item, wait.short) == (ITEM, WAREHOUSES)
    assert not published(rig.all, TaskAnnounced)
    rig.on_message("SOURCE", StockReserved("S1-refill-1", 1, ITEM, LOT))
    assert published(rig.all, TaskAnnounced)


@pytest.mark.parametrize("phase", [Phase.APPROACHING, Phase.CARRYING])
def test_started_again_it_goes_on_with_what_it_had_ordered(phase: Phase) -> None:
    before = started(POINT)
    before.reserved("S1-refill-1")
    before.carried("S1-refill-1")
    rig = RefilledRig(POINT, incarnation=2)
    rig.memory, rig.now_s = committed(before.all), before.now_s
    rig.start()
    rig.beats_in(phase, "S1-refill-1")
    rig.run(rig.now_s + 2 * RECOVERY_WAIT_S)
    assert {asked.task for asked in rig.ordered} <= {"S1-refill-1"}
    assert rig.level == StockLevel(ITEM, POINT, CAPACITY, on_order=LOT)


def test_with_an_empty_journal_it_hears_the_carriers_before_it_orders_anew() -> None:
    rig = RefilledRig(POINT, incarnation=2)
    rig.start()
    assert rig.ordered == []
    rig.beats_in(Phase.CARRYING, "S1-refill-1")
    while rig.now_s < 2 * RECOVERY_WAIT_S:
        rig.run(rig.now_s + 1.0)
        rig.beats_in(Phase.CARRYING, "S1-refill-1")
    assert {asked.task for asked in rig.ordered} <= {"S1-refill-1"}
    rig.put_down("S1-refill-1")
    rig.changes(-LOT, "ATV2")
    assert rig.ordered[-1].task == "S1.2-refill-1"


def test_with_an_empty_journal_and_nobody_on_the_way_it_orders_after_having_listened() -> None:
    rig = RefilledRig(POINT, incarnation=2)
    rig.start()
    rig.run(RECOVERY_WAIT_S + 1.0)
    assert [asked.task for asked in rig.ordered] == ["S1.2-refill-1"]


def test_what_people_have_brought_counts_as_on_its_way() -> None:
    rig = started(POINT + 1)
    rig.on_message("gateway", TransportOrdered("T-1", "SOURCE", ITEM, LOT, 600.0))
    rig.changes(-1)
    assert [asked.task for asked in rig.ordered] == ["T-1-1"]


def test_one_that_is_leaving_orders_nothing() -> None:
    rig = started(POINT + 1)
    rig.leave()
    rig.changes(-POINT)
    assert rig.ordered == []


def test_what_nobody_has_counted_is_told_and_not_ordered_until_it_is() -> None:
    rig = RefilledRig(0)
    rig.uncounted = (ITEM,)
    rig.start()
    rig.run(60.0)
    assert (rig.level.uncounted, rig.ordered) == (True, [])
    rig.uncounted = ()
    rig.run(120.0)
    assert not rig.level.uncounted
    assert rig.ordered
