"""What lies on a lane is in the way of bodies: they stop before it, say so, and go on when it is gone."""

from __future__ import annotations

import pytest
from yard import LIGHT, PLANT, Yard, drive, passed

from dray.body import WayBlocked, WayDone, WayFree
from dray.plant.floor.rectangles import Rectangle, gap_m
from dray_sim.bodies.floor import Floor
from dray_sim.bodies.obstacles import CLEAR_M, SIZES_M, STEP_M, Obstacles
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
