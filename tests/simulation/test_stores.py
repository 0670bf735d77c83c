"""Storages and warehouses: what they give, refuse, order and count."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from yard import PLANT, Yard

from dray.body import Admit
from dray_sim.gate import NOT_ADMITTED, Gate
from dray_sim.stores import NO_ROOM, NOT_KEPT, REFILL_S, TOO_LITTLE, DeliveryWarehouse, Storage


@pytest.fixture
def yard() -> Yard:
    return Yard()


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


def test_whoever_waits_is_called_when_it_was_refilled_and_in_the_order_of_asking(yard: Yard) -> None:
    called: list[tuple[float, str]] = []
    yard.storage.take("ATV1", "seal", 15)
    for name in ("first", "second"):
        assert yard.storage.wait_for("seal", 5, lambda name=name: called.append((yard.clock.now_s(), name)))
    yard.run(3 * REFILL_S)
    assert called == [(REFILL_S, "first"), (REFILL_S, "second")]


def test_waiting_for_more_than_half_orders_a_refill_at_once(yard: Yard) -> None:
    called: list[float] = []
    yard.storage.take("ATV1", "seal", 7)
    assert yard.storage.wait_for("seal", 10, lambda: called.append(yard.clock.now_s()))
    yard.run(REFILL_S)
    assert called == [REFILL_S]


def test_a_returned_load_wakes_whoever_waits(yard: Yard) -> None:
    called: list[float] = []
    yard.storage.take("ATV1", "seal", 15)
    yard.storage.wait_for("seal", 5, lambda: called.append(yard.clock.now_s()))
    yard.storage.put("ATV1", "seal", 5)
    assert called == [0.0]


@pytest.mark.parametrize(("item", "quantity"), [("gear", 1), ("seal", 16)])
def test_waiting_for_what_can_never_come_is_refused(yard: Yard, item: str, quantity: int) -> None:
    assert not yard.storage.wait_for(item, quantity, lambda: None)


def test_the_source_warehouse_counts_what_left_and_what_came_back(yard: Yard) -> None:
    assert yard.source.take("ATV1", "shaft", 20) == ""
    assert yard.source.put("ATV1", "shaft", 5) == ""
    assert yard.source.supplied("shaft") == 15
    assert yard.source.take("ATV1", "gear", 1) == NOT_KEPT
    assert yard.source.put("ATV1", "gear", 1) == NOT_KEPT
    assert not yard.source.wait_for("shaft", 1, lambda: None)


def test_the_delivery_warehouse_counts_products_and_gives_nothing_back(yard: Yard) -> None:
    assert yard.delivery.put("ATV1", "gear", 10) == ""
    assert yard.delivery.put("ATV1", "shaft", 10) == NOT_KEPT
    assert yard.delivery.take("ATV1", "gear", 1) == NOT_KEPT
    assert not yard.delivery.wait_for("gear", 1, lambda: None)
    assert yard.delivery.arrived == {"gear": 10}


@pytest.fixture
def gate(yard: Yard) -> Gate:
    return Gate(yard.clock)


@pytest.fixture
def gated(gate: Gate) -> DeliveryWarehouse:
    return DeliveryWarehouse("DELIVERY", PLANT.products, gate)


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
