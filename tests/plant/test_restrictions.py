"""Ways round what is closed, out of what was closed, and slowly over what is slow."""

from __future__ import annotations

from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dray.errors import NoWay
from dray.plant import Area, Lane, Node, Point, Roads, Routes, VehicleType
from dray.plant.restrictions import OPEN, Restrictions, extent_of

FAST = VehicleType(id="fast", name="Fast", max_speed_mps=1.5, acceleration_mps2=0.6, turn_speed_mps=0.5)
SIDE = 4
NODES = [Node(f"c{x}_{y}", x * 10.0, y * 10.0) for y in range(SIDE) for x in range(SIDE)]
ROADS = Roads(
    NODES,
    [Lane(f"c{x}_{y}", f"c{x + 1}_{y}", both_ways=True) for y in range(SIDE) for x in range(SIDE - 1)]
    + [Lane(f"c{x}_{y}", f"c{x}_{y + 1}", both_ways=True) for y in range(SIDE - 1) for x in range(SIDE)],
)
NAMES = [node.id for node in NODES]
ENDS = [(lane.start, lane.end) for lane in ROADS.lanes]


def ways(**restrictions: object) -> Routes:
    return Routes(ROADS, FAST, {}, Restrictions(**restrictions))  # type: ignore[arg-type]


@settings(max_examples=150, deadline=None)
@given(
    nodes=st.frozensets(st.sampled_from(NAMES), max_size=6),
    lanes=st.frozensets(st.sampled_from(ENDS), max_size=12),
    start=st.sampled_from(NAMES),
    goal=st.sampled_from(NAMES),
)
def test_no_way_enters_what_is_closed(
    nodes: frozenset[str], lanes: frozenset[tuple[str, str]], start: str, goal: str
) -> None:
    closed = Restrictions(nodes=nodes, lanes=lanes)
    try:
        way = Routes(ROADS, FAST, {}, closed).way(start, goal)
    except NoWay:
        reached = {start}
        while more := {b for a, b in ENDS if a in reached and b not in reached and closed.admits(a, b)}:
            reached |= more
        assert goal not in reached or goal in nodes
        return
    assert all(closed.admits(*ends) for ends in pairwise(way.nodes))
    outside = [node for node in way.nodes if node not in nodes]
    # It leaves once, and never comes back.
    assert [node for node in way.nodes[len(way.nodes) - len(outside) :] if node in nodes] == []


def test_a_vehicle_inside_takes_the_shortest_way_out() -> None:
    # To the goal it would be shorter to stay within two closed columns.
    closed = frozenset(f"c{x}_{y}" for x in (1, 2) for y in range(SIDE - 1))
    assert ways(nodes=closed).way("c1_0", "c1_3").nodes[1] == "c0_0"
    assert ways(nodes=closed).way_out("c1_2", NAMES).nodes == ("c1_2", "c0_2")


def test_who_stands_on_an_open_node_need_not_leave_it() -> None:
    assert ways(nodes=frozenset({"c1_1"})).way_out("c0_0", NAMES).nodes == ("c0_0",)


def test_a_vehicle_that_is_shut_in_has_no_way_out() -> None:
    lanes = frozenset(ends for ends in ENDS if ends[0] == "c0_0")
    with pytest.raises(NoWay):
        ways(nodes=frozenset({"c0_0"}), lanes=lanes).way_out("c0_0", NAMES)


def test_slow_lanes_take_longer_and_are_gone_round_when_that_is_shorter() -> None:
    direct = ways().way("c0_0", "c1_0")
    slow = ways(limits_mps=((("c0_0", "c1_0"), 0.5),)).way("c0_0", "c1_0")
    assert slow.nodes == direct.nodes
    assert slow.duration_s > 20.0 > direct.duration_s
    crawl = ways(limits_mps=((("c0_0", "c1_0"), 0.1),)).way("c0_0", "c1_0")
    assert crawl.nodes == ("c0_0", "c0_1", "c1_1", "c1_0")


def test_a_way_tells_where_it_is_slow() -> None:
    slow = Restrictions(limits_mps=((("c1_0", "c2_0"), 0.5),))
    assert slow.limits_on(("c0_0", "c1_0", "c2_0")) == (None, 0.5)
    assert slow.limits_on(("c0_0", "c1_0")) == ()
    assert OPEN.limits_on(("c0_0", "c1_0")) == ()


def test_an_area_has_the_nodes_within_it_and_the_lanes_that_cross_it() -> None:
    left, right = 3.0, 7.0
    area = Area("a", "A", (Point(left, -1.0), Point(right, -1.0), Point(right, 11.0), Point(left, 11.0)))
    extent = extent_of(area.polygon, {node.id: node for node in NODES}, ROADS)
    assert extent.nodes == frozenset()
    assert extent.across == {("c0_0", "c1_0"), ("c1_0", "c0_0"), ("c0_1", "c1_1"), ("c1_1", "c0_1")}
    wide = Area("b", "B", (Point(-1.0, -1.0), Point(11.0, -1.0), Point(11.0, 1.0), Point(-1.0, 1.0)))
    assert extent_of(wide.polygon, {node.id: node for node in NODES}, ROADS).nodes == {"c0_0", "c1_0"}
