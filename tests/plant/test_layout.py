"""Roads of two lanes: where stop points are, what a crossing is, and that it is driven as written."""

from __future__ import annotations

from collections.abc import Callable
from hashlib import sha256
from itertools import pairwise
from math import hypot

import pytest
from msgspec.structs import replace

from dray.plant import Lane, Node, Plant, PlantFile, VehicleType, load_plant, parse_plant, plant_yaml
from dray.plant.layout import MARGIN_M, PASSING_M, Size, lay_out, name_after

Break = Callable[..., list[tuple[str, str]]]

KIND = VehicleType("kind", "Kind", length_m=1.0, width_m=0.7)
SIZE = Size.of((KIND,))

CROSS = (Node("a", 0, 20), Node("b", 20, 20), Node("c", 40, 20), Node("d", 20, 0), Node("e", 20, 40))
ARMS = tuple(Lane(end, "b", both_ways=True) for end in ("a", "c", "d", "e"))


def plant(nodes: tuple[Node, ...], lanes: tuple[Lane, ...], *, two_lanes: bool = True) -> Plant:
    """The default plant, with another floor beside its own."""
    file = load_plant("single-track").file
    return Plant(
        replace(
            file,
            vehicle_types=(*file.vehicle_types, KIND),
            nodes=(*file.nodes, *nodes),
            lanes=(*file.lanes, *(replace(lane, two_lanes=two_lanes and lane.both_ways) for lane in lanes)),
        )
    )


def spot(of: Plant, node: str) -> tuple[float, float]:
    return of.nodes[node].x_m, of.nodes[node].y_m


def test_a_plant_without_two_lane_roads_is_driven_as_written() -> None:
    old = load_plant("single-track")
    assert old.driven is old.file
    assert tuple(old.nodes) == tuple(node.id for node in old.file.nodes) == old.stops
    assert not old.crossings
    assert old.crossing_of("a1") == ""
    assert old.places_on("a1", "b1") == ("b1",)


def test_each_direction_runs_on_the_right_of_the_middle() -> None:
    floor = plant(CROSS, ARMS)
    assert SIZE.offset_m == pytest.approx((SIZE.turning_radius_m + 0.35 + MARGIN_M / 2) / 2**0.5)
    assert 2 * SIZE.offset_m > 0.7 + PASSING_M
    assert (
        spot(floor, "a.to-b")[1] == spot(floor, "b.from-a")[1] == pytest.approx(20 - SIZE.offset_m, abs=1e-3)
    )
    assert (
        spot(floor, "b.to-a")[1] == spot(floor, "a.from-b")[1] == pytest.approx(20 + SIZE.offset_m, abs=1e-3)
    )
    assert spot(floor, "b.from-d")[0] == pytest.approx(20 + SIZE.offset_m, abs=1e-3)


def test_a_vehicle_at_a_stop_point_is_clear_of_the_road_across() -> None:
    floor = plant(CROSS, ARMS)
    front_m = spot(floor, "b.from-a")[0] + SIZE.length_m / 2
    road_m = spot(floor, "b.to-d")[0] - SIZE.width_m / 2
    assert road_m - front_m == pytest.approx(MARGIN_M, abs=2e-3)


def test_a_crossing_is_crossed_and_never_stopped_in() -> None:
    floor = plant(CROSS, ARMS)
    assert "b" not in floor.nodes
    crossing = floor.crossings["b"]
    assert (crossing.x_m, crossing.y_m) == (20, 20)
    assert set(crossing.entries) == {"b.from-a", "b.from-c", "b.from-d", "b.from-e"}
    assert set(crossing.exits) == {"b.to-a", "b.to-c", "b.to-d", "b.to-e"}
    assert set(crossing.entries) | set(crossing.exits) <= set(floor.stops)
    assert ("b.from-a", "b.to-c") in crossing.lanes
    assert not crossing.inner
    assert floor.places_on("b.from-a", "b.to-c") == ("b", "b.to-c")
    assert floor.places_on("a.to-b", "b.from-a") == ("b.from-a",)


def test_a_right_turn_is_short_and_a_left_turn_goes_across() -> None:
    floor = plant(CROSS, ARMS)
    right, straight, left = (floor.roads.lane("b.from-a", f"b.to-{end}") for end in ("d", "c", "e"))
    assert right is not None
    assert straight is not None
    assert left is not None
    assert right.length_m < straight.length_m
    assert right.length_m < left.length_m
    assert floor.roads.lane("b.from-a", "b.to-a") is not None, "a vehicle may turn round"
    way = floor.routes("kind").way("b.from-a", "b.to-c")
    assert way.nodes == ("b.from-a", "b.to-c")


