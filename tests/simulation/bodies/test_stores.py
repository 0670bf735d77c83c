"""Storages and warehouses: what they give, refuse, order and count."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from yard import PLANT, Yard

from dray.body import Admit, CloseDock, FillTo, OpenDock, Refill, StockChanged, StorageState
from dray_sim.bodies.docks import SHUT
from dray_sim.bodies.gate import NOT_ADMITTED, Gate
from dray_sim.bodies.stores import NO_ROOM, NOT_KEPT, REFILL_S, TOO_LITTLE, DeliveryWarehouse, Storage


def test_a_storage_begins_full_unless_told_otherwise(yard: Yard) -> None:
    assert yard.storage.stock == {"shaft": 60, "seal": 15}
    begun = Storage(PLANT.storages["S1"], yard.clock, yard.source, stock={"shaft": 40})
    assert begun.stock == {"shaft": 40, "seal": 15}


def test_a_storage_gives_what_it_has_and_nothing_of_what_it_has_not(yard: Yard) -> None:
    assert yard.storage.take("ATV1", "shaft", 20) == ""
    assert yard.storage.stock["shaft"] == 40
    assert yard.storage.take("ATV1", "shaft", 41) == TOO_LITTLE
    assert yard.storage.take("ATV1", "gear", 1) == NOT_KEPT
    assert yard.storage.stock["shaft"] == 40


def test_a_stock_at_half_its_capacity_is_not_refilled(yard: Yard) -> None:
    yard.storage.take("ATV1", "shaft", 30)
    yard.run(10 * REFILL_S)
    assert yard.storage.stock["shaft"] == 30


def test_a_stock_below_half_is_filled_up_after_the_refill_time(yard: Yard) -> None:
    yard.storage.take("ATV1", "shaft", 31)
    yard.run(REFILL_S - 0.1)
    assert yard.storage.stock["shaft"] == 29
    yard.run(REFILL_S)
    assert yard.storage.stock["shaft"] == 60
    assert yard.source.supplied("shaft") == 31


def test_a_storage_that_begins_low_is_refilled_too(yard: Yard) -> None:
    low = Storage(PLANT.storages["S1"], yard.clock, yard.source, stock={"shaft": 0})
    yard.run(REFILL_S)
    assert low.stock["shaft"] == 60


def test_what_is_taken_while_a_refill_is_on_its_way_comes_with_it(yard: Yard) -> None:
    yard.storage.take("ATV1", "shaft", 40)
    yard.run(REFILL_S / 2)
    yard.storage.take("ATV2", "shaft", 20)
    yard.run(REFILL_S)
    assert yard.storage.stock["shaft"] == 60


def test_a_returned_load_is_taken_back_as_far_as_there_is_room(yard: Yard) -> None:
    assert yard.storage.put("ATV1", "shaft", 1) == NO_ROOM
    yard.storage.take("ATV1", "shaft", 20)
    assert yard.storage.put("ATV1", "shaft", 20) == ""
    assert yard.storage.put("ATV1", "gear", 1) == NOT_KEPT
    assert yard.storage.stock["shaft"] == 60


def test_its_dock_opens_for_one_vehicle_and_one_load_once(yard: Yard) -> None:
    storage = Storage(PLANT.storages["S1"], yard.clock, yard.source)
    assert storage.take("ATV1", "shaft", 20) == SHUT
    storage.instruct(OpenDock(vehicle="ATV1", item="shaft", quantity=20))
    assert storage.take("ATV2", "shaft", 20) == SHUT
    assert storage.take("ATV1", "shaft", 10) == SHUT
    assert storage.sense() == StorageState({"shaft": 60, "seal": 15}, 0, ("ATV1",))
    assert storage.take("ATV1", "shaft", 20) == ""
    assert storage.take("ATV1", "shaft", 20) == SHUT
    assert storage.sense() == StorageState({"shaft": 40, "seal": 15}, 1, ())
    storage.instruct(OpenDock(vehicle="ATV1", item="shaft", quantity=20))
    storage.instruct(CloseDock(vehicle="ATV1"))
    assert storage.take("ATV1", "shaft", 20) == SHUT
    assert storage.take("", "shaft", 20) == "", "a person helps himself"


def test_it_reports_every_change_of_its_stock_by_number(yard: Yard) -> None:
    yard.listen("S1", yard.storage)
    yard.storage.take("ATV1", "seal", 10)
    yard.storage.put("ATV2", "seal", 2)
    yard.run(REFILL_S)
    assert [said for _, who, said in yard.said if who == "S1"] == [
        StockChanged(item="seal", change=-10, seq=1, vehicle="ATV1"),
        StockChanged(item="seal", change=2, seq=2, vehicle="ATV2"),
        StockChanged(item="seal", change=8, seq=3),
    ]


def test_a_refill_comes_when_its_station_asks_for_it_and_once(yard: Yard) -> None:
    yard.storage.take("ATV1", "seal", 7)
    for _ in range(3):
        yard.storage.instruct(Refill(item="seal"))
    yard.storage.instruct(Refill(item="gear"))
    yard.run(10 * REFILL_S)
    assert yard.storage.stock["seal"] == 15
    assert yard.source.supplied("seal") == 7


def test_a_refill_leaves_the_room_that_it_was_told_to_leave(yard: Yard) -> None:
    yard.storage.take("ATV1", "shaft", 31)
    yard.storage.instruct(FillTo(item="shaft", quantity=40))
    yard.storage.instruct(FillTo(item="gear", quantity=40))
    yard.run(10 * REFILL_S)
    assert (yard.storage.stock["shaft"], yard.storage.filled) == (40, {"shaft": 40})
    assert yard.storage.put("ATV2", "shaft", 20) == "", "vehicles may bring more"
    yard.storage.instruct(FillTo(item="shaft", quantity=60))
    yard.run(20 * REFILL_S)
    assert yard.storage.stock["shaft"] == 60, "it is not low"


def test_room_that_is_needed_no_more_is_filled_at_once_where_the_stock_is_low(yard: Yard) -> None:
    yard.storage.instruct(FillTo(item="shaft", quantity=0))
    yard.storage.take("ATV1", "shaft", 60)
    yard.run(10 * REFILL_S)
    assert yard.storage.stock["shaft"] == 0
    yard.storage.instruct(FillTo(item="shaft", quantity=60))
    yard.run(11 * REFILL_S)
    assert yard.storage.stock["shaft"] == 60


def test_the_source_warehouse_counts_what_left_and_what_came_back(yard: Yard) -> None:
    assert yard.source.take("ATV1", "shaft", 20) == ""
    assert yard.source.put("ATV1", "shaft", 5) == ""
    assert yard.source.supplied("shaft") == 15
    assert yard.source.take("ATV1", "gear", 1) == NOT_KEPT
    assert yard.source.put("ATV1", "gear", 1) == NOT_KEPT


def test_the_delivery_warehouse_counts_products_and_gives_nothing_back(yard: Yard) -> None:
    assert yard.delivery.put("ATV1", "gear", 10) == ""
    assert yard.delivery.put("ATV1", "shaft", 10) == NOT_KEPT
    assert yard.delivery.take("ATV1", "gear", 1) == NOT_KEPT
    assert yard.delivery.arrived == {"gear": 10}


@pytest.fixture
def gate(yard: Yard) -> Gate:
    return Gate(yard.clock)


@pytest.fixture
def gated(gate: Gate) -> DeliveryWarehouse:
    return DeliveryWarehouse("DELIVERY", PLANT.materials, gate)


def test_a_gated_warehouse_lets_in_what_the_gate_admits(gate: Gate, gated: DeliveryWarehouse) -> None:
    assert gated.put("ATV1", "gear", 5, "G1") == NOT_ADMITTED
    gate.instruct(Admit(goal="G1", quantity=5))
    assert gated.put("ATV1", "gear", 5, "G1") == ""
    assert gated.put("ATV1", "gear", 5, "G1") == NOT_ADMITTED
    assert (gated.arrived, gated.aside) == ({"gear": 5}, {})


def test_goods_without_a_goal_are_set_aside_at_a_gated_warehouse(gated: DeliveryWarehouse) -> None:
    assert gated.put("ATV1", "gear", 5) == ""
    assert (gated.arrived, gated.aside) == ({}, {"gear": 5})


def test_what_a_gated_warehouse_does_not_take_uses_up_no_permit(gate: Gate, gated: DeliveryWarehouse) -> None:
    gate.instruct(Admit(goal="G1", quantity=5))
    assert gated.put("ATV1", "shaft", 5, "G1") == NOT_KEPT
    assert gate.sense().arrived == {"G1": 0}


@settings(deadline=None)
@given(st.lists(st.tuples(st.booleans(), st.integers(1, 40), st.floats(0.0, 200.0)), max_size=40))
def test_whatever_vehicles_do_nothing_is_lost_in_a_storage(deeds: list[tuple[bool, int, float]]) -> None:
    yard = Yard()
    taken = 0
    for takes, quantity, seconds in deeds:
        transfer = yard.storage.take if takes else yard.storage.put
        if not transfer("ATV1", "shaft", quantity):
            taken += quantity if takes else -quantity
        yard.run(yard.clock.now_s() + seconds)
        assert 0 <= yard.storage.stock["shaft"] <= 60
        assert yard.storage.stock["shaft"] == 60 - taken + yard.source.supplied("shaft")


def test_a_source_warehouse_takes_back_what_finds_no_room_elsewhere(yard: Yard) -> None:
    spec = PLANT.storages["S1"]
    item, capacity = spec.stocks[0].material, spec.stocks[0].capacity
    assert Storage(spec, yard.clock, yard.source).put("ATV1", item, 1) == NO_ROOM
    warehouse = Storage(spec, yard.clock, yard.source, takes_all=True)
    assert warehouse.put("ATV1", item, 1) == ""
    assert warehouse.sense().stock[item] == capacity + 1
