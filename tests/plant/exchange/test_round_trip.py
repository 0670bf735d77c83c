"""A plant that is written as LIF and read again is the same graph; put onto the plant, the same plant."""

from __future__ import annotations

from itertools import product

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from dray.plant import SHIPPED, Lane, Node, Plant, PlantFile, Point, default_plant, load_plant
from dray.plant.exchange.lif_export import VERSIONS, export_lif
from dray.plant.exchange.onto import put_onto
from dray.plant.exchange.read import read_layout
from dray.plant.file.unfinished import drawable
from dray.plant.model import LaneType
from dray_sim.plants.draw import draw_plant

AT = "2026-11-23T08:00:00Z"


def graph(plant: Plant) -> tuple[object, ...]:
    lanes = {
        (lane.start, lane.end): (lane.speed_limit_mps, lane.length_m, lane.heading_rad)
        for lane in plant.lanes
    }
    docks = {place: plant.node_of(place) for place in plant.places}
    return dict(plant.nodes), lanes, docks


def again(plant: Plant, version: str = "1.0.0") -> Plant:
    imported = read_layout(export_lif(plant, AT, version).encode(), "again.json")
    assert imported.mapping["format"] == f"LIF {version}"
    read, whole = drawable(imported.data)
    assert whole is not None
    assert [each["original"] for each in imported.mapping["nodes"]] == [
        each["id"] for each in imported.data["nodes"]
    ]
    assert put_onto(imported.data, plant) == msgspec.to_builtins(plant.file)
    docks = {one["id"]: one["node"] for one in imported.data["unassigned"]}
    assert {**{place: read.node_of(place) for place in read.places}, **docks} == graph(plant)[2]
    return read


def assert_same(plant: Plant) -> None:
    for version in VERSIONS:
        assert graph(again(plant, version))[:2] == graph(plant)[:2]


@pytest.mark.parametrize("name", SHIPPED)
def test_a_shipped_plant_comes_back_as_the_same_graph(name: str) -> None:
    assert_same(load_plant(name))


@pytest.mark.parametrize("two_lanes", [False, True])
def test_lanes_for_some_types_and_with_limits_of_their_own_come_back(two_lanes: bool) -> None:
    file = default_plant().file
    light, heavy = (kind.id for kind in file.vehicle_types)
    lanes = list(file.lanes)
    lanes[3] = replace(lanes[3], types=(LaneType(light), LaneType(heavy, 0.4)))
    lanes[5] = replace(lanes[5], types=(LaneType(light, 0.7),))
    plant = Plant(replace(file, lanes=tuple(lanes), two_lanes=two_lanes))
    for kind, version in product((light, heavy), VERSIONS):
        read = again(plant, version)
        driven = [
            {(lane.start, lane.end): lane.speed_limit_mps for lane in each.roads_of(kind).lanes}
            for each in (plant, read)
        ]
        assert driven[0] == driven[1]


def test_a_station_of_several_nodes_that_the_plant_has_is_not_asked_about_again() -> None:
    plant = default_plant()
    imported = read_layout(export_lif(plant, AT).encode(), "again.json").data
    imported["nodes"][0]["x_m"] += 0.1
    first = imported["unassigned"][0]
    more = {"id": f"{first['id']}.2", "node": imported["nodes"][1]["id"], "name": "x", "part_of": first["id"]}
    other = {**more, "id": "NEW", "part_of": None}
    imported["unassigned"] += [more, other]
    assert put_onto(imported, plant)["unassigned"] == [other]


@pytest.mark.parametrize("two_lanes", [False, True])
@pytest.mark.parametrize("seed", range(3))
def test_a_drawn_plant_comes_back_as_the_same_graph(seed: int, two_lanes: bool) -> None:
    assert_same(draw_plant(seed, small=True, two_lanes=two_lanes))


SPOTS = st.tuples(st.floats(0, 60, allow_subnormal=False), st.floats(0, 40, allow_subnormal=False))


@settings(max_examples=30, deadline=None)
@given(
    spots=st.lists(SPOTS, min_size=2, max_size=6, unique=True),
    pairs=st.lists(
        st.tuples(st.integers(0, 5), st.integers(0, 5), st.booleans(), st.lists(SPOTS, max_size=4)),
        max_size=8,
    ),
    limit_mps=st.floats(0.05, 50),
)
def test_any_nodes_and_lanes_come_back(
    spots: list[tuple[float, float]],
    pairs: list[tuple[int, int, bool, list[tuple[float, float]]]],
    limit_mps: float,
) -> None:
    nodes = tuple(Node(f"n{at}", *spot) for at, spot in enumerate(spots))
    lanes, taken = [], set()
    for start, end, both, shape in pairs:
        ends = (f"n{start % len(nodes)}", f"n{end % len(nodes)}")
        if ends[0] != ends[1] and not taken & {ends, ends[::-1]}:
            taken.add(ends)
            lanes.append(Lane(*ends, limit_mps, both, shape=tuple(Point(*spot) for spot in shape)))
    file = default_plant().file
    bare = PlantFile(
        "x", "X", 70.0, 50.0, nodes, tuple(lanes), (), (), (), (), (), (), (), file.vehicle_types, ()
    )
    assert_same(Plant(bare))