def test_straight_on_costs_no_speed() -> None:
    floor = plant(CROSS, ARMS)
    through = floor.routes("kind").way("a.to-b", "c.from-b")
    assert through.length_m == pytest.approx(spot(floor, "c.from-b")[0] - spot(floor, "a.to-b")[0])
    free_s = through.length_m / 1.5 + 1.5 / 0.6
    assert through.duration_s == pytest.approx(free_s, abs=1e-6)


def test_a_dock_is_reached_through_the_middle_of_the_crossing_on_a_single_track() -> None:
    floor = Plant(replace(load_plant("single-track").file, two_lanes=True))
    way = floor.routes("light").way("m1-lane.from-b4", "m1")
    assert way.nodes == ("m1-lane.from-b4", "m1-lane", "m1")
    assert spot(floor, "m1") == (22, 28.8)
    assert floor.crossing_of("m1-lane") == "m1-lane"
    assert floor.places_on("m1-lane.from-b4", "m1-lane") == ("m1-lane",)
    assert floor.places_on("m1-lane", "m1") == ("m1-lane", "m1")
    assert "m1" in floor.crossings["m1-lane"].exits
    assert "m1" in floor.crossings["m1-lane"].entries
    assert floor.crossings["m1-lane"].inner == ("m1-lane",)
    assert {("m1", "m1-lane"), ("m1-lane", "m1")} <= set(floor.crossings["m1-lane"].lanes)


def test_a_road_with_room_for_one_vehicle_has_one_stop_point_each_way() -> None:
    room_m = 2 * (SIZE.length_m / 2 + MARGIN_M)
    nodes = (Node("a", 0, 5), Node("b", room_m + 0.5, 5))
    floor = plant(nodes, (Lane("a", "b", both_ways=True),))
    assert "a.to-b" in floor.stops
    assert "b.from-a" not in floor.nodes
    assert set(floor.crossings) == {"a", "b"}


def test_crossings_without_a_stop_point_between_them_are_one() -> None:
    nodes = (*CROSS, Node("f", 21, 20), Node("g", 21, 0))
    lanes = (*ARMS, Lane("b", "f", both_ways=True), Lane("f", "g", both_ways=True))
    floor = plant(nodes, tuple(lane for lane in lanes if "c" not in (lane.start, lane.end)))
    crossing = floor.crossings["b"]
    assert crossing.nodes == ("b", "f")
    assert floor.crossing_of("b.to-f") == "b"
    assert "b.to-f" not in floor.stops
    way = floor.routes("kind").way("b.from-a", "g.from-f")
    places = [place for lane in pairwise(way.nodes) for place in floor.places_on(*lane)]
    assert places == ["b", "b", "f.to-g", "g.from-f"]


def test_a_single_track_between_two_crossings_makes_them_one() -> None:
    far = tuple(Node(f"far-{node.id}", node.x_m + 60, node.y_m) for node in CROSS)
    lanes = tuple(Lane(f"far-{lane.start}", "far-b", both_ways=True) for lane in ARMS)
    file = plant((*CROSS, *far), (*ARMS, *lanes)).file
    floor = Plant(replace(file, lanes=(*file.lanes, Lane("c", "far-a", both_ways=True))))
    assert floor.crossings["c"].nodes == ("c", "far-a")
    assert floor.places_on("c", "far-a") == ("c",)


def test_a_one_way_road_between_crossings_keeps_to_its_middle_and_has_stop_points() -> None:
    nodes = (*CROSS, Node("f", 40, 40))
    floor = plant(nodes, (*ARMS, Lane("e", "f", both_ways=True), Lane("c", "f")))
    assert spot(floor, "c.to-f")[0] == spot(floor, "f.from-c")[0] == 40
    assert "f.to-c" not in floor.nodes


def test_what_is_driven_is_driven_as_written() -> None:
    floor = Plant(replace(load_plant("single-track").file, two_lanes=True))
    again = Plant(floor.driven)
    assert again.driven is again.file
    assert again.lanes == floor.lanes
    assert tuple(again.nodes.values()) == tuple(floor.nodes.values())


def test_a_file_with_two_lanes_is_written_as_it_was_read() -> None:
    floor = Plant(replace(load_plant("single-track").file, two_lanes=True))
    again = parse_plant(plant_yaml(floor), "again")
    assert again.file == floor.file
    assert again.lanes == floor.lanes


