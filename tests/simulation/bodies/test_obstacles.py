"""What lies on a lane is in the way of bodies: they stop before it, say so, and go on when it is gone."""

from __future__ import annotations

from heapq import heappop
from math import cos, sin

import pytest
from yard import LIGHT, PICK, PLANT, Yard, drive, passed

from dray.body import OpenDock, WayBlocked, WayDone, WayFree
from dray.plant.floor.rectangles import Rectangle, gap_m
from dray_sim.bodies.floor import TAKEN_UP_WITHIN_S, Floor
from dray_sim.bodies.obstacles import CLEAR_M, FALLS_M, SIZES_M, STEP_M, Obstacles
from dray_sim.bodies.vehicle.condition import LOAD_DROPPED
from dray_sim.clock.loop import VirtualClock
from dray_sim.faults import Thing


@pytest.fixture
def floor() -> Floor:
    return Floor(PLANT, VirtualClock(), seed=1)


def lanes() -> list[tuple[str, str]]:
    return [(lane.start, lane.end) for lane in PLANT.roads.lanes]


def test_a_vehicle_stops_before_the_lane_says_so_once_and_goes_on_when_it_is_free(yard: Yard) -> None:
    obstacles = yard.obstacles
    vehicle = yard.vehicle()
    obstacles.put(("middle", "east"), "pallet")
    yard.do(vehicle, drive("west", "middle", "east"), for_s=100.0)
    vehicle.look()
    yard.run(yard.clock.now_s() + 10.0)
    assert [node for _, node in passed(yard)] == ["west", "middle"]
    said = [report for _, _, report in yard.said]
    assert said.count(WayBlocked(order=1, start="middle", end="east", entered=False)) == 1
    assert vehicle.sense().speed_mps == 0.0
    assert vehicle.sense().next_node == "middle"
    obstacles.take_away(("middle", "east"))
    vehicle.look()
    yard.run(yard.clock.now_s() + 60.0)
    said = [report for _, _, report in yard.said]
    assert said.count(WayFree(order=1, start="middle", end="east")) == 1
    assert said[-1] == WayDone(order=1, node="east")


def test_on_the_lane_it_stops_before_the_thing_and_cannot_turn(yard: Yard) -> None:
    vehicle = yard.vehicle()
    yard.do(vehicle, drive("west", "middle", "east"), for_s=1.0)
    yard.obstacles.put(("west", "middle"), "person")
    assert vehicle.can_stop
    vehicle.look()
    yard.run(60.0)
    assert yard.said[-1][2] == WayBlocked(order=1, start="west", end="middle", entered=True)
    room_m = yard.obstacles.room_m("west", "middle", LIGHT)
    assert room_m is not None
    start = PLANT.nodes["west"]
    pose = vehicle.sense().pose
    assert ((pose.x_m - start.x_m) ** 2 + (pose.y_m - start.y_m) ** 2) ** 0.5 == pytest.approx(room_m)
    assert vehicle.sense().next_node == "middle"


def test_what_a_vehicle_has_passed_already_opens_no_way_into_what_it_stands_before(yard: Yard) -> None:
    vehicle = yard.vehicle()
    yard.do(vehicle, drive("west", "middle", "east"), for_s=1.0)
    yard.obstacles.put(("west", "middle"), "person")
    vehicle.look()
    yard.run(60.0)
    stands = vehicle.sense().pose
    west, along = PLANT.nodes["west"], stands.heading_rad
    behind = Rectangle(west.x_m - 0.7 * cos(along), west.y_m - 0.7 * sin(along), along, 0.2, 0.2)
    yard.obstacles.lay(("middle", "west"), behind)
    assert yard.obstacles.room_m("west", "middle", LIGHT) == 0.0
    vehicle.look()
    yard.run(120.0)
    assert vehicle.sense().pose == stands


