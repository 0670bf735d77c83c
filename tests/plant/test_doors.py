"""Doors on lanes: which lanes lead through them, what a way through them costs, and what a file may not say of them."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import msgspec
import pytest
from msgspec.structs import replace

from dray.plant import (
    Door,
    Lane,
    LaneEnds,
    Node,
    Plant,
    Point,
    default_plant,
    load_plant,
    parse_plant,
    plant_yaml,
    shipped_plant,
    sum_up,
)
from dray.plant.exchange.lif_export import export_lif
from dray.plant.exchange.onto import put_onto
from dray.plant.exchange.read import read_layout
from dray.plant.file.check_doors import door_faults
from dray.plant.file.document import read_document
from dray.plant.file.unfinished import drawable
from dray.plant.floor.doors import doors_along
from dray.plant.planning.advice_floor import floor_advice
from dray.protocol.traffic.places import Places
from dray.protocol.traffic.ways import Ways

Break = Callable[..., list[tuple[str, str]]]

AREAS = "areas:\n"


def door(text: str) -> tuple[str, str]:
    return AREAS, f"doors:\n  - {{id: D1, name: Gate, {text}}}\n{AREAS}"


def with_doors(*doors: Door, plant: Plant | None = None) -> Plant:
    return Plant(replace((plant or default_plant()).file, doors=doors))


def on(start: str, end: str, *, opening_s: float = 10.0) -> Door:
    return Door("D1", "Gate", (LaneEnds(start, end),), opening_s)


FAULTS = {
    "an unknown lane": (
        "lanes: [{start: west, end: east}], opening_s: 5",
        "doors[0].lanes[0]",
        "no lane joins west and east: draw it, or name another",
    ),
    "one lane twice": (
        "lanes: [{start: west, end: middle}, {start: west, end: middle}], opening_s: 5",
        "doors[0].lanes[1]",
        "the lane from west to middle is named already",
    ),
    "both directions of one lane": (
        "lanes: [{start: west, end: middle}, {start: middle, end: west}], opening_s: 5",
        "doors[0].lanes[1]",
        "both directions are shut together: keep one of the two",
    ),
    "a negative time": (
        "lanes: [{start: west, end: middle}], opening_s: -5",
        "doors[0].opening_s",
        "expected `float` > 0.0",
    ),
    "a negative time to shut": (
        "lanes: [{start: west, end: middle}], opening_s: 5, closes_after_s: -1",
        "doors[0].closes_after_s",
        "expected `float` >= 0.0",
    ),
    "milliseconds": (
        "lanes: [{start: west, end: middle}], opening_s: 8000",
        "doors[0].opening_s",
        "8000 is not within 0.1 to 600: check the unit",
    ),
    "no lane": ("lanes: [], opening_s: 5", "doors[0].lanes", "write at least one entry"),
    "no time": ("lanes: [{start: west, end: middle}]", "doors[0]", "`opening_s` is missing: add it"),
    "an open time": (
        "lanes: [{start: west, end: middle}], opening_s: ~",
        "doors[0].opening_s",
        "is open: seconds from shut to open",
    ),
    "a misspelt field": (
        "lanes: [{start: west, end: middle}], opening_s: 5, opens: 3",
        "doors[0]",
        "`opens` is no field of this",
    ),
}


@pytest.mark.parametrize(("text", "field", "reason"), FAULTS.values(), ids=FAULTS)
def test_faults_of_doors(broken: Break, text: str, field: str, reason: str) -> None:
    found = broken(door(text))
    assert [name for name, _ in found] == [field]
    assert reason in found[0][1]


def test_two_doors_on_one_lane_and_two_of_one_name(broken: Break) -> None:
    text = "lanes: [{start: west, end: middle}], opening_s: 5}\n  - {id: D1, name: Other, lanes: [{start: middle, end: west}], opening_s: 5"
    assert broken(door(text)) == [
        ("doors[1].id", "D1 is the id of doors[0] already: choose another"),
        (
            "doors[1].lanes[0]",
            "the lane from west to middle is named already: both directions are shut together: keep one of the two",
        ),
    ]


def test_where_no_door_can_stand() -> None:
    file = default_plant().file

    def fault(named: Door, *lanes: Lane, nodes: tuple[Node, ...] = ()) -> str:
        changed = replace(file, nodes=(*file.nodes, *nodes), lanes=(*file.lanes, *lanes), doors=(named,))
        return "; ".join(f"{field}: {reason}" for field, reason in door_faults(changed))

    assert fault(on("c2", "c3")) == ""
    curve = Lane("a1", "b2", shape=(Point(17.0, 6.0), Point(17.0, 9.0)))
    assert "divide this one at a node" in fault(on("a1", "b2"), curve)
    assert "too short for a vehicle to stop before and after a door" in fault(on("e1", "ch2-lane"))
    assert "nobody can wait at m1-lane, which is a crossing" in fault(on("m1-lane", "m1"))
    nodes = Node("near", 7.0, 38.0), Node("nearer", 8.0, 38.0)
    short = fault(on("near", "nearer"), Lane("near", "nearer"), nodes=nodes)
    assert "near and nearer are 1.00 m apart: whoever turns there needs 1.79 m" in short


def test_a_door_that_reaches_into_another_lane_must_name_that_too() -> None:
    file = shipped_plant("single-track").file
    lane = next(lane for lane in file.lanes if lane.both_ways)
    apart = [each for each in file.lanes if each is not lane]
    two = (replace(lane, both_ways=False), Lane(lane.end, lane.start))
    named = replace(file, lanes=(*apart, *two), doors=(on(lane.start, lane.end),))
    (fault,) = door_faults(named)
    assert fault == (
        "doors[0].lanes",
        f"D1 is in the way from {lane.end} to {lane.start}, too: name that lane here, or move it away",
    )
    both = Door("D1", "Gate", (LaneEnds(lane.start, lane.end), LaneEnds(lane.end, lane.start)), 5.0)
    assert list(door_faults(replace(named, doors=(both,)))) == []


def test_a_road_of_two_lanes_is_shut_between_its_stop_points_in_both_directions() -> None:
    plant = with_doors(on("c2", "c3"))
    assert set(plant.door_on) == {("c2.to-c3", "c3.from-c2"), ("c3.to-c2", "c2.from-c3")}
    assert {(lane.start, lane.end) for door in plant.driven.doors for lane in door.lanes} == set(
        plant.door_on
    )
    assert dict(Plant(plant.driven).door_on).keys() == plant.door_on.keys()
    assert {end for lane in plant.door_on for end in lane} <= set(plant.stops)


def test_a_way_through_a_door_takes_its_opening_time_and_a_stop_longer() -> None:
    plain = shipped_plant("single-track")
    lane = next(lane for lane in plain.lanes if lane.length_m > 5.0)
    kind = next(iter(plain.vehicle_types.values()))
    before = plain.routes(kind.id).duration_s(lane.start, lane.end)
    shut = with_doors(on(lane.start, lane.end), plant=plain)
    after = shut.routes(kind.id).way(lane.start, lane.end)
    assert after.nodes == (lane.start, lane.end)
    assert after.duration_s == pytest.approx(before + 10.0)
    assert shut.roads.lane(lane.end, lane.start) is None or shut.door_on[lane.end, lane.start].id == "D1"


@pytest.mark.parametrize(("opening_s", "goes_through"), [(2.0, True), (120.0, False)])
def test_with_right_of_way_a_slow_door_is_gone_round_as_well(opening_s: float, goes_through: bool) -> None:
    plain = default_plant()
    kind = next(iter(plain.vehicle_types.values()))

    def way(plant: Plant) -> tuple[str, ...]:
        return Ways(plant, Places(plant), kind).way("c1.to-c2", "c3.to-c4") or ()

    assert {"c2.to-c3", "c3.from-c2"} < set(way(plain))
    shut = with_doors(on("c2", "c3", opening_s=opening_s))
    ends = set(pairwise(way(shut)))
    assert ends
    assert (not ends.isdisjoint(shut.door_on)) is goes_through


def test_it_is_written_and_read_and_a_file_without_doors_is_as_it_was() -> None:
    plant = with_doors(on("c2", "c3"))
    again = parse_plant(plant_yaml(plant), "x.yaml")
    assert again.file == plant.file
    assert "1 door, " in sum_up(again)
    assert "door" not in sum_up(default_plant())
    data = msgspec.to_builtins(default_plant().file)
    del data["doors"]
    assert msgspec.convert(data, type(plant.file)) == default_plant().file


def test_a_draft_whose_door_stands_nowhere_can_be_drawn_without_it() -> None:
    data = read_document(plant_yaml(with_doors(on("c2", "c3"))), "x.yaml").data
    assert isinstance(data, dict)
    data["lanes"] = [lane for lane in data["lanes"] if {lane["start"], lane["end"]} != {"c2", "c3"}]
    plant, whole = drawable(data)
    assert whole is not None
    assert not plant.doors


def test_lif_knows_no_doors_and_what_is_put_onto_the_plant_has_them_again() -> None:
    plant = with_doors(on("c2", "c3"))
    text = export_lif(plant, "2026-11-23T08:00:00Z")
    assert text == export_lif(default_plant(), "2026-11-23T08:00:00Z")
    assert put_onto(read_layout(text.encode(), "x.json").data, plant) == msgspec.to_builtins(plant.file)


def test_whoever_sees_some_lanes_sees_the_doors_on_these_alone() -> None:
    both = Door("D1", "Gate", (LaneEnds("c2", "c3"), LaneEnds("d2", "d3")), 5.0)
    away = Door("D2", "Other", (LaneEnds("a1", "b1"),), 5.0)
    lanes = [lane for lane in default_plant().file.lanes if lane.start == "d2"]
    assert doors_along((both, away), lanes) == (replace(both, lanes=(LaneEnds("d2", "d3"),)),)


def test_doors_before_which_nobody_can_turn_are_told_of_the_plant() -> None:
    def told(plant: Plant) -> str:
        return next((text for kind, _, text, _ in floor_advice(plant) if kind == "door"), "")

    two_lanes = with_doors(on("c1", "m11-lane"))
    assert told(two_lanes).startswith(
        "no lane leads back from before Gate at c1.to-m11-lane, Gate at m11-lane.to-c1: "
    )
    single = load_plant("single-track")
    assert told(with_doors(on("c1", "m11-lane"), plant=single)) == ""
    assert told(with_doors(on("m11-lane", "m11"), plant=single)).startswith(
        "no lane leads back from before Gate at m11: "
    )
