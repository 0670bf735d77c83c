"""Where vehicles without a dwell point wait: out of everybody's way as long as there is room for that."""

from __future__ import annotations

import pytest
from msgspec.structs import replace

from dray.plant import default_plant
from dray.plant.spare_places import SparePlaces
from dray_sim.plants.fleet_sizes import with_fleet
from dray_sim.plants.raster import draw_raster

SEEDS = range(25)


def test_a_plant_with_a_dwell_point_for_each_vehicle_needs_no_spare_place() -> None:
    assert default_plant().spare_places.all == ()


@pytest.mark.parametrize("seed", SEEDS)
def test_whoever_waits_out_of_the_way_leaves_a_way_between_all_docks(seed: int) -> None:
    plant = draw_raster(seed)
    spare, missing = plant.spare_places, len(plant.fleet) - len(plant.dwell_points)
    assert len(set(spare.all)) == len(spare.all) <= max(0, missing)
    assert not set(spare.all) & {plant.node_of(place) for place in plant.places}
    shut = set(spare.clear)
    docks = {plant.node_of(place) for place in (*plant.machines, *plant.storages, *plant.warehouses)}
    for kind in plant.vehicle_types:
        roads = plant.roads_of(kind)
        first = min(docks)
        there, coming = {first}, [first]
        while coming:
            for lane in roads.leaving[coming.pop()]:
                if lane.end not in there and lane.end not in shut:
                    there.add(lane.end)
                    coming.append(lane.end)
        assert docks <= there
        assert all(any(lane.start in there for lane in roads.entering[node]) for node in shut)


def test_what_is_too_much_for_the_floor_stands_apart_and_not_before_docks() -> None:
    plants = [draw_raster(seed) for seed in SEEDS]
    crowded = [plant for plant in plants if plant.spare_places.others]
    assert crowded
    for plant in crowded:
        goods = [plant.node_of(place) for place in (*plant.machines, *plant.storages, *plant.warehouses)]
        entries = {lane.start for dock in goods for lane in plant.roads.entering[dock]}
        spurs = {node for node in entries if f"d-{node[2:]}" in goods}
        assert not spurs & set(plant.spare_places.others)


@pytest.mark.parametrize("seed", [1, 9, 17, 27])
def test_the_reserve_shuts_off_no_dock_for_goods_and_leaves_others_a_way(seed: int) -> None:
    plant = draw_raster(seed)
    spare = plant.spare_places
    assert spare.reserve
    goods = {plant.node_of(place) for place in (*plant.machines, *plant.storages, *plant.warehouses)}
    dwells = {plant.node_of(place) for place in plant.dwell_points}
    assert spare.shut <= dwells - goods
    assert len(spare.shut) <= len(dwells) / 2
    taken = {*spare.clear, *spare.reserve}
    for kind in {spec.type for spec in plant.fleet.values()}:
        roads = plant.roads_of(kind)
        for ways in (roads.leaving, roads.entering):
            first = min(goods)
            there, coming = {first}, [first]
            while coming:
                for lane in ways[coming.pop()]:
                    node = lane.end if ways is roads.leaving else lane.start
                    if node not in there and node not in taken:
                        there.add(node)
                        coming.append(node)
            assert (goods | dwells) - spare.shut <= there


def test_in_raster_17_everybody_finds_a_place_in_nobodys_way() -> None:
    plant = draw_raster(17)
    assert len(plant.dwell_points) + len(plant.spare_places.clear) < len(plant.fleet)
    assert plant.spare_places.others == ()
    assert len(plant.dwell_points) + len(plant.spare_places.all) == len(plant.fleet)
    at_work = len(plant.fleet) - len(plant.spare_places.reserve) - len(plant.spare_places.shut)
    assert at_work == 16


@pytest.mark.parametrize("vehicles", [28, 31])
def test_where_some_wait_in_the_way_all_beyond_those_with_a_place_are_the_reserve(vehicles: int) -> None:
    """On raster 27 17 are at work, with 24 vehicles (all of which have a place) as with more."""
    floor = draw_raster(27)
    roomy, plant = with_fleet(floor, 24), with_fleet(floor, vehicles)
    spare = plant.spare_places
    assert roomy.spare_places.others == ()
    assert roomy.spare_places.filled == {}
    assert spare.others
    assert len(plant.fleet) - spare.reserve_size == len(roomy.fleet) - roomy.spare_places.reserve_size == 17
    assert len(spare.filled) == vehicles - 17
    assert spare.filled == {place: plant.stand_of(place) for place in spare.filled}
    assert tuple(spare.filled)[: len(spare.reserve)] == spare.reserve
    assert not spare.filled.keys() & plant.chargers.keys()
    assert all(spare.is_reserve(node) for node in spare.filled.values())


CROWDED = SparePlaces(clear=("c1",), others=("o1", "o2"), reserve=("r1",), shut=frozenset({"p2", "x1"}))
"""The spare places of 10 vehicles with three parking places and three chargers, one of each shut off."""

PARKINGS = {"P1": "p1", "P2": "p2", "P3": "p3"}


def test_the_reserve_has_its_own_nodes_then_places_in_nobodys_way() -> None:
    spare = CROWDED.fill(PARKINGS, chargers=3, docks=4, vehicles=10)
    assert list(spare.filled.items()) == [
        ("r1", "r1"),
        ("P2", "p2"),
        ("c1", "c1"),
        ("P1", "p1"),
        ("P3", "p3"),
    ]
    assert spare.reserve_size == 5


def test_as_many_stay_at_work_as_there_are_docks_for_goods() -> None:
    assert len(CROWDED.fill(PARKINGS, chargers=3, docks=5, vehicles=11).filled) == 6
    assert len(CROWDED.fill(PARKINGS, chargers=3, docks=6, vehicles=11).filled) == 5


def test_a_third_of_the_fleet_stays_at_work() -> None:
    spare = replace(CROWDED, others=tuple(f"o{number}" for number in range(9)))
    assert len(spare.fill({}, chargers=0, docks=1, vehicles=9).filled) == 6


def test_where_few_of_the_reserve_would_be_without_a_place_of_its_own_nothing_changes() -> None:
    assert CROWDED.fill(PARKINGS, chargers=3, docks=7, vehicles=11) == CROWDED
    plant = with_fleet(draw_raster(17), 28)
    assert len(plant.spare_places.others) == 1
    assert plant.spare_places.filled == {}


def test_how_many_must_be_able_to_carry_something_does_not_depend_on_the_places_that_are_filled() -> None:
    spare = CROWDED.fill(PARKINGS, chargers=3, docks=4, vehicles=11)
    assert spare.reserve_size == 6
    for floor in (CROWDED, spare):
        assert floor.holds_back_from(5)
        assert not floor.holds_back_from(4)


def test_without_a_reserve_and_with_a_place_for_all_nothing_is_filled() -> None:
    for spare in (replace(CROWDED, reserve=(), shut=frozenset()), replace(CROWDED, others=())):
        assert spare.fill(PARKINGS, chargers=3, docks=1, vehicles=20) == spare