@pytest.mark.parametrize("thing", list(SIZES_M))
def test_as_far_as_a_vehicle_may_drive_it_keeps_clear_of_the_thing(thing: str) -> None:
    kind = next(iter(PLANT.vehicle_types.values()))
    for lane in lanes():
        obstacles = Obstacles(PLANT)
        obstacles.put(lane, thing)
        shape = obstacles.shapes[lane]
        assert obstacles.room_m(*lane, kind) is not None
        assert obstacles.room_m(lane[1], lane[0], kind) is not None
        for start, end in lanes():
            road = PLANT.roads.lane(start, end)
            assert road is not None
            room_m = obstacles.room_m(start, end, kind)
            from_m = road.length_m if room_m is None else room_m
            here, there = PLANT.nodes[start], PLANT.nodes[end]
            part = from_m / road.length_m
            body = Rectangle(
                here.x_m + part * (there.x_m - here.x_m),
                here.y_m + part * (there.y_m - here.y_m),
                road.heading_rad,
                kind.length_m,
                kind.width_m,
            )
            if from_m > 0.0:
                assert gap_m(body, shape) > CLEAR_M - 2.0 * STEP_M


def test_nothing_is_put_under_a_vehicle_or_where_something_lies(floor: Floor) -> None:
    atv, vehicle = next(iter(floor.vehicles.items()), ("", None))
    if vehicle is None:
        vehicle = floor.add_vehicle(PLANT.fleet[next(iter(PLANT.fleet))])
    node = vehicle.sense().node
    near = next(lane for lane in lanes() if lane[0] == node)
    far = next(lane for lane in lanes() if node not in lane)
    vehicle.place_at(far[0])
    assert floor.obstruct(near, "pallet")
    assert not floor.obstruct(near, "person")
    floor.clear(near)
    assert not floor.obstacles.shapes
    assert atv in floor.vehicles


def test_every_thing_of_a_fault_has_a_size() -> None:
    assert set(Thing) == set(SIZES_M)


def pass_time(clock: VirtualClock, for_s: float) -> None:
    until_s = clock.now_s() + for_s
    while clock.heap and clock.heap[0][0] <= until_s:
        when_s, _, call, args = heappop(clock.heap)
        clock.time_s = max(clock.time_s, when_s)
        call(*args)
    clock.time_s = until_s


@pytest.mark.parametrize("right", ["repair", "recover_load"])
def test_a_lost_load_lies_behind_its_vehicle_until_a_person_takes_it_up(right: str) -> None:
    clock = VirtualClock()
    floor = Floor(PLANT, clock, seed=1)
    carrier = floor.vehicles["ATV1"]
    floor.storages["S1"].instruct(OpenDock(vehicle="ATV1", item="shaft", quantity=20))
    carrier.instruct(PICK)
    pass_time(clock, 60.0)
    assert carrier.sense().load == "shaft"
    assert not floor.drop_load("ATV1"), "it is on no lane"
    carrier.instruct(drive("west", "middle", "east"))
    pass_time(clock, 5.0)
    assert floor.drop_load("ATV1")
    pass_time(clock, 30.0)
    assert (carrier.problem, carrier.sense().speed_mps) == (LOAD_DROPPED, 0.0)
    shape, pose = floor.obstacles.shapes["west", "middle"], carrier.sense().pose
    covers = Rectangle(pose.x_m, pose.y_m, pose.heading_rad, LIGHT.length_m, LIGHT.width_m)
    assert gap_m(shape, covers) >= FALLS_M - 1e-9
    assert shape.x_m < pose.x_m, "it is behind"
    assert floor.obstacles.room_m("west", "middle", LIGHT) is not None
    assert not floor.drop_load("ATV1"), "it is lost already"
    getattr(carrier, right)()
    carrier.repair()
    pass_time(clock, TAKEN_UP_WITHIN_S)
    assert not floor.obstacles.shapes
    pass_time(clock, 60.0)
    assert carrier.sense().node == "east"


def test_a_load_is_not_lost_onto_another_vehicle() -> None:
    clock = VirtualClock()
    floor = Floor(PLANT, clock, seed=1)
    carrier = floor.vehicles["ATV1"]
    floor.storages["S1"].instruct(OpenDock(vehicle="ATV1", item="shaft", quantity=20))
    carrier.instruct(PICK)
    pass_time(clock, 60.0)
    floor.lift("ATV2")
    floor.put_down("ATV2", "west")
    carrier.instruct(drive("west", "middle", "east"))
    pass_time(clock, 1.5)
    assert not floor.drop_load("ATV1")
    assert not floor.obstacles.shapes
    assert carrier.problem == ""
