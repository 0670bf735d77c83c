"""Generated plants, and others, with roads of two lanes."""

from __future__ import annotations

from itertools import pairwise

import pytest
from variants import variants

from dray.plant import Plant, load_plant, parse_plant, plant_yaml
from dray_sim.plants.draw import draw_plant
from dray_sim.plants.generator import generate_plant
from dray_sim.plants.two_lanes import with_two_lanes

PLANTS = {
    "single track": with_two_lanes(load_plant("single-track")),
    "two halls": with_two_lanes(load_plant("two-halls")),
    "workshop": with_two_lanes(load_plant("workshop")),
    "generated": generate_plant(1, 12, 8),
}


@pytest.mark.parametrize("plant", PLANTS.values(), ids=PLANTS)
def test_it_is_a_plant_without_faults_and_of_one_part(plant: Plant) -> None:
    assert parse_plant(plant_yaml(plant), plant.id) == plant
    assert len(plant.roads.parts()) == 1
    assert plant.crossings


@pytest.mark.parametrize("plant", PLANTS.values(), ids=PLANTS)
def test_whoever_leaves_a_crossing_stands_before_he_comes_into_another_one(plant: Plant) -> None:
    kind = next(iter(plant.vehicle_types))
    docks = [plant.node_of(place) for place in plant.places]
    for a in docks[:12]:
        for b in docks[-12:]:
            groups: list[list[str]] = [[]]
            for lane in pairwise(plant.routes(kind).way(a, b).nodes):
                groups[-1] += plant.places_on(*lane)
                if lane[1] in plant.stops:
                    groups.append([])
            assert groups.pop() == []
            for group in groups:
                assert len({place for place in group if place in plant.crossings}) <= 1
                assert group[-1] in plant.stops


def test_single_tracks_stay_where_they_are_wanted() -> None:
    plain = load_plant("single-track")
    plant = with_two_lanes(plain, single=("c3", "d3", "m5-lane"))
    assert plant.nodes["m5-lane"] == plain.nodes["m5-lane"]
    assert {"c3", "m5-lane", "d3"} <= set(plant.stops)


def test_a_generated_plant_is_the_same_with_and_without_two_lanes_but_for_its_floor() -> None:
    one, two = generate_plant(5, 20, 30, two_lanes=False), generate_plant(5, 20, 30)
    assert one.file.machines[3].makes == two.file.machines[3].makes
    assert [each.id for each in one.file.fleet] == [each.id for each in two.file.fleet]
    assert not one.crossings
    assert two.crossings


def test_spurs_of_a_generated_plant_have_stop_points_between_them() -> None:
    plant = generate_plant(5, 20, 30)
    merged = [crossing for crossing in plant.crossings.values() if len(crossing.nodes) > 1]
    # A drive-through of a warehouse leaves its road at a slant, and may need the room of the next spur.
    assert len(merged) <= 2 * len(plant.warehouses)


@pytest.mark.parametrize("seed", variants(range(12), 0, 1, 2))
def test_any_plant_can_have_two_lanes(seed: int) -> None:
    """Roads at any angle, of any length, with docks in them: what comes of it can be driven."""
    plant, plain = draw_plant(seed, two_lanes=True), draw_plant(seed)
    assert len(plant.roads.parts()) == 1
    assert plant.crossings
    assert {vehicle.node for vehicle in plant.fleet.values()} <= set(plant.stops)
    assert plant.file.machines == plain.file.machines
    assert plant.file.lanes == plain.file.lanes
    docks = [plant.node_of(place) for place in plant.places][:8]
    kind = next(iter(plant.vehicle_types))
    for a in docks:
        for b in docks:
            more_m = plant.routes(kind).length_m(a, b) - plain.routes(kind).length_m(a, b)
            assert more_m < 0.5 * plain.routes(kind).length_m(a, b) + 10.0
