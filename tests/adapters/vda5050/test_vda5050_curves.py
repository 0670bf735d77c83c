"""Lanes that are not straight: their corners are no nodes of an order, and their shape and length are said."""

from __future__ import annotations

from itertools import pairwise
from math import hypot
from typing import Any

import msgspec
import pytest
from msgspec.structs import replace
from official_schemas import MISSING, folder, objections
from vda_rig import FLOWING, PROFILE, Rig
from yard import LIGHT, PLANT, Yard

from dray.adapters.vda5050.commissioning import Commissioning, Wanted
from dray.adapters.vda5050.profile import Profile
from dray.body import ActionFailed, Drive, Hold, Unhold, WayDone
from dray.plant import Lane, Plant
from dray.plant.model import LaneType, Point
from dray_sim.clock.loop import JUMP, clock, run
from dray_sim.vda5050.misbehaviour import Misbehaviour

SHAPE = (Point(12.0, 3.0), Point(15.0, 4.0), Point(18.0, 3.0))
CORNERS = tuple(f"middle.to-east.{number}" for number in (1, 2, 3))
ROUND = ("west", "middle", *CORNERS, "east", "north")
BACK = ("north", "east", *CORNERS[::-1], "middle", "west")

BENT = Plant(
    msgspec.structs.replace(
        PLANT.file,
        lanes=tuple(
            Lane("middle", "east", both_ways=True, shape=SHAPE)
            if (lane.start, lane.end) == ("middle", "east")
            else lane
            for lane in PLANT.file.lanes
        ),
    )
)
POINTS = [(10.0, 0.0), *((point.x_m, point.y_m) for point in SHAPE), (20.0, 0.0)]
LENGTH_M = sum(hypot(b[0] - a[0], b[1] - a[1]) for a, b in pairwise(POINTS))

PROFILES: dict[str, Profile] = {
    "2.0 in steps": msgspec.structs.replace(PROFILE, version="2.0"),
    "2.1 with updates": FLOWING,
    "3.0 with a horizon": msgspec.structs.replace(FLOWING, version="3.0", horizon=2),
}


def bent_rig(profile: Profile, **options: Any) -> Rig:
    return Rig(profile, yard=Yard(BENT), **options)


def way(nodes: tuple[str, ...], order: int) -> Drive:
    return Drive(order=order, nodes=nodes, released=len(nodes))


@pytest.mark.parametrize("name", PROFILES)
def test_corners_are_no_nodes_of_an_order_and_are_passed_all_the_same(name: str) -> None:
    rig = bent_rig(PROFILES[name])
    rig.do(way(ROUND, 1), for_s=120.0)
    rig.do(way(BACK, 2), for_s=120.0)
    assert [type(report) for report in rig.heard[-1:]] == [WayDone]
    assert [node for node, _ in rig.passed()] == [*ROUND, *BACK]
    nodes = {node["nodeId"] for order in rig.orders() for node in order["nodes"]}
    assert nodes == {"west", "middle", "east", "north"}
    for order in rig.orders():
        # Counted together and without a gap, whatever was left out.
        first = order["nodes"][0]["sequenceId"]
        assert [node["sequenceId"] for node in order["nodes"]] == [
            first + 2 * number for number in range(len(order["nodes"]))
        ]
        assert [edge["sequenceId"] for edge in order["edges"]] == [
            first + 2 * number + 1 for number in range(len(order["edges"]))
        ]
        assert all(node["released"] for node in order["nodes"][:1])
    bent = [edge for order in rig.orders() for edge in order["edges"] if "trajectory" in edge]
    assert {edge["edgeId"] for edge in bent} == {"middle--east", "east--middle"}
    for edge in bent:
        assert edge["length"] == pytest.approx(LENGTH_M)
        there = POINTS if edge["edgeId"] == "middle--east" else POINTS[::-1]
        trajectory = edge["trajectory"]
        assert [(point["x"], point["y"]) for point in trajectory["controlPoints"]] == there
        assert len(trajectory["knotVector"]) == len(there) + 2
    if folder() is None:
        pytest.skip(MISSING)
    version = PROFILES[name].version
    assert [text for order in rig.orders() for text in objections(version, "order", order)] == []


