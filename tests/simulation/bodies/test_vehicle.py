"""The simulated vehicle: what breaks down, what the odometer tells, and whatever its clock does."""

from __future__ import annotations

from dataclasses import replace

import pytest
from yard import HOLD, PICK, PLANT, TO_CORNER, UNHOLD, Yard, drive, passed, place

from dray.body import (
    LimitSpeed,
    ProblemCleared,
    ProblemRaised,
    ReleaseWay,
    WayDone,
)
from dray_sim.bodies.vehicle.condition import BATTERY_EMPTY, EMPTY
from dray_sim.bodies.vehicle.odometer import Activity
from dray_sim.bodies.vehicle.vehicle import SimVehicle


def test_a_breakdown_stops_the_vehicle_and_a_repair_lets_it_go_on(yard: Yard, vehicle: SimVehicle) -> None:
    yard.do(vehicle, drive("west", "middle", "east"), for_s=6.0)
    vehicle.break_down("load shifted")
    assert yard.do(vehicle, for_s=94.0) == [ProblemRaised(reason="load shifted")]
    assert place(vehicle) == (6.0, 0.0)
    assert vehicle.problem == "load shifted"
    vehicle.repair()
    vehicle.repair()
    said = yard.do(vehicle, for_s=100.0)
    assert said[0] == ProblemCleared()
    assert passed(yard)[-1] == (116.0, "east")


def test_a_repair_does_not_let_a_held_vehicle_go(yard: Yard, vehicle: SimVehicle) -> None:
    yard.do(vehicle, drive("west", "middle"), HOLD, for_s=1.0)
    vehicle.break_down("wheel")
    vehicle.repair()
    yard.run(100.0)
    assert place(vehicle) == (0.0, 0.0)


def test_an_unhold_does_not_let_a_broken_vehicle_go(yard: Yard, vehicle: SimVehicle) -> None:
    vehicle.break_down("wheel")
    yard.do(vehicle, HOLD, UNHOLD, drive("west", "middle"), for_s=100.0)
    assert place(vehicle) == (0.0, 0.0)


def test_a_repair_leaves_an_empty_battery_to_be_seen(yard: Yard) -> None:
    vehicle = yard.vehicle(battery_frac=0.001)
    vehicle.break_down("wheel")
    yard.run(60.0)
    vehicle.repair()
    assert yard.do(vehicle) == [ProblemRaised(reason=BATTERY_EMPTY, problem=EMPTY)]
    vehicle.replace_battery(0.5)
    assert yard.do(vehicle) == [ProblemCleared()]


# --- odometer ---------------------------------------------------------------------------------------


def test_the_odometer_tells_metres_and_seconds_apart(yard: Yard, vehicle: SimVehicle) -> None:
    yard.run(5.0)
    yard.do(vehicle, drive("west", "middle"), for_s=12.0)
    yard.do(vehicle, drive("middle", "west", order=2), for_s=12.0)
    yard.do(vehicle, PICK, for_s=10.0)
    yard.do(vehicle, drive("west", "middle", "east", order=3, released=2), for_s=15.0)
    yard.do(vehicle, HOLD, for_s=7.0)
    sums = vehicle.odometer()
    assert sums.empty_m == pytest.approx(20.0)
    assert sums.loaded_m == pytest.approx(10.0)
    assert {activity: seconds for activity, seconds in sums.seconds.items() if seconds} == {
        Activity.IDLE: pytest.approx(5.0),
        Activity.MOVING_EMPTY: pytest.approx(24.0),
        Activity.HANDLING: pytest.approx(10.0),
        Activity.MOVING_LOADED: pytest.approx(12.0),
        Activity.WAITING: pytest.approx(3.0),
        Activity.HELD: pytest.approx(7.0),
    }


def test_braking_counts_as_moving_until_the_vehicle_stands(yard: Yard, vehicle: SimVehicle) -> None:
    yard.do(vehicle, drive("west", "middle"), for_s=6.0)
    yard.do(vehicle, HOLD, for_s=10.0)
    sums = vehicle.odometer()
    assert sums.seconds[Activity.MOVING_EMPTY] == pytest.approx(8.0)
    assert sums.seconds[Activity.HELD] == pytest.approx(8.0)


def test_an_odometer_that_was_read_does_not_change(yard: Yard, vehicle: SimVehicle) -> None:
    yard.do(vehicle, drive("west", "middle"), for_s=6.0)
    read = vehicle.odometer()
    kept = replace(read, seconds=dict(read.seconds))
    yard.run(20.0)
    assert read == kept


def test_the_plant_of_these_tests_is_a_plant() -> None:
    assert PLANT.routes("light").way("west", "corner").nodes == TO_CORNER


@pytest.mark.parametrize("late_s", [0.01, 3.0, 15.0, 60.0])
def test_a_clock_that_calls_late_makes_it_later_and_nothing_else(
    yard: Yard, vehicle: SimVehicle, late_s: float
) -> None:
    yard.do(vehicle, drive(*TO_CORNER, released=3), for_s=10.0)
    (due_s, *_) = min(yard.clock.heap)
    yard.clock.time_s = due_s + late_s
    assert vehicle.sense().node == "west"
    vehicle.instruct(LimitSpeed(speed_frac=0.5))
    vehicle.instruct(ReleaseWay(order=1, released=5))
    assert vehicle.sense().next_node == "middle"
    yard.run(300.0)
    assert [node for _, node in passed(yard)] == list(TO_CORNER)
    assert [type(report) for _, _, report in yard.said].count(WayDone) == 1
    assert vehicle.odometer().metres_m == pytest.approx(40.0)
    assert place(vehicle) == (30.0, 10.0)
