"""Places: what is held, by whom it is granted, and when it is given back."""

from __future__ import annotations

from itertools import pairwise
from math import hypot

import msgspec
import pytest

from dray.plant import Plant, default_plant, load_plant
from dray.plant.model import Lane, Node
from dray.protocol.traffic.dead_ends import NODES_MAX
from dray.protocol.traffic.places import REPLICAS, Crossing, Footprint, Places
from dray_sim.plants.generator import generate_plant


def test_every_node_of_the_default_plant_has_a_district_with_three_replicas() -> None:
    plant = load_plant("single-track")
    places = Places(plant)
    assert set(places.district_of) == set(plant.nodes)
    assert all(len(replicas) == REPLICAS for replicas in places.replicas_of.values())
    assert all(district.startswith(f"{replicas[0]}.") for district, replicas in places.replicas_of.items())


def test_the_nearest_machine_keeps_the_table_and_ties_go_by_id() -> None:
    places = Places(load_plant("single-track"))
    assert places.district_of["m5-lane"].startswith("M5.")
    # c3 is as far from M4 as from M5.
    assert places.district_of["c3"].startswith("M4.")


def test_every_agent_works_out_the_same() -> None:
    one, other = Places(load_plant("single-track")), Places(load_plant("single-track"))
    assert one.district_of == other.district_of
    assert one.replicas_of == other.replicas_of


def test_a_dock_belongs_to_its_entry() -> None:
    places = Places(load_plant("single-track"))
    assert places.dock_entries["m4"] == "m4-lane"
    assert places.dock_entries["delivery"] == "delivery-in"
    for dock, entry in places.dock_entries.items():
        assert places.district_of[dock] == places.district_of[entry]


def test_a_dock_is_taken_with_its_entry_and_an_entry_alone_on_the_way_past() -> None:
    places = Places(load_plant("single-track"))
    assert places.group_end(("b3", "m4-lane", "m4"), 1) == 2
    assert places.group_end(("b3", "m4-lane", "c3"), 1) == 1


def test_a_crossing_is_taken_with_the_stop_point_behind_it() -> None:
    plant = load_plant("single-track")
    crossing = Crossing(
        "X", 22.0, 20.0, frozenset({("b3", "m4-lane"), ("m4-lane", "c3")}), frozenset({"m4-lane"})
    )
    places = Places(plant, crossings=(crossing,))
    assert places.needs("b3", "m4-lane") == ("X",)
    assert places.needs("m4-lane", "c3") == ("X", "c3")
    assert not places.may_stop("m4-lane")
    assert places.group_end(("b3", "m4-lane", "c3", "m5-lane"), 1) == 2
    assert places.district_of["X"] == places.district_of["c3"]


def test_a_dead_end_is_taken_from_its_fork_to_the_goal_and_left_node_by_node() -> None:
    places = Places(plant_with_dead_end(3))
    assert places.dead_ends == {"x1": "b3", "x2": "x1", "x3": "x2"}
    assert places.group_end(("m4-lane", "b3", "x1", "x2", "x3"), 1) == 4
    assert places.group_end(("m4-lane", "b3", "x1"), 1) == 2
    assert places.group_end(("x1", "x2", "x3"), 1) == 2
    assert places.group_end(("x3", "x2", "x1", "b3", "m4-lane"), 1) == 1
    assert places.group_end(("m4-lane", "b3", "b2"), 1) == 1
    assert len({places.district_of[place] for place in ("b3", "x1", "x2", "x3")}) == 1


@pytest.mark.parametrize(("nodes", "gap_m"), [(NODES_MAX + 1, 1.5), (3, 20.0)], ids=["nodes", "metres"])
def test_a_dead_end_beyond_what_one_vehicle_may_be_granted_is_driven_node_by_node(
    nodes: int, gap_m: float
) -> None:
    assert not Places(plant_with_dead_end(nodes, gap_m)).dead_ends