def test_the_default_plant_with_two_lanes_is_one_part_and_no_way_is_much_longer() -> None:
    old, new = load_plant("single-track"), Plant(replace(load_plant("single-track").file, two_lanes=True))
    assert len(new.roads.parts()) == 1
    docks = [old.node_of(place) for place in old.places]
    pairs = [(a, b) for a in docks for b in docks if a != b]
    more_m = [new.routes("light").length_m(*pair) - old.routes("light").length_m(*pair) for pair in pairs]
    assert max(more_m) < 4.0


def test_names_of_stop_points_are_ids_and_stay_the_same() -> None:
    long, other = "a-very-long-name-of-a-node-left", "a-very-long-name-of-a-node-right"
    nodes = (Node(long, 0, 5), Node(other, 30, 5))
    floor = lay_out(plant(nodes, (Lane(long, other, both_ways=True),)).file)
    names = [node.id for node in floor.nodes if node.id.startswith("a-very")]
    assert len(set(names)) == 4
    assert all(len(name) <= 32 for name in names)
    assert name_after(long, other) in names
    digest = sha256(f"{long}.to-{other}".encode()).hexdigest()[:8]
    assert name_after(long, other) == f"a-very-long-name-of-a-n.{digest}"


def test_all_nodes_of_a_layout_have_ids_of_their_own() -> None:
    file: PlantFile = replace(load_plant("single-track").file, two_lanes=True)
    layout = lay_out(file)
    ids = [node.id for node in layout.nodes]
    assert len(set(ids)) == len(ids)
    assert not layout.crossings.keys() & {node for node in ids if node not in layout.inner}


def test_no_lane_of_a_layout_is_shorter_than_a_lane_may_be() -> None:
    floor = Plant(replace(load_plant("single-track").file, two_lanes=True))
    assert min(lane.length_m for lane in floor.lanes) > 0.05
    for lane in floor.lanes:
        a, b = floor.nodes[lane.start], floor.nodes[lane.end]
        assert lane.length_m == pytest.approx(hypot(a.x_m - b.x_m, a.y_m - b.y_m))


# --- what may not be said ------------------------------------------------------------------------------

SPUR = (
    "{start: middle, end: south, speed_limit_mps: 0.8, both_ways: true}",
    "{start: middle, end: south, speed_limit_mps: 0.8, both_ways: true, two_lanes: true}",
)


def test_a_road_to_a_dock_has_no_two_lanes(broken: Break) -> None:
    assert broken(SPUR) == [
        (
            "lanes[3].two_lanes",
            "vehicles dock at middle: give the dock a spur off this road, or leave this out",
        )
    ]


def test_a_one_way_road_has_no_two_lanes(broken: Break) -> None:
    found = broken((SPUR[0], "{start: middle, end: south, two_lanes: true}"))
    assert ("lanes[3].two_lanes", "the lane runs one way: add `both_ways: true`, or leave this out") in found


CROSSED = (
    "  - {start: middle, end: north, both_ways: true}",
    """\
  - {start: middle, end: fork, both_ways: true}
  - {start: fork, end: far, both_ways: true, two_lanes: true}
  - {start: fork, end: north, both_ways: true}""",
)
FORK = (
    "  - {id: south, x_m: 20, y_m: 2}",
    """\
  - {id: south, x_m: 20, y_m: 2}
  - {id: fork, x_m: 20, y_m: 17}
  - {id: far, x_m: 30, y_m: 17}""",
)


def test_a_vehicle_does_not_begin_in_a_crossing(broken: Break) -> None:
    found = broken(CROSSED, FORK, ("type: light, node: middle", "type: light, node: fork"))
    assert found == [
        (
            "fleet[0].node",
            "fork is a crossing, where nobody stands: name a parking place or a stop point, as middle",
        )
    ]


def test_a_vehicle_may_begin_at_a_stop_point(small_text: str) -> None:
    text = small_text
    for old, new in (CROSSED, FORK, ("type: light, node: middle", "type: light, node: fork.to-far")):
        text = text.replace(old, new)
    assert parse_plant(text, "small").fleet["ATV1"].node == "fork.to-far"


def test_a_node_is_not_called_as_a_stop_point_is(broken: Break) -> None:
    found = broken(CROSSED, (FORK[0], FORK[1] + "\n  - {id: fork.to-far, x_m: 3, y_m: 3}"))
    assert found == [("nodes[7].id", "fork.to-far is the name of a stop point: choose another")]
