"""Where the floor is too narrow for the vehicles: what is warned of, and what is not."""

from __future__ import annotations

from cmath import exp

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from dray.plant import Lane, Node, Parking, Plant, Point, VehicleType, load_plant
from dray.plant.floor.rectangles import Rectangle, gap_m
from dray.plant.planning.advice import advice
from dray.plant.planning.advice_floor import floor_advice

KIND = VehicleType("kind", "Kind", length_m=1.0, width_m=0.6)


def floor(
    nodes: tuple[Node, ...], lanes: tuple[Lane, ...], docks: tuple[str, ...] = (), *, two_lanes: bool = False
) -> dict[str, str]:
    """What is warned of in a plant whose floor this is, beside that of the default plant, by kind."""
    file = load_plant("single-track").file
    lanes = tuple(replace(lane, two_lanes=two_lanes) for lane in lanes)
    plant = Plant(
        replace(
            file,
            vehicle_types=(*file.vehicle_types, KIND),
            nodes=(*file.nodes, *nodes),
            lanes=(*file.lanes, *lanes),
            parkings=(*file.parkings, *(Parking(f"X{number}", dock) for number, dock in enumerate(docks))),
        )
    )
    return {kind: text for kind, _, text, _ in floor_advice(plant)}


ROW = (Node("x1", 3, 38), Node("x2", 4.3, 38))


def test_places_where_vehicles_touch_are_near() -> None:
    assert floor(ROW, (Lane("x1", "x2", both_ways=True),)) == {}
    near = floor((ROW[0], Node("x2", 3.9, 38)), (Lane("x1", "x2", both_ways=True),))
    assert (
        "x1 and x2 (0.90 m, 1.01 m needed) are nearer to one another than vehicles of 1 m x 0.6 m"
        in near["near"]
    )


def test_vehicles_side_by_side_may_be_nearer_than_vehicles_behind_one_another() -> None:
    nodes = (Node("x1", 3, 38), Node("x2", 3, 36), Node("x3", 3.7, 38), Node("x4", 3.7, 36))
    nodes += (Node("x5", 3, 34.5), Node("x6", 3.7, 34.5))
    one_way = (Lane("x1", "x2"), Lane("x2", "x5"), Lane("x3", "x4"), Lane("x4", "x6"))
    assert "near" not in floor(nodes, one_way)
    crooked = (*one_way, Lane("x2", "x4"))
    assert "x2 and x4" in floor(nodes, crooked)["near"]


def test_vehicles_that_turn_round_side_by_side_need_room_for_it() -> None:
    def dead_ends(apart_m: float) -> dict[str, str]:
        x_m = 3 + apart_m
        nodes = (Node("x1", 3, 38), Node("x2", 3, 36), Node("x3", x_m, 38), Node("x4", x_m, 36))
        return floor(nodes, (Lane("x1", "x2", both_ways=True), Lane("x3", "x4", both_ways=True)))

    assert "x1 and x3 (0.90 m, 1.18 m needed)" in dead_ends(0.9)["near"]
    assert "near" not in dead_ends(1.18)


def test_a_vehicle_turns_towards_a_place_only_when_nobody_stands_there() -> None:
    """So who stands in a dock needs half a length to its entry, where another one turns; not the half of a diagonal."""
    entry = (Node("x1", 3, 38), Node("x2", 5, 38), Node("x3", 7, 38))
    road = (Lane("x1", "x2", both_ways=True), Lane("x2", "x3", both_ways=True))
    spur = (*road, Lane("x2", "x4", both_ways=True))
    assert "near" not in floor((*entry, Node("x4", 5, 39.1)), spur)
    assert "x2 and x4 (1.08 m, 1.09 m needed)" in floor((*entry, Node("x4", 5, 39.08)), spur)["near"]


def test_a_vehicle_that_begins_across_its_lanes_needs_room_as_it_stands() -> None:
    file = load_plant("single-track").file
    nodes = (Node("x1", 3, 38), Node("x2", 3, 36), Node("x3", 4, 38), Node("x4", 4, 36))
    lanes = (Lane("x1", "x2"), Lane("x3", "x4"))
    kind = replace(file.vehicle_types[0], length_m=1.2, width_m=0.6)
    fleet = (
        replace(file.fleet[0], type=kind.id, node="x1"),
        replace(file.fleet[1], type=kind.id, node="x3"),
        *file.fleet[2:],
    )
    plant = Plant(
        replace(
            file,
            nodes=(*file.nodes, *nodes),
            lanes=(*file.lanes, *lanes),
            fleet=fleet,
            vehicle_types=(kind, *file.vehicle_types[1:]),
        )
    )
    found = {each: text for each, _, text, _ in floor_advice(plant)}
    assert "x1 and x3" in found["near"]
    elsewhere = Plant(replace(plant.file, fleet=file.fleet))
    assert "near" not in {each for each, _, _, about in floor_advice(elsewhere) if ("x1", "x3") in about}


CROSS = (Node("x1", 40, 38), Node("x2", 50, 38), Node("x3", 45, 36), Node("x4", 45, 41))


