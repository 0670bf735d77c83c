"""Vehicles that know only their own ids: orders have these, and what they say is understood by the map that they are on."""

from __future__ import annotations

from math import cos, pi, sin
from typing import Any

import msgspec
import pytest
from field import say
from hypothesis import given
from hypothesis import strategies as st
from vda_rig import PROFILE, Rig
from yard import LIGHT, PICK, PLANT, TO_CORNER, Yard, drive

from dray.adapters.vda5050.commissioning import Commissioning, Wanted
from dray.adapters.vda5050.control.names import Names
from dray.adapters.vda5050.profile import MapFrame, OwnNames, Profile, parse_profile
from dray.body import ActionDone, WayDone
from dray.errors import SettingsError
from dray.plant import Plant, PlantFile
from dray.plant.file.check_names import name_faults
from dray_sim.clock.loop import JUMP, clock, run
from dray_sim.vda5050.misbehaviour import Misbehaviour
from dray_sim.vda5050.own_map import Axes, OwnMap

LOWER = {"west": "1", "middle": "2", "east": "3", "pit": "4"}
UPPER = {"north": "1", "corner": "2"}
"""The ids of the vehicle begin anew on each of its maps."""

PLAIN_AXES = Axes()


def named(**more: Any) -> PlantFile:
    """The yard, as an import of a layout in two maps has it."""
    theirs = {node: ("lower", name) for node, name in LOWER.items()}
    theirs |= {node: ("upper", name) for node, name in UPPER.items()}
    nodes = tuple(
        msgspec.structs.replace(node, map=theirs[node.id][0], originals=(theirs[node.id][1],))
        for node in PLANT.file.nodes
    )
    lanes = tuple(
        msgspec.structs.replace(
            lane, original=f"{index} out", original_back=f"{index} in" if lane.both_ways else None
        )
        for index, lane in enumerate(PLANT.file.lanes)
    )
    storages = tuple(msgspec.structs.replace(one, original="1. Regal") for one in PLANT.file.storages)
    maps = (MapFrame("lower"), MapFrame("upper"))
    return msgspec.structs.replace(
        PLANT.file, **{"nodes": nodes, "lanes": lanes, "storages": storages, "maps": maps, **more}
    )


def own_map(upper: Axes = PLAIN_AXES, lower: Axes = PLAIN_AXES) -> OwnMap:
    nodes = {("lower", name): node for node, name in LOWER.items()}
    nodes |= {("upper", name): node for node, name in UPPER.items()}
    edges = {f"{index} {way}" for index in range(len(PLANT.file.lanes)) for way in ("out", "in")}
    return OwnMap(nodes, {"1. Regal": "S1"}, {"lower": lower, "upper": upper}, frozenset(edges))


PLAIN = msgspec.structs.replace(PROFILE, map=MapFrame())


def rig(file: PlantFile, vehicle: OwnMap, profile: Profile = PLAIN) -> Rig:
    return Rig(profile, yard=Yard(Plant(file)), own_map=vehicle)


def test_a_vehicle_that_is_on_another_map_at_once_has_come_by_lift_and_is_no_jump() -> None:
    one = rig(named(), own_map())
    one.run(1.0)
    one.sim.place_at("corner")
    one.vehicle.condition.last_node = "corner"
    say(one, 1.0)
    there = one.body.sense()
    assert (there.pose.x_m, there.pose.y_m) == (PLANT.nodes["corner"].x_m, PLANT.nodes["corner"].y_m)
    assert "a pose that jumps" not in one.body.control.view.odd


@pytest.mark.parametrize("version", ["2.0", "2.1", "3.0"])
@pytest.mark.parametrize("flows", [False, True])
def test_a_vehicle_that_knows_only_its_own_ids_drives_from_floor_to_floor_and_picks(
    version: Any, flows: bool
) -> None:
    vehicle = own_map()
    profile = msgspec.structs.replace(
        PLAIN, version=version, updates=flows, base_m=25.0 * flows, horizon=2 * flows
    )
    one = rig(named(), vehicle, profile)
    assert one.do(PICK, for_s=30.0) == [ActionDone(order=PICK.order)]
    assert WayDone(order=1, node="corner") in one.do(drive(*TO_CORNER), for_s=120.0)
    assert [node for node, _ in one.passed()] == list(TO_CORNER)
    assert (vehicle.unknown, one.problems(), one.failures()) == ([], [], [])
    assert {"1", "2", "3", "0 out"} <= vehicle.said
    assert not vehicle.said & set(TO_CORNER)
    assert one.body.control.view.said_node == "2"
    assert one.body.sense().node == "corner"


def test_without_the_names_such_a_vehicle_takes_no_order() -> None:
    one = rig(msgspec.structs.replace(PLANT.file), own_map())
    one.do(drive(*TO_CORNER), for_s=120.0)
    assert one.of(WayDone) == []