def test_a_vehicle_that_knows_its_lanes_is_told_their_length_alone() -> None:
    rig = bent_rig(msgspec.structs.replace(PROFILE, trajectory=False))
    rig.do(way(ROUND, 1), for_s=120.0)
    edges = [edge for order in rig.orders() for edge in order["edges"]]
    assert not any("trajectory" in edge for edge in edges)
    assert [round(edge["length"], 6) for edge in edges if "length" in edge] == [round(LENGTH_M, 6)]


@pytest.mark.parametrize("restart_at", ["last_node", "temporary_node"])
@pytest.mark.parametrize("stop_s", [13.0, 16.0, 18.0, 21.0, 25.0])
def test_after_a_stop_on_a_curve_it_goes_on_from_where_it_is(stop_s: float, restart_at: Any) -> None:
    rig = bent_rig(msgspec.structs.replace(PROFILE, pause=False, restart_at=restart_at))
    rig.do(way(ROUND, 1), for_s=stop_s)
    rig.do(Hold(), for_s=20.0)
    rig.do(Unhold(), for_s=120.0)
    assert rig.failures() == []
    assert [node for node, _ in rig.passed()] == list(ROUND)
    known = {"west", "middle", "east", "north", *(["here"] if restart_at == "temporary_node" else [])}
    assert {node["nodeId"] for order in rig.orders() for node in order["nodes"]} <= known


@pytest.mark.parametrize("stop_s", [13.0, 16.0, 18.0, 21.0, 25.0])
def test_a_new_life_on_a_curve_drives_on(stop_s: float) -> None:
    rig = bent_rig(PROFILE)
    rig.do(way(ROUND, 1), for_s=stop_s)
    rig.begin_life()
    rig.run(40.0)
    begins = rig.body.sense().next_node
    assert begins in ("middle", "east")
    rig.do(way(BACK[BACK.index(begins) :], 2), for_s=120.0)
    assert rig.failures() == []
    assert rig.heard[-1] == WayDone(order=2, node="west")


def test_a_part_that_ends_at_a_corner_is_driven_to_the_node_before_it() -> None:
    rig = bent_rig(FLOWING)
    rig.do(Drive(order=1, nodes=ROUND, released=4), for_s=60.0)
    assert rig.passed()[-1] == ("middle", 1)
    assert rig.body.sense().speed_mps == 0.0


def test_commissioning_drives_a_curve_as_a_whole() -> None:
    async def play() -> Commissioning:
        yard = Yard(BENT)
        yard.clock = clock()
        rig = Rig(PROFILE, Misbehaviour(), yard=yard, node="middle")
        done = Commissioning(rig.body, BENT, LIGHT, PROFILE, rig.clock, Wanted(drive="east"))
        async for _ in done.run():
            pass
        return done

    done = run(play(), JUMP)
    assert [step.line for step in done.steps if step.passed is False] == []
    assert {step.name for step in done.steps if step.passed} >= {"drive", "pause", "back", "cancel"}


def test_an_order_has_the_limit_of_the_vehicles_type_and_no_lane_that_is_not_for_it() -> None:
    own = {("west", "middle"): (LaneType("light", 0.3),), ("middle", "pit"): (LaneType("other"),)}
    lanes = tuple(replace(lane, types=own.get((lane.start, lane.end), ())) for lane in PLANT.file.lanes)
    rig = Rig(yard=Yard(Plant(replace(PLANT.file, lanes=lanes))))
    rig.do(way(("west", "middle", "pit"), 1), for_s=5.0)
    assert [report.reason for report in rig.heard if isinstance(report, ActionFailed)] == [
        "no lane from middle to pit"
    ]
    rig.do(way(("west", "middle"), 2), for_s=30.0)
    edges = [edge for order in rig.orders() for edge in order["edges"]]
    assert {edge["maxSpeed"] for edge in edges} == {0.3}
