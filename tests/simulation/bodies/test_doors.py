"""Doors on lanes: vehicles wait before them exactly as long as they open, and no door shuts on anybody."""

from __future__ import annotations

from itertools import pairwise
from random import Random

import pytest
from msgspec.structs import replace
from yard import HOLD, LIGHT, PLANT, UNHOLD, Yard, drive, passed

from dray.body import WayBlocked, WayDone, WayFree
from dray.plant import Door, LaneEnds, Plant, Routes
from dray.plant.floor.rectangles import Rectangle, gap_m
from dray_sim.bodies.doors import Doors, DoorState
from dray_sim.bodies.obstacles import Obstacles
from dray_sim.bodies.vehicle.odometer import Activity
from dray_sim.bodies.vehicle.vehicle import SimVehicle

OPENING_S, CLOSES_S = 8.0, 5.0

GATE = Door("GATE", "Gate", (LaneEnds("middle", "east"),), OPENING_S, CLOSES_S)

WITH_DOOR = Plant(replace(PLANT.file, doors=(GATE,)))


class DoorYard(Yard):
    """The yard with a door between middle and east."""

    def __init__(self) -> None:
        super().__init__(WITH_DOOR)
        self.vehicles: dict[str, SimVehicle] = {}
        self.doors = Doors(WITH_DOOR, self.clock, self.vehicles)
        self.obstacles = Obstacles(WITH_DOOR, self.doors)

    def add(self, name: str, node: str) -> SimVehicle:
        vehicle = self.vehicles[name] = self.vehicle(node, id_=name)
        return vehicle

    def state(self) -> DoorState:
        return self.doors.states["GATE"]

    def until(self, state: DoorState) -> float:
        """Run until the door is so; when that is."""
        while self.state() is not state:
            self.step()
        return self.clock.now_s()


@pytest.fixture
def yard() -> DoorYard:
    return DoorYard()


def test_a_vehicle_waits_before_the_door_exactly_as_long_as_that_opens(yard: DoorYard) -> None:
    vehicle = yard.add("ATV1", "west")
    vehicle.instruct(drive("west", "middle", "east"))
    assert yard.state() is DoorState.SHUT
    came_s = yard.until(DoorState.OPENING)
    assert vehicle.sense().node == "middle"
    assert vehicle.sense().speed_mps == 0.0
    assert yard.until(DoorState.OPEN) == pytest.approx(came_s + OPENING_S)
    yard.run(came_s + 100.0)
    arrived_s = yard.when(lambda report: report == WayDone(order=1, node="east"))[0]
    way = WITH_DOOR.routes("light").way("west", "east")
    assert way.nodes == ("west", "middle", "east")
    assert arrived_s == pytest.approx(way.duration_s), "the promise is what the drive takes"
    assert vehicle.odometer().seconds[Activity.WAITING] == pytest.approx(OPENING_S)
    assert not any(isinstance(report, WayBlocked | WayFree) for _, _, report in yard.said)


def test_it_shuts_behind_the_last_vehicle_and_not_before(yard: DoorYard) -> None:
    first, second = yard.add("ATV1", "west"), yard.add("ATV2", "north")
    first.instruct(drive("west", "middle", "east"))
    second.instruct(drive("north", "east", "middle", "pit"))
    yard.until(DoorState.OPEN)
    yard.until(DoorState.SHUT)
    shut_s = yard.clock.now_s()
    left_s = max(at_s for at_s, node in passed(yard) if node in ("middle", "east"))
    assert shut_s == pytest.approx(left_s + CLOSES_S)


def test_who_follows_closely_does_not_wait(yard: DoorYard) -> None:
    first, second = yard.add("ATV1", "middle"), yard.add("ATV2", "west")
    second.instruct(drive("west", "middle", "east"))
    first.instruct(drive("middle", "east", "north"))
    yard.run(100.0)
    assert second.sense().node == "east"
    assert second.odometer().seconds[Activity.WAITING] == 0.0


def test_it_stays_open_over_a_vehicle_that_stands_in_it(yard: DoorYard) -> None:
    vehicle = yard.add("ATV1", "middle")
    vehicle.instruct(drive("middle", "east"))
    yard.run(yard.until(DoorState.OPEN) + 5.0)
    vehicle.instruct(HOLD)
    yard.run(600.0)
    assert yard.state() is DoorState.OPEN
    vehicle.instruct(UNHOLD)
    yard.run(700.0)
    assert vehicle.sense().node == "east"
    assert yard.state() is DoorState.SHUT


def test_it_does_not_open_for_a_vehicle_that_is_held_and_does_once_it_may_go_on(yard: DoorYard) -> None:
    vehicle = yard.add("ATV1", "middle")
    yard.do(vehicle, HOLD, drive("middle", "east"), for_s=30.0)
    assert yard.state() is DoorState.SHUT
    yard.do(vehicle, UNHOLD, for_s=1.0)
    assert yard.state() is DoorState.OPENING
    yard.run(100.0)
    assert vehicle.sense().node == "east"


