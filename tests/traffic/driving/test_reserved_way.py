"""A reserved way: what is held ahead and behind, as a vehicle drives."""

from __future__ import annotations

import pytest

from dray.plant import load_plant
from dray.protocol.traffic.driving.reserved_way import SHORTEN_AT, ReservedWay
from dray.protocol.traffic.places import Places

PLACES = Places(load_plant("single-track"))


def way_from(node: str, *ahead: str) -> ReservedWay:
    way = ReservedWay(PLACES, node)
    way.turn_to((node, *ahead))
    return way


def test_whoever_stands_holds_one_node_and_wants_the_next() -> None:
    way = way_from("b3", "m4-lane", "c3")
    assert set(way.held) == {"b3"}
    assert way.groups(1.0) == [("m4-lane",)]


def test_what_is_granted_is_held_only_as_far_as_it_continues_the_base() -> None:
    way = way_from("b3", "m4-lane", "c3")
    assert not way.take(["c3"])
    assert set(way.held) == {"b3"}
    assert way.take(["m4-lane", "c3"])
    assert way.base == ("m4-lane", "c3")


def test_half_a_group_is_not_taken() -> None:
    way = way_from("b3", "m4-lane", "m4")
    assert not way.take(["m4-lane"])
    assert way.take(["m4-lane", "m4"])


def test_a_node_is_given_back_when_the_vehicle_is_clear_of_it() -> None:
    way = way_from("b3", "m4-lane", "c3")
    way.take(["m4-lane"])
    clear_m = PLACES.clear_m("b3", "m4-lane")
    way.move(clear_m - 0.1)
    assert not way.give_back()
    assert way.next_clear_m() == pytest.approx(0.1)
    way.move(clear_m)
    assert way.give_back()
    assert set(way.held) == {"m4-lane"}


def test_the_place_where_it_stands_is_never_given_back() -> None:
    way = way_from("b3", "m4-lane", "c3")
    way.take(["m4-lane"])
    way.pass_next()
    way.give_back()
    assert way.stands
    assert set(way.held) == {"m4-lane"}


def test_the_base_is_never_taken_back() -> None:
    way = way_from("b3", "m4-lane", "c3")
    way.take(["m4-lane"])
    way.turn_to(("m4-lane", "m4"))
    assert way.base == ("m4-lane",)
    assert way.ahead == ("m4-lane", "m4")


def test_who_stands_at_a_dock_keeps_nobody_off_the_crossing_before_it() -> None:
    plant = load_plant("default")
    places = Places(plant)
    crossing, dock = "m5-lane", "m5"
    before = next(lane.start for lane in plant.roads.entering[crossing] if lane.start != dock)
    behind = next(lane.end for lane in plant.roads.leaving[crossing] if lane.end != dock)
    way = ReservedWay(places, before)
    way.turn_to((before, crossing, dock))
    assert way.take([crossing, dock])
    for left in ({before, crossing, dock}, {dock}):
        way.pass_next()
        way.give_back()
        assert set(way.held) == left
    way.turn_to((dock, crossing, behind))
    assert way.groups(1.0) == [(crossing, behind)]


def test_a_request_names_places_of_one_district_only() -> None:
    way = way_from("b3", "m4-lane", "c3", "m5-lane")
    groups = way.groups(100.0)
    districts = {PLACES.district_of[place] for group in groups for place in group}
    assert [district.partition(".")[0] for district in districts] == ["M4"]
    assert groups == [("m4-lane",), ("c3",)]


def test_a_way_through_a_node_twice_holds_it_until_the_second_time() -> None:
    way = way_from("b3", "m4-lane", "b3")
    way.take(["m4-lane"])
    way.take(["b3"])
    way.pass_next()
    way.give_back()
    assert "b3" in way.held


def test_a_new_life_on_a_lane_holds_both_its_ends() -> None:
    way = ReservedWay(PLACES, "b3", "m4-lane")
    assert set(way.held) == {"b3", "m4-lane"}
    assert way.base == ("m4-lane",)


def test_a_long_way_is_forgotten_behind() -> None:
    way = way_from("b3", *(("m4-lane", "b3") * SHORTEN_AT))
    for _ in range(2 * SHORTEN_AT - 1):
        assert way.take(["m4-lane", "b3"]) or way.base
        way.pass_next()
        way.give_back()
        assert len(way.held) <= 2
    assert way.node == "m4-lane"


def test_each_place_after_the_base_is_needed_first_by_one_lane() -> None:
    way = way_from("b3", "m4-lane", "m4", "m4-lane", "c3")
    lanes = way.lanes_to()
    assert lanes["m4-lane"] == ("b3", "m4-lane")
    assert lanes["m4"] == ("m4-lane", "m4")
    assert lanes["c3"] == ("m4-lane", "c3")
    way.take(["m4-lane", "m4"])
    assert way.lanes_to() == {"c3": ("m4-lane", "c3")}