def test_a_profile_names_what_vehicles_of_its_type_call_otherwise() -> None:
    nodes = {("hall", f"tag{number}"): node.id for number, node in enumerate(PLANT.file.nodes)}
    vehicle = OwnMap(nodes, {"R-1": "S1"}, {"hall": Axes()})
    names = OwnNames(
        nodes={node: name for (_, name), node in nodes.items()},
        stations={"S1": "R-1"},
        edges={"west--middle": "E 1"},
        maps={"lower": "hall", "upper": "hall"},
    )
    # One map of its own for both floors of the plant.
    file = named(
        maps=(MapFrame("lower"),), nodes=tuple(msgspec.structs.replace(n, map="") for n in named().nodes)
    )
    one = rig(file, vehicle, msgspec.structs.replace(PLAIN, names=names))
    one.do(PICK, for_s=30.0)
    assert WayDone(order=1, node="corner") in one.do(drive(*TO_CORNER), for_s=120.0)
    assert "E 1" in vehicle.said
    assert one.body.control.view.names.strangers == ("maps.upper",)


def test_a_node_of_several_maps_is_told_apart_by_the_map() -> None:
    names = Names(Plant(named()), PLAIN)
    assert [names.ours("1", where) for where in ("lower", "upper", "", "cellar")] == [
        "west",
        "north",
        None,
        None,
    ]
    assert (names.ours("3", ""), names.ours("here", "lower")) == ("east", "here")
    # Its own id of another node counts for more than our id.
    swapped = OwnNames(nodes={"west": "east", "east": "west"})
    names = Names(PLANT, msgspec.structs.replace(PLAIN, names=swapped))
    assert [names.ours(node, "hall") for node in ("west", "east", "north")] == ["east", "west", "north"]
    assert names.edge("west", "middle") == "east--middle"


@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        (
            {"maps": (MapFrame("lower"), MapFrame("lower"), MapFrame("upper"))},
            "maps[1].id: lower is there twice",
        ),
        ({"maps": (MapFrame("lower"), MapFrame("upper"), MapFrame())}, "maps[2].id: is empty"),
        ({"maps": (MapFrame("lower"),)}, ".map: there is no map upper in `maps` (lower)"),
    ],
)
def test_maps_that_cannot_be_are_named(changes: Any, fault: str) -> None:
    assert list(name_faults(named())) == []
    assert any(fault in f"{field}: {reason}" for field, reason in name_faults(named(**changes)))


def test_two_nodes_that_vehicles_call_alike_on_one_map_are_named() -> None:
    nodes = tuple(msgspec.structs.replace(node, map="lower") for node in named().nodes)
    told = [f"{field}: {reason}" for field, reason in name_faults(named(nodes=nodes))]
    assert len(told) == 2
    assert "vehicles call west 1, too on map lower: write what they call this one" in " ".join(told)


@pytest.mark.parametrize(
    "text",
    [
        "map: {scale: 0}",
        "map: {x_m: .nan}",
        "maps: [{id: a, heading_deg: 1000}]",
        "names: {nodes: {west: 1}}",
    ],
)
def test_a_profile_that_cannot_be_says_where(text: str) -> None:
    with pytest.raises(SettingsError, match=r"profile.yaml: .*\$\.(map|names)"):
        parse_profile(text.encode(), "profile.yaml")


def checked(
    file: PlantFile,
    vehicle: OwnMap,
    profile: Profile = PLAIN,
    quirks: Misbehaviour | None = None,
    node: str = "west",
) -> Commissioning:
    async def play() -> Commissioning:
        yard = Yard(Plant(file))
        yard.clock = clock()
        one = Rig(profile, quirks, yard=yard, own_map=vehicle, node=node)
        done = Commissioning(one.body, Plant(file), LIGHT, profile, one.clock, Wanted())
        async for _ in done.run():
            pass
        return done

    return run(play(), JUMP)


def test_dray_vehicle_check_names_what_the_vehicle_calls_otherwise() -> None:
    assert (
        "ok   names        its last node is west, which it calls 1, on map lower"
        in checked(named(), own_map()).report()
    )
    strange = checked(PLANT.file, own_map())
    assert "NO   names        its last node is 1, and no node of the plant is called so" in strange.report()
    assert not strange.passed
    profile = msgspec.structs.replace(PLAIN, names=OwnNames(nodes={"wset": "1"}))
    assert (
        "its profile names nodes.wset, which the plant does not have"
        in checked(named(), own_map(), profile).report()
    )
    maps = (MapFrame("ground"), MapFrame("upper"))
    nodes = tuple(msgspec.structs.replace(n, map="") if n.map == "lower" else n for n in named().nodes)
    other = checked(named(maps=maps, nodes=nodes), own_map())
    assert "it is on map lower; plant file and profile have ground, upper: write it there" in other.report()
    silent = checked(named(), own_map(), quirks=Misbehaviour(no_last_node=True))
    assert "--   names        it names no node" in silent.report()


