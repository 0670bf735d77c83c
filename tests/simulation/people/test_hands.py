"""The hands of people: where what is taken off a vehicle goes."""

from __future__ import annotations

import pytest
from people_floor import PLANT

from dray_sim.bodies.vehicle.condition import BATTERY_EMPTY
from dray_sim.clock.loop import clock, run
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.people.hands import Hands


@pytest.fixture
def factory() -> SimFactory:
    async def main() -> SimFactory:
        return SimFactory(PLANT, clock(), seed=1)

    return run(main())


def carry(factory: SimFactory, item: str, quantity: int) -> Hands:
    """Somebody has pieces in hand."""
    factory.in_hands[item] += quantity
    return Hands(factory)


def test_somebody_without_a_body_is_looked_for_and_nothing_is_found(factory: SimFactory) -> None:
    hands = Hands(factory)
    assert (hands.problem("ATV99"), hands.is_off("ATV99")) == ("", False)


def test_material_goes_to_the_nearest_storage_that_has_room(factory: SimFactory) -> None:
    material = next(item for item in PLANT.materials if len(PLANT.storages_of(item)) > 1)
    far, near = PLANT.storages_of(material)[:2]
    factory.storages[far].take("", material, 5)
    hands = carry(factory, material, 5)
    assert hands.put_down(material, 5, PLANT.node_of(near)) == far
    assert factory.in_hands[material] == 0
    factory.storages[far].take("", material, 5)
    factory.storages[near].take("", material, 5)
    assert carry(factory, material, 5).put_down(material, 5, PLANT.node_of(near)) == near


def test_material_without_room_anywhere_goes_back_to_the_source(factory: SimFactory) -> None:
    material = next(iter(PLANT.materials))
    assert carry(factory, material, 5).put_down(material, 5, "c3") == factory.source.id
    assert factory.source.returned[material] == 5


def test_goods_go_back_to_their_machine(factory: SimFactory) -> None:
    machine = next(iter(PLANT.machines.values()))
    product = machine.makes[0].product
    assert carry(factory, product, 2).put_down(product, 2, "c3", machine.id) == machine.id
    assert factory.workcells[machine.id].sense().stock[product] == 2


def test_goods_of_nobody_are_set_aside(factory: SimFactory) -> None:
    product = next(iter(PLANT.products))
    place = carry(factory, product, 2).put_down(product, 2, "c3")
    warehouse = factory.delivery[place]
    assert warehouse.arrived[product] + warehouse.aside[product] == 2
    assert factory.in_hands[product] == 0


def test_a_dead_vehicle_is_pushed_to_a_charger_where_none_stands(factory: SimFactory) -> None:
    dead, other = factory.vehicles["ATV1"], factory.vehicles["ATV2"]
    hands = Hands(factory)
    dead.break_down("wheel")
    factory.power_off("ATV1")
    first = hands.bring_home("ATV1")
    assert (dead.off, dead.problem, dead.sense().node) == (False, "", PLANT.node_of(first))
    factory.power_off("ATV1")
    other.place_at(PLANT.node_of(first))
    dead.place_at("c3")
    assert hands.bring_home("ATV1") not in ("", first)


def test_an_empty_battery_is_exchanged(factory: SimFactory) -> None:
    vehicle = factory.vehicles["ATV1"]
    vehicle.replace_battery(0.0)
    while vehicle.problem != BATTERY_EMPTY:
        when_s, _, callback, args = factory.clock.heap.pop(0)
        factory.clock.time_s = max(factory.clock.time_s, when_s)
        callback(*args)
    Hands(factory).mend("ATV1")
    assert (vehicle.problem, vehicle.sense().battery_frac) == ("", 1.0)
