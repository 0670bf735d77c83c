"""Lanes that are not straight: their length, where nobody stops, and what a file may not say of them."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from msgspec.structs import replace

from dray.plant import Lane, Node, Plant, Point, default_plant, parse_plant, plant_yaml
from dray.plant.planning.drawing import draw
from dray.protocol.traffic.places import Places

Break = Callable[..., list[tuple[str, str]]]

BENT = "  - {start: middle, end: north, both_ways: true}"


def bent(shape: str) -> str:
    return f"  - {{start: middle, end: north, both_ways: true, shape: {shape}}}"


def around(plant: Plant, *, both_ways: bool, two_lanes: bool = False) -> Plant:
    """With a lane that leads from a1 around the corner to b2."""
    lane = Lane("a1", "b2", both_ways=both_ways, shape=(Point(17.0, 6.0), Point(17.0, 9.0)))
    return Plant(replace(plant.file, lanes=(*plant.file.lanes, lane), two_lanes=two_lanes))


def test_a_shape_is_as_long_as_its_pieces_and_nobody_stops_on_it() -> None:
    plant = around(default_plant(), both_ways=True)
    way = plant.routes(next(iter(plant.vehicle_types))).way("a1", "b2")
    assert "a1.to-b2.1" in plant.nodes
    assert "a1.to-b2.1" not in plant.stops
    pieces = [lane for lane in plant.lanes if "a1.to-b2" in lane.start or "a1.to-b2" in lane.end]
    assert len(pieces) == 6
    assert sum(lane.length_m for lane in pieces) == pytest.approx(2 * ((10**2 + 1) ** 0.5 + 3 + 4))
    assert way.nodes == ("a1", "a1.to-b2.1", "a1.to-b2.2", "b2")


def test_it_is_entered_as_a_whole() -> None:
    places = Places(around(default_plant(), both_ways=False))
    chain = ("a1", "a1.to-b2.1", "a1.to-b2.2", "b2")
    assert places.group_end(chain, 1) == 3
    assert places.needs("a1", "a1.to-b2.1") == ("a1.to-b2",)
    assert places.needs("a1.to-b2.2", "b2") == ("a1.to-b2", "b2")
    assert places.district_of["a1.to-b2"] == places.district_of["b2"]


@pytest.mark.parametrize("both_ways", [False, True])
def test_among_roads_of_two_lanes_it_joins_the_crossings_at_its_ends(both_ways: bool) -> None:
    plant = around(default_plant(), both_ways=both_ways, two_lanes=True)
    crossing = plant.crossing_of("a1.to-b2.1")
    assert set(plant.crossings[crossing].nodes) >= {"a1", "b2"}
    assert plant.places_on("a1", "a1.to-b2.1") == (crossing,)
    assert "<svg" in draw(plant)


def test_it_is_written_and_read() -> None:
    plant = around(default_plant(), both_ways=True)
    assert parse_plant(plant_yaml(plant), "x.yaml").file == plant.file


def test_faults_of_shapes(broken: Break) -> None:
    assert broken((BENT, bent("[{x_m: 90, y_m: 12}]")))[0][0] == "lanes[2].shape[0]"
    assert "less than 0.01 m apart" in broken((BENT, bent("[{x_m: 20, y_m: 10.001}]")))[0][1]
    two = bent("[{x_m: 22, y_m: 12}], two_lanes: true")
    assert "a lane with a shape is single track" in broken((BENT, two))[0][1]
    named = (
        "  - {id: west, x_m: 5, y_m: 10}",
        "  - {id: west, x_m: 5, y_m: 10}\n  - {id: middle.to-north.1, x_m: 1, y_m: 1}",
    )
    assert "is the name of a corner" in broken((BENT, bent("[{x_m: 22, y_m: 12}]")), named)[0][1]


def test_a_node_may_stand_beside_a_corner() -> None:
    plant = around(default_plant(), both_ways=True)
    assert isinstance(plant.nodes["a1.to-b2.2"], Node)