def test_lanes_that_cross_without_a_common_node_are_named() -> None:
    straight = (Lane("x1", "x2", both_ways=True), Lane("x3", "x4"))
    assert "x1 to x2 and x3 to x4; vehicles on them are not kept apart" in floor(CROSS, straight)["touch"]
    bent = (straight[0], Lane("x3", "x4", shape=(Point(45.0, 36.7), Point(54.0, 36.7), Point(54.0, 40.0))))
    assert "touch" not in floor(CROSS, bent)
    touching = (
        straight[0],
        Lane("x3", "x4", shape=(Point(45.0, 37.6), Point(54.0, 37.6), Point(54.0, 40.0))),
    )
    assert "x1 to x2 and x3 to x4" in floor(CROSS, touching)["touch"]
    met = (*CROSS, Node("x5", 45, 38))
    crossing = (Lane("x1", "x5"), Lane("x5", "x2"), Lane("x3", "x5"), Lane("x5", "x4"))
    assert "touch" not in floor(met, crossing)


def test_a_place_in_the_way_of_a_lane_is_narrow() -> None:
    nodes = (Node("x1", 40, 38), Node("x2", 50, 38), Node("x3", 45, 38.7), Node("x4", 45, 39.9))
    lanes = (Lane("x1", "x2", both_ways=True), Lane("x3", "x4", both_ways=True))
    assert "who stands at x3 (from x1 to x2, 0.11 m short) is in the way" in floor(nodes, lanes)["narrow"]
    far = (*nodes[:2], Node("x3", 45, 38.9), nodes[3])
    assert "narrow" not in floor(far, lanes)


def test_roads_too_short_for_a_stop_point_make_one_crossing() -> None:
    nodes = (Node("x1", 40, 38), Node("x2", 42, 38), Node("x3", 42, 39.9), Node("x4", 40, 39.9))
    lanes = (
        Lane("x1", "x2", both_ways=True),
        Lane("x2", "x3", both_ways=True),
        Lane("x1", "x4", both_ways=True),
    )
    found = floor(nodes, lanes, two_lanes=True)
    assert "no room for a stop point between x1 and x2 and x3 and x4" in found["crossing"]
    assert "crossing" not in floor(nodes, lanes)


def test_a_dock_in_the_only_way_to_others_is_in_the_way() -> None:
    nodes = (Node("x1", 40, 38), Node("x2", 45, 38), Node("x3", 50, 38))
    lanes = (
        Lane("x1", "x2", both_ways=True),
        Lane("x2", "x3", both_ways=True),
        Lane("e5", "x1", both_ways=True),
    )
    assert "vehicles dock at x2 in the only way" in floor(nodes, lanes, ("x2", "x3"))["way"]
    round_about = (*lanes, Lane("x1", "x3", both_ways=True))
    assert "way" not in floor(nodes, round_about, ("x2", "x3"))


def test_a_spur_and_a_drive_through_are_not_in_the_way() -> None:
    assert list(floor_advice(load_plant("single-track"))) == []


def test_two_lanes_in_the_default_plant_leave_what_is_too_near_to_be_said() -> None:
    plant = Plant(replace(load_plant("single-track").file, two_lanes=True))
    found = {each.kind: each.text for each in advice(plant)}
    assert set(found) == {"crossing", "narrow"}
    assert "b1 and s4-lane" in found["crossing"]


# --- rectangles -----------------------------------------------------------------------------------------

ANYWHERE = st.floats(-3.0, 3.0)
SIDE = st.floats(0.2, 2.0)
RECTANGLES = st.builds(Rectangle, ANYWHERE, ANYWHERE, st.floats(-4.0, 4.0), SIDE, SIDE)


def corners(of: Rectangle) -> list[complex]:
    turn = complex(0.0, of.heading_rad)
    return [
        complex(of.x_m, of.y_m) + exp(turn) * complex(a * of.length_m / 2, b * of.width_m / 2)
        for a, b in ((1, 1), (1, -1), (-1, -1), (-1, 1))
    ]


def holds(of: Rectangle, point: complex) -> bool:
    own = (point - complex(of.x_m, of.y_m)) * exp(complex(0.0, -of.heading_rad))
    return abs(own.real) <= of.length_m / 2 - 1e-9 and abs(own.imag) <= of.width_m / 2 - 1e-9


@settings(deadline=None)
@given(RECTANGLES, RECTANGLES)
def test_rectangles_with_a_point_in_common_overlap(a: Rectangle, b: Rectangle) -> None:
    one, other = corners(a), corners(b)
    points = [p + (q - p) * t / 8 for p, q in zip(one, (*one[1:], one[0]), strict=True) for t in range(9)]
    if any(holds(b, point) for point in points):
        assert gap_m(a, b) < 0
    assert gap_m(a, b) == pytest.approx(gap_m(b, a))
    if gap_m(a, b) > 0:
        apart = min(abs(p - q) for p in one for q in other)
        assert gap_m(a, b) <= apart + 1e-9
