"""What an agent knows of closures: the newest list, signed, and by its own clock."""

from __future__ import annotations

from itertools import pairwise, permutations

import pytest
from closed import closure, closures
from defaults import PLANT
from msgspec.structs import replace
from seals import trusts_seals

from dray.codec import MAX_BYTES, encode
from dray.errors import NoWay
from dray.messages import Closure, ClosureKind, Closures
from dray.messages.floor.closure import MAX_CLOSURES, MAX_CORNERS
from dray.plant import load_plant
from dray.plant.restrictions import OPEN
from dray.protocol.closures.closure_rules import cut_off, lanes_of, restrictions_of
from dray.protocol.closures.known_floor import KNOWN, NOT_SIGNED, KnownFloor
from dray.protocol.runtime.events import NEVER_S


def test_two_agents_of_one_process_know_different_things() -> None:
    one, other = KnownFloor(PLANT), KnownFloor(PLANT)
    assert one.take(closures(1, closure(node="c3")), 0.0)
    assert "c3" not in one.routes("light").way("b3", "d3").nodes
    assert "c3" in other.routes("light").way("b3", "d3").nodes
    assert "c3" in PLANT.routes("light").way("b3", "d3").nodes


def test_agents_share_all_of_a_plant_but_what_each_of_them_knows() -> None:
    floor = KnownFloor(PLANT)
    floor.take(closures(1, closure(node="c3")), 0.0)
    own = {name for name, value in vars(floor).items() if vars(PLANT).get(name) is not value}
    assert own == {"restrictions", "said", "ends_s", "obstacles", "obstructed", "_current"}
    assert not own & vars(PLANT).keys(), "a plant that is shared has none of it"


THERE, BACK = ("a1.to-b1", "b1.from-a1"), ("b1.to-a1", "a1.from-b1")
"""The lanes of one road of the default plant."""


def test_a_road_of_two_lanes_is_closed_in_both_directions_and_one_way_leaves_one() -> None:
    plant = load_plant("default")
    closed = closure(start=THERE[0], end=THERE[1])
    assert restrictions_of(plant, [closed]).lanes == {THERE, BACK}
    slow = replace(closed, kind=ClosureKind.SLOW, speed_mps=0.5)
    assert restrictions_of(plant, [slow]).limits_mps == ((THERE, 0.5), (BACK, 0.5))
    assert restrictions_of(plant, [replace(closed, kind=ClosureKind.ONE_WAY)]).lanes == {BACK}


def test_every_lane_but_those_of_one_way_roads_has_one_that_leads_back() -> None:
    plant = load_plant("default")
    without = {
        lane for lane in plant.lanes if plant.roads.lane(*plant.way_back(lane.start, lane.end)) is None
    }
    assert {lane.start for lane in without} == {"delivery-lane", "delivery", "delivery-out"}
    assert all(
        plant.way_back(*plant.way_back(lane.start, lane.end)) == (lane.start, lane.end)
        for lane in plant.lanes
    )


def test_an_old_list_does_not_win() -> None:
    floor = KnownFloor(PLANT)
    floor.take(closures(2), 0.0)
    assert floor.objection(closures(1, closure(node="c3")), trusts_seals) == KNOWN
    assert floor.objection(closures(2, closure(node="c3")), trusts_seals) == KNOWN
    assert floor.objection(closures(3, closure(node="c3")), trusts_seals) == ""


def test_a_list_that_was_changed_on_its_way_is_not_signed() -> None:
    floor = KnownFloor(PLANT)
    said = closures(3, closure(node="c3"))
    for forged in (
        replace(said, number=4),
        replace(said, closures=()),
        replace(said, closures=(closure(node="c4"),)),
        replace(said, closures=(closure(node="c3", until_s=9.0),)),
        replace(said, closures=(closure(node="c3", outline=((0.0, 0.0), (9.0, 0.0), (9.0, 9.0))),)),
        replace(said, closures=(closure(node="c3", kind=ClosureKind.SLOW, speed_mps=0.5),)),
    ):
        assert floor.objection(forged, trusts_seals) == NOT_SIGNED