def test_it_shuts_again_when_whoever_asked_has_turned_off(yard: DoorYard) -> None:
    vehicle = yard.add("ATV1", "middle")
    yard.do(vehicle, drive("middle", "east"), for_s=1.0)
    yard.do(vehicle, drive("middle", "pit", order=2), for_s=100.0)
    assert vehicle.sense().node == "pit"
    assert yard.state() is DoorState.SHUT


def test_a_door_that_fails_is_in_the_way_once_it_should_be_open_until_it_is_put_right(yard: DoorYard) -> None:
    vehicle = yard.add("ATV1", "middle")
    yard.doors.fail("GATE")
    yard.do(vehicle, drive("middle", "east"), for_s=OPENING_S - 0.1)
    assert yard.said[-1][2] != WayBlocked(order=1, start="middle", end="east", entered=False)
    yard.run(OPENING_S + 60.0)
    told = [report for _, _, report in yard.said if isinstance(report, WayBlocked)]
    assert told == [WayBlocked(order=1, start="middle", end="east", entered=False)]
    assert yard.state() is DoorState.FAILED
    yard.doors.repair("GATE")
    assert yard.state() is DoorState.OPENING
    yard.run(yard.clock.now_s() + 60.0)
    assert WayFree(order=1, start="middle", end="east") in [report for _, _, report in yard.said]
    assert vehicle.sense().node == "east"


def test_a_door_that_fails_while_it_opens_does_not_open(yard: DoorYard) -> None:
    vehicle = yard.add("ATV1", "middle")
    yard.do(vehicle, drive("middle", "east"), for_s=OPENING_S / 2.0)
    yard.doors.fail("GATE")
    yard.run(100.0)
    assert yard.state() is DoorState.FAILED
    assert vehicle.sense().node == "middle"


def test_a_door_that_fails_while_it_is_open_lets_whoever_is_in_it_through(yard: DoorYard) -> None:
    vehicle = yard.add("ATV1", "middle")
    vehicle.instruct(drive("middle", "east"))
    yard.run(yard.until(DoorState.OPEN) + 1.0)
    yard.doors.fail("GATE")
    yard.run(100.0)
    assert vehicle.sense().node == "east"
    assert yard.state() is DoorState.SHUT
    yard.do(vehicle, drive("east", "middle", order=2), for_s=100.0)
    assert yard.state() is DoorState.FAILED
    assert vehicle.sense().node == "east"


@pytest.mark.parametrize("seed", range(20))
def test_no_shut_door_ever_covers_a_vehicle(seed: int) -> None:
    random = Random(f"{seed} doors")
    yard = DoorYard()
    for name, node in (("ATV1", "west"), ("ATV2", "north")):
        yard.add(name, node)
    order = shut = 0
    while yard.clock.now_s() < 600.0:
        yard.run(yard.clock.now_s() + random.uniform(0.1, 6.0))
        for vehicle in yard.vehicles.values():
            order += 1
            start = vehicle.sense().next_node
            goal = random.choice([node for node in WITH_DOOR.nodes if node != start])
            chance = random.random()
            if chance < 0.1:
                vehicle.instruct(HOLD)
            elif chance < 0.3:
                vehicle.instruct(UNHOLD)
            elif chance < 0.6:
                vehicle.instruct(drive(*WITH_DOOR.routes("light").way(start, goal).nodes, order=order))
            state = vehicle.sense()
            pose = state.pose
            covers = Rectangle(pose.x_m, pose.y_m, pose.heading_rad, LIGHT.length_m, LIGHT.width_m)
            leaves = [leaf for lane, leaf in yard.doors.leaves.items() if yard.doors.is_shut(lane)]
            shut += len(leaves)
            for leaf in leaves:
                assert gap_m(covers, leaf) > 0.0
        if random.random() < 0.05:
            yard.doors.fail("GATE")
        elif random.random() < 0.2:
            yard.doors.repair("GATE")
    assert shut
    through = sum({"middle", "east"} == set(ends) for ends in pairwise(node for _, node in passed(yard)))
    assert through


def test_a_way_round_a_door_is_taken_where_it_is_quicker() -> None:
    lane = replace(PLANT.file.lanes[0], start="pit", end="east", speed_limit_mps=0.5)
    file = replace(PLANT.file, lanes=(*PLANT.file.lanes, lane))
    round_s = Plant(file).routes("light").duration_s("pit", "east")
    quick = replace(GATE, opening_s=1.0)
    slow = replace(GATE, opening_s=60.0)

    def ways(door: Door) -> Routes:
        return Plant(replace(file, doors=(door,))).routes("light")

    assert ways(quick).way("middle", "east").nodes == ("middle", "east")
    assert ways(slow).way("middle", "east").nodes == ("middle", "pit", "east")
    assert ways(slow).duration_s("middle", "east") < round_s + 60.0