TURNED = MapFrame("upper", x_m=40.0, y_m=-7.0, heading_deg=90.0, mirrored=True, scale=0.001)


@pytest.mark.parametrize("where", ["plant file", "profile"])
def test_each_floor_has_a_map_of_its_own_that_is_mirrored_turned_scaled_and_begins_elsewhere(
    where: str,
) -> None:
    upper = Axes(x_m=40.0, y_m=-7.0, turn=pi / 2.0, flip=-1, unit_m=0.001)
    vehicle = own_map(upper, Axes(x_m=-3.0, y_m=2.0))
    maps = (MapFrame("lower", x_m=-3.0, y_m=2.0), TURNED)
    if where == "plant file":
        one = rig(named(maps=maps), vehicle)
    else:
        one = rig(named(), vehicle, msgspec.structs.replace(PLAIN, maps=maps))
    assert WayDone(order=1, node="corner") in one.do(drive(*TO_CORNER), for_s=120.0)
    assert (vehicle.unknown, one.problems()) == ([], [])
    # At corner (30, 10), to which it came from the west: in millimetres, along axes that lie north and east.
    pose = one.body.sense().pose
    assert (round(pose.x_m, 3), round(pose.y_m, 3), round(pose.heading_rad, 3)) == (30.0, 10.0, 0.0)
    said = one.said("state", "it")[-1]["agvPosition"]
    assert (round(said["x"]), round(said["y"]), said["mapId"]) == (17000, -10000, "upper")
    at = one.orders()[-1]["nodes"][-1]["nodePosition"]
    assert (round(at["x"]), round(at["y"]), at["mapId"]) == (17000, -10000, "upper")
    assert at["allowedDeviationXY"] == pytest.approx(500.0)


def test_a_pose_on_a_map_that_nobody_has_told_of_is_a_problem_that_names_the_known_ones() -> None:
    vehicle = own_map()
    one = rig(named(), vehicle)
    one.run(2.0)
    said = one.said("state", "it")[-1]
    said |= {"headerId": said["headerId"] + 1, "agvPosition": {**said["agvPosition"], "mapId": "roof"}}
    one.give("state", msgspec.json.encode(said))
    one.run(2.0)
    assert one.problems() == ["it is on a map that is not lower or upper"]


@given(
    frame=st.builds(
        MapFrame,
        st.just("m"),
        st.floats(-1e3, 1e3),
        st.floats(-1e3, 1e3),
        st.floats(-360, 360),
        st.booleans(),
        st.floats(1e-3, 1e3),
    ),
    x_m=st.floats(-100, 100),
    y_m=st.floats(-100, 100),
)
def test_a_point_comes_back_through_any_map_and_angles_turn_with_it(
    frame: MapFrame, x_m: float, y_m: float
) -> None:
    x, y = frame.to_map(x_m, y_m)
    back_x_m, back_y_m, _ = frame.to_plant(x, y, 0.0)
    assert (back_x_m, back_y_m) == (pytest.approx(x_m, abs=1e-6), pytest.approx(y_m, abs=1e-6))
    # A step along a heading of the map leads along that heading in the plant.
    theta = 0.7
    ahead_x_m, ahead_y_m, _ = frame.to_plant(x + cos(theta) / frame.scale, y + sin(theta) / frame.scale, 0.0)
    turned = frame.to_plant(x, y, theta)[2]
    assert ahead_x_m - back_x_m == pytest.approx(cos(turned), abs=1e-6)
    assert ahead_y_m - back_y_m == pytest.approx(sin(turned), abs=1e-6)


@pytest.mark.parametrize(
    ("axes", "advice"),
    [
        (Axes(flip=-1), 'with map: {id: "upper", mirrored: true} it would stand at its last node north'),
        (Axes(unit_m=0.001), 'with map: {id: "upper", scale: 0.001} it'),
        (Axes(turn=pi), 'with map: {id: "upper", heading_deg: 180} it'),
        (Axes(x_m=4.0, y_m=-3.5), 'with map: {id: "upper", x_m: 4, y_m: -3.5} it'),
        (Axes(), ""),
    ],
)
def test_dray_vehicle_check_suggests_how_the_map_lies(axes: Axes, advice: str) -> None:
    done = checked(named(), own_map(axes), node="north")
    line = next(step.line for step in done.steps if step.name == "position")
    if not advice:
        assert line.endswith("(20.00, 10.00) is at north, 0.00 m from north")
        return
    assert advice in line
    again = checked(named(), own_map(axes), done.suggested(), node="north")
    assert again.passed
    assert "(20.00, 10.00) is at north, 0.00 m from north" in again.report()