def test_a_closure_ends_by_itself_when_its_time_has_come() -> None:
    floor = KnownFloor(PLANT)
    floor.take(closures(1, closure(node="c3", until_s=60.0), closure("K2", node="c4")), 0.0)
    assert floor.ends_s == 60.0
    assert not floor.look(59.9)
    assert floor.look(60.0)
    assert floor.restrictions.nodes == {"c4"}
    assert floor.ends_s == NEVER_S


def test_a_list_with_nothing_in_it_opens_everything() -> None:
    floor = KnownFloor(PLANT)
    floor.take(closures(1, closure(node="c3")), 0.0)
    assert floor.take(closures(2), 0.0)
    assert floor.restrictions == OPEN
    assert floor.routes("light").way("b3", "d3") == PLANT.routes("light").way("b3", "d3")


def test_what_the_plant_does_not_have_is_left_out() -> None:
    unknown = [
        closure("K1", node="nowhere"),
        closure("K2", area="nowhere"),
        closure("K3", start="b3", end="nowhere"),
        closure("K4", start="a1", end="f5"),
        closure("K5", kind=ClosureKind.ONE_WAY, start="a1", end="f5"),
        closure("K6", kind=ClosureKind.SLOW, start="a1", end="f5", speed_mps=0.5),
        closure("K8", outline=((-9.0, -9.0), (-8.0, -9.0), (-8.0, -8.0))),
        closure("K9", outline=((0.0, 0.0), (60.0, 40.0))),
        closure("K7", kind=ClosureKind.SLOW, area="nowhere", speed_mps=0.5),
    ]
    assert restrictions_of(PLANT, unknown) == OPEN


def test_a_lane_is_closed_in_both_directions_and_one_way_in_one() -> None:
    both = restrictions_of(PLANT, [closure(start="b3", end="m4-lane")])
    assert both.lanes == {("b3", "m4-lane"), ("m4-lane", "b3")}
    one = restrictions_of(PLANT, [closure(kind=ClosureKind.ONE_WAY, start="b3", end="m4-lane")])
    assert one.lanes == {("m4-lane", "b3")}


def test_of_two_limits_on_a_lane_the_lower_one_holds() -> None:
    slow = [
        closure(f"K{mps}", kind=ClosureKind.SLOW, start="b3", end="m4-lane", speed_mps=mps)
        for mps in (0.8, 0.3, 0.5)
    ]
    assert dict(restrictions_of(PLANT, slow).limits_mps)["b3", "m4-lane"] == 0.3


def test_a_slow_area_has_slow_lanes_only_in_it() -> None:
    area = next(iter(PLANT.areas))
    slow = restrictions_of(PLANT, [closure(kind=ClosureKind.SLOW, area=area, speed_mps=0.4)])
    inside = {node.id for node in PLANT.nodes.values() if PLANT.is_in(node.x_m, node.y_m, (area,))}
    assert slow.limits_mps
    assert all(start in inside or end in inside for (start, end), _ in slow.limits_mps)
    assert len(slow.limits_mps) < len(PLANT.lanes)
    assert not slow.nodes
    assert not slow.lanes


def test_a_closed_crossing_of_two_lane_roads_is_entered_by_nobody() -> None:
    plant = load_plant("default")
    floor = KnownFloor(plant)
    floor.take(closures(1, closure(node="c3")), 0.0)
    crossing_lanes = set(plant.crossings["c3"].lanes)
    docks = [plant.node_of(machine) for machine in plant.machines]
    crossed = 0
    for start, goal in permutations(docks, 2):
        crossed += not crossing_lanes.isdisjoint(pairwise(plant.routes("light").way(start, goal).nodes))
        assert crossing_lanes.isdisjoint(pairwise(floor.routes("light").way(start, goal).nodes))
    assert crossed