def test_a_layout_with_a_node_less_opens_what_stood_there() -> None:
    plant = default_plant()
    gone = replace(
        plant.file,
        nodes=tuple(node for node in plant.file.nodes if node.id != "m1"),
        lanes=tuple(lane for lane in plant.file.lanes if "m1" not in (lane.start, lane.end)),
        machines=plant.file.machines[1:],
    )
    imported = read_layout(export_lif(Plant(gone), AT).encode(), "less.json")
    result = put_onto(imported.data, plant)
    assert [one["id"] for one in result["machines"] if one["node"] is None] == ["M1"]
    assert result["unassigned"] == []


def test_lif_2_0_0_is_written_by_its_own_names() -> None:
    document = msgspec.json.decode(export_lif(default_plant(), AT, "2.0.0"))
    assert document["metaInformation"].keys() == {"lifId", "creator", "exportTimestamp", "lifVersion"}
    (origin,) = document["origins"]
    (layout,) = origin["layouts"]
    assert {"layoutId", "layoutVersion", "layoutDescriptor", "nodes", "edges", "stations"} <= layout.keys()
    properties = [one for node in layout["nodes"] for one in node["mobileRobotTypeNodeProperties"]]
    assert {"startCharging", "park", "pick"} <= {
        action["actionType"] for one in properties for action in one.get("feasibleActions", ())
    }
    kinds = [kind.id for kind in default_plant().file.vehicle_types]
    for edge in layout["edges"]:
        (shared,) = edge["mobileRobotTypeEdgeProperties"]
        assert [robot["seriesName"] for robot in shared["mobileRobotTypes"]] == kinds
        assert (shared["reachOrientationBeforeEntering"], shared["maximumSpeed"] > 0.0) == (True, True)
    text = export_lif(default_plant(), AT, "2.0.0")
    assert not [old for old in ("vehicleType", "maxSpeed", "requirementType", "Description") if old in text]
    notes = read_layout(text.encode(), "again.json").notes
    assert not [note for note in notes if "not understood" in note.text]


def test_lif_2_0_0_has_every_field_that_its_schema_requires() -> None:
    """By the published schema of 2.0.0: `required`, `minItems`, and ranges."""
    shaped = lane_with_a_shape()
    document = msgspec.json.decode(export_lif(shaped, AT, "2.0.0"))
    (origin,) = document["origins"]
    (layout,) = origin["layouts"]
    assert origin["originId"]
    assert {"layoutId", "layoutVersion", "nodes", "edges"} <= layout.keys()
    trajectories = []
    for node in layout["nodes"]:
        assert {"nodeId", "mapId", "nodePosition", "mobileRobotTypeNodeProperties"} <= node.keys()
        assert node["nodePosition"].keys() == {"x", "y"}
        for each in node["mobileRobotTypeNodeProperties"]:
            assert each["mobileRobotTypes"]
            for action in each.get("feasibleActions", ()):
                assert {"actionType", "blockingType"} <= action.keys()
    for edge in layout["edges"]:
        assert {"edgeId", "startNodeId", "endNodeId", "mobileRobotTypeEdgeProperties"} <= edge.keys()
        assert edge["mobileRobotTypeEdgeProperties"]
        for each in edge["mobileRobotTypeEdgeProperties"]:
            assert all(robot.keys() == {"manufacturer", "seriesName"} for robot in each["mobileRobotTypes"])
            trajectories += [each["trajectory"]] if "trajectory" in each else []
    assert trajectories
    for curve in trajectories:
        assert (type(curve["degree"]), curve["degree"]) == (int, 1)
        assert len(curve["knotVector"]) == len(curve["controlPoints"]) + curve["degree"] + 1
        assert 0.0 <= min(curve["knotVector"]) <= max(curve["knotVector"]) <= 1.0
    for station in layout["stations"]:
        assert {"stationId", "interactionNodeIds"} <= station.keys()
        assert station["interactionNodeIds"]


def lane_with_a_shape() -> Plant:
    file = default_plant().file
    first, *others = file.lanes
    nodes = {node.id: node for node in file.nodes}
    start, end = nodes[first.start], nodes[first.end]
    middle = Point((start.x_m + end.x_m) / 2.0 + 0.1, (start.y_m + end.y_m) / 2.0 + 0.1)
    return Plant(replace(file, lanes=(replace(first, shape=(middle,)), *others)))


@pytest.mark.parametrize("version", VERSIONS)
def test_an_export_has_our_ids_where_vehicles_know_others(version: str) -> None:
    file = default_plant().file
    (first, *others), (lane, *lanes) = file.nodes, file.lanes
    renamed = replace(
        file,
        nodes=(replace(first, originals=("17",)), *others),
        lanes=(replace(lane, original="E 17"), *lanes),
    )
    assert export_lif(Plant(renamed), AT, version) == export_lif(default_plant(), AT, version)
