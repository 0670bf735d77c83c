"""Where vehicles without a dwell point wait: out of everybody's way as long as there is room for that."""

from __future__ import annotations

import pytest

from dray.plant import default_plant
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