def test_a_dock_that_is_closed_is_reached_by_nobody_and_left_by_who_is_there() -> None:
    floor = KnownFloor(PLANT)
    floor.take(closures(1, closure(node="m8")), 0.0)
    with pytest.raises(NoWay):
        floor.routes("light").way("b3", "m8")
    assert floor.routes("light").way("m8", "b3").nodes[0] == "m8"


def test_places_that_a_closure_cuts_off_are_named() -> None:
    assert cut_off(PLANT, OPEN) == ()
    assert cut_off(PLANT, restrictions_of(PLANT, [closure(node="m8")])) == ("M8",)
    assert cut_off(PLANT, restrictions_of(PLANT, [closure(start="m8-lane", end="m8")])) == ("M8",)
    only_in = closure(kind=ClosureKind.ONE_WAY, start="m8-lane", end="m8")
    assert cut_off(PLANT, restrictions_of(PLANT, [only_in])) == ("M8",)
    assert cut_off(PLANT, restrictions_of(PLANT, [closure(node="c3")])) == ()


def test_the_lanes_of_a_closure_are_told_for_drawing() -> None:
    assert lanes_of(PLANT, closure(node="m8")) == [("m8-lane", "m8")]
    assert set(lanes_of(PLANT, closure(start="m8-lane", end="m8"))) == {("m8-lane", "m8"), ("m8", "m8-lane")}
    one_way = closure(kind=ClosureKind.ONE_WAY, start="m8-lane", end="m8")
    assert lanes_of(PLANT, one_way) == [("m8", "m8-lane")]
    slow = closure(kind=ClosureKind.SLOW, node="m8", speed_mps=0.3)
    assert set(lanes_of(PLANT, slow)) == {("m8-lane", "m8"), ("m8", "m8-lane")}


def test_the_longest_list_is_one_that_a_bus_carries() -> None:
    longest = "x" * 128
    lane = Closure(longest, ClosureKind.ONE_WAY, longest, start=longest, end=longest, until_s=1e10 + 0.123456)
    outline = ((-123456.789, -123456.789),) * MAX_CORNERS
    drawn = Closure(
        longest, ClosureKind.SLOW, longest, outline=outline, speed_mps=0.123, until_s=1e10 + 0.123456
    )
    for each in (lane, drawn):
        said = Closures(number=2**53, signature=bytes(64), closures=(each,) * MAX_CLOSURES)
        assert len(encode(longest, said)) < MAX_BYTES


def test_an_outline_closes_what_an_area_of_that_shape_closes() -> None:
    area = next(iter(PLANT.areas.values()))
    outline = tuple((point.x_m, point.y_m) for point in area.polygon)
    for kind, speed_mps in ((ClosureKind.CLOSED, None), (ClosureKind.SLOW, 0.4)):
        drawn = closure(kind=kind, outline=outline, speed_mps=speed_mps)
        named = closure(kind=kind, area=area.id, speed_mps=speed_mps)
        assert restrictions_of(PLANT, [drawn]) == restrictions_of(PLANT, [named])
        assert lanes_of(PLANT, drawn) == lanes_of(PLANT, named)


def test_an_outline_between_nodes_closes_the_lanes_that_cross_it() -> None:
    a, b = PLANT.nodes["b3"], PLANT.nodes["m4-lane"]
    x_m, y_m = (a.x_m + b.x_m) / 2.0, (a.y_m + b.y_m) / 2.0
    triangle = ((x_m - 0.4, y_m - 0.4), (x_m + 0.4, y_m - 0.4), (x_m, y_m + 0.4))
    found = restrictions_of(PLANT, [closure(outline=triangle)])
    assert found.nodes == frozenset()
    assert found.lanes == {("b3", "m4-lane"), ("m4-lane", "b3")}