def test_a_one_way_road_through_a_dock_is_no_dead_end() -> None:
    file = plant_with_dead_end(1).file
    lanes = tuple(lane for lane in file.lanes if {lane.start, lane.end} != {"m4", "m4-lane"})
    assert len(lanes) == len(file.lanes) - 1
    plant = Plant(msgspec.structs.replace(file, lanes=(*lanes, Lane("x1", "m4"), Lane("m4", "m4-lane"))))
    places = Places(plant)
    assert places.dock_entries["m4"] == "x1"
    assert not places.dead_ends


def plant_with_dead_end(count: int, gap_m: float = 1.5) -> Plant:
    """The plant `single-track` with a dead end at b3: nodes x1, x2 and so on."""
    file = load_plant("single-track").file
    fork = next(node for node in file.nodes if node.id == "b3")
    spots = [
        Node(f"x{number}", fork.x_m + gap_m * number, fork.y_m - gap_m * number)
        for number in range(1, count + 1)
    ]
    names = ["b3", *(node.id for node in spots)]
    lanes = [Lane(here, there, both_ways=True) for here, there in pairwise(names)]
    return Plant(msgspec.structs.replace(file, nodes=(*file.nodes, *spots), lanes=(*file.lanes, *lanes)))


def test_a_plant_with_few_machines_has_stations_keep_tables_too() -> None:
    file = load_plant("single-track").file
    plant = Plant(msgspec.structs.replace(file, machines=file.machines[:1]))
    places = Places(plant)
    assert all(len(replicas) == REPLICAS for replicas in places.replicas_of.values())
    assert {"M1", "S1"} <= {replica for replicas in places.replicas_of.values() for replica in replicas}


@pytest.mark.parametrize(("angle_rad", "more"), [(1.57, False), (0.5, True), (3.1, False)])
def test_a_sharp_corner_is_cleared_later(angle_rad: float, *, more: bool) -> None:
    size = Footprint()
    assert (size.clear_m(angle_rad) > size.spacing_m) == more


def test_lanes_that_leave_at_a_sharp_angle_are_cleared_later() -> None:
    file = load_plant("single-track").file
    sharp = Plant(msgspec.structs.replace(file, lanes=(*file.lanes, Lane("b3", "a4", both_ways=True))))
    assert Places(sharp).clear_m("b3", "a4") > Places(sharp).clear_m("d3", "m6-lane")


@pytest.mark.parametrize("plant", [default_plant(), generate_plant(1, 20, 50)], ids=["default", "generated"])
def test_whoever_stands_behind_a_crossing_is_clear_of_where_it_waited_and_in_nobody_s_way(
    plant: Plant,
) -> None:
    places, size = Places(plant), Footprint.of(plant)
    turned_back = 0
    for lane in plant.roads.lanes:
        if not (places.may_stop(lane.start) and places.may_stop(lane.end)):
            continue
        assert places.clear_m(lane.start, lane.end) <= lane.length_m
        if len(places.needs(lane.start, lane.end)) == 1 or lane.length_m > size.spacing_m + 1.0:
            continue
        turned_back += 1
        stands = spot_m(plant, lane.end)
        for other in (*plant.roads.leaving[lane.start], *plant.roads.entering[lane.start]):
            if lane.end not in (other.start, other.end):
                gap_m = from_lane_m(stands, spot_m(plant, other.start), spot_m(plant, other.end))
                assert gap_m > size.turning_radius_m + size.width_m / 2.0
    assert turned_back > 50


def spot_m(plant: Plant, node: str) -> tuple[float, float]:
    return plant.nodes[node].x_m, plant.nodes[node].y_m


def from_lane_m(spot: tuple[float, float], start: tuple[float, float], end: tuple[float, float]) -> float:
    """From a spot to the nearest one on a straight lane."""
    dx_m, dy_m = end[0] - start[0], end[1] - start[1]
    along = ((spot[0] - start[0]) * dx_m + (spot[1] - start[1]) * dy_m) / (dx_m**2 + dy_m**2)
    part = min(max(along, 0.0), 1.0)
    return hypot(spot[0] - start[0] - part * dx_m, spot[1] - start[1] - part * dy_m)
