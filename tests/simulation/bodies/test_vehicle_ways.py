"""The simulated vehicle on its way: nodes in their time, new ways, holds and speeds."""

from __future__ import annotations

from math import pi

import pytest
from msgspec.structs import replace
from yard import HOLD, PLANT, TO_CORNER, UNHOLD, Yard, drive, passed, place

from dray.body import (
    ActionFailed,
    Drive,
    LimitSpeed,
    NodePassed,
    ReleaseWay,
    WayDone,
)
from dray.messages import Pose
from dray.plant import Plant
from dray.plant.model import LaneType
from dray_sim.bodies.vehicle.vehicle import SimVehicle


def test_a_standing_vehicle_passes_the_first_node_at_once_and_every_other_in_its_time(
    yard: Yard, vehicle: SimVehicle
) -> None:
    yard.do(vehicle, drive("west", "middle", "east"), for_s=100.0)
    assert passed(yard) == [(0.0, "west"), (11.0, "middle"), (22.0, "east")]
    assert yard.said[-1] == (22.0, "ATV1", WayDone(order=1, node="east"))


def test_a_report_carries_order_index_and_battery(yard: Yard, vehicle: SimVehicle) -> None:
    said = yard.do(vehicle, drive("west", "middle", order=7), for_s=100.0)
    assert said == [
        NodePassed(order=7, node="west", index=0, battery_frac=0.9),
        NodePassed(order=7, node="middle", index=1, battery_frac=pytest.approx(0.9 - 12e-4 - 30e-4)),
        WayDone(order=7, node="middle"),
    ]


def test_a_vehicle_turns_sharp_bends_at_turn_speed(yard: Yard, vehicle: SimVehicle) -> None:
    yard.do(vehicle, drive(*TO_CORNER))
    speeds = {}
    while yard.clock.heap:
        yard.step()
        speeds[vehicle.sense().node] = vehicle.sense().speed_mps
    assert speeds["middle"] == pytest.approx(1.0)
    assert speeds["east"] == pytest.approx(0.5)
    assert speeds["north"] == pytest.approx(0.5)


def test_a_vehicle_keeps_to_the_limit_of_a_lane(yard: Yard) -> None:
    vehicle = yard.vehicle("middle")
    yard.do(vehicle, drive("middle", "pit"), for_s=5.0)
    assert vehicle.sense().speed_mps == 0.5


def test_a_vehicle_knows_its_pose_at_any_time(yard: Yard, vehicle: SimVehicle) -> None:
    yard.do(vehicle, drive(*TO_CORNER), for_s=6.0)
    assert vehicle.sense().pose == Pose(x_m=5.0, y_m=0.0, heading_rad=0.0)
    yard.run(30.0)
    pose = vehicle.sense().pose
    assert pose.x_m == 20.0
    assert 0.0 < pose.y_m < 10.0
    assert pose.heading_rad == pytest.approx(pi / 2)
    yard.run(100.0)
    assert vehicle.sense().pose == Pose(x_m=30.0, y_m=10.0, heading_rad=0.0)


def test_a_vehicle_knows_where_a_new_way_could_begin_and_when(yard: Yard, vehicle: SimVehicle) -> None:
    standing = vehicle.sense()
    assert (standing.node, standing.next_node, standing.next_node_s) == ("west", "west", 0.0)
    yard.do(vehicle, drive("west", "middle", "east"), for_s=6.0)
    moving = vehicle.sense()
    assert (moving.node, moving.next_node, moving.next_node_s) == ("west", "middle", 5.0)
    yard.do(vehicle, HOLD, for_s=10.0)
    held = vehicle.sense()
    assert (held.node, held.next_node, held.next_node_s) == ("west", "middle", pytest.approx(4.0))


def test_a_way_to_where_it_stands_is_done_at_once(yard: Yard, vehicle: SimVehicle) -> None:
    said = yard.do(vehicle, drive("west"))
    assert said == [
        NodePassed(order=1, node="west", index=0, battery_frac=0.9),
        WayDone(order=1, node="west"),
    ]


def test_nothing_is_said_inside_an_instruction(yard: Yard, vehicle: SimVehicle) -> None:
    vehicle.instruct(drive("west"))
    vehicle.instruct(drive("nowhere", order=2))
    assert yard.said == []
    yard.run(0.0)
    assert len(yard.said) == 3


# --- released ways ----------------------------------------------------------------------------------


def test_a_vehicle_brakes_at_the_last_released_node(yard: Yard, vehicle: SimVehicle) -> None:
    said = yard.do(vehicle, drive(*TO_CORNER, released=2), for_s=100.0)
    assert [report.node for report in said if isinstance(report, NodePassed)] == ["west", "middle"]
    assert not any(isinstance(report, WayDone) for report in said)
    assert place(vehicle) == (10.0, 0.0)
    assert vehicle.sense().next_node == "middle"


def test_a_vehicle_goes_on_when_more_is_released(yard: Yard, vehicle: SimVehicle) -> None:
    yard.do(vehicle, drive("west", "middle", "east", released=2), for_s=20.0)
    yard.do(vehicle, ReleaseWay(order=1, released=3), for_s=20.0)
    assert passed(yard) == [(0.0, "west"), (12.0, "middle"), (32.0, "east")]


def test_a_release_in_time_costs_no_braking(yard: Yard, vehicle: SimVehicle) -> None:
    yard.do(vehicle, drive("west", "middle", "east", released=1), for_s=0.0)
    yard.do(vehicle, ReleaseWay(order=1, released=2), for_s=9.9)
    yard.do(vehicle, ReleaseWay(order=1, released=3), for_s=20.0)
    assert passed(yard) == [(0.0, "west"), (11.0, "middle"), (22.0, "east")]


def test_a_release_goes_on_from_the_present_speed(yard: Yard, vehicle: SimVehicle) -> None:
    yard.do(vehicle, drive("west", "middle", "east", released=2), for_s=11.0)
    assert vehicle.sense().speed_mps == pytest.approx(0.5)
    yard.do(vehicle, ReleaseWay(order=1, released=3))
    assert vehicle.sense().speed_mps == pytest.approx(0.5)
    yard.run(100.0)
    assert yard.when(lambda said: isinstance(said, WayDone)) == [pytest.approx(22.5)]


def test_a_late_or_doubled_release_takes_nothing_back(yard: Yard, vehicle: SimVehicle) -> None:
    release = ReleaseWay(order=1, released=2)
    yard.do(vehicle, drive("west", "middle", "east"), release, ReleaseWay(order=1, released=99), release)
    yard.run(100.0)
    assert passed(yard) == [(0.0, "west"), (11.0, "middle"), (22.0, "east")]


def test_a_release_of_another_way_is_late_and_changes_nothing(yard: Yard, vehicle: SimVehicle) -> None:
    yard.do(vehicle, drive("west", "middle", "east", order=2, released=2))
    said = yard.do(vehicle, ReleaseWay(order=1, released=3), for_s=100.0)
    assert [report.node for report in said if isinstance(report, NodePassed)] == ["middle"]
    assert place(vehicle) == (10.0, 0.0)


# --- new ways ---------------------------------------------------------------------------------------


def test_a_new_way_begins_after_the_lane_that_the_vehicle_is_on(yard: Yard, vehicle: SimVehicle) -> None:
    yard.do(vehicle, drive("west", "middle", "east"), for_s=6.0)
    said = yard.do(vehicle, drive("middle", "pit", order=2), for_s=100.0)
    assert said[0] == NodePassed(
        order=2, node="middle", index=0, battery_frac=pytest.approx(0.8958, abs=1e-3)
    )
    assert said[-1] == WayDone(order=2, node="pit")
    assert place(vehicle) == (10.0, -5.0)


def test_a_vehicle_that_is_sent_back_turns_at_the_next_node(yard: Yard, vehicle: SimVehicle) -> None:
    yard.do(vehicle, drive("west", "middle", "east"), for_s=6.0)
    yard.do(vehicle, drive("middle", "west", order=2), for_s=4.0)
    assert vehicle.sense().node == "west"
    yard.run(100.0)
    assert [node for _, node in passed(yard)] == ["west", "middle", "west"]
    assert vehicle.odometer().metres_m == pytest.approx(20.0)


def test_a_way_of_the_next_node_alone_stops_there(yard: Yard, vehicle: SimVehicle) -> None:
    yard.do(vehicle, drive("west", "middle", "east"), for_s=6.0)
    yard.do(vehicle, drive("middle", order=2), for_s=100.0)
    assert yard.said[-1] == (pytest.approx(12.0), "ATV1", WayDone(order=2, node="middle"))


def test_a_turn_that_comes_too_late_is_made_all_the_same(yard: Yard, vehicle: SimVehicle) -> None:
    yard.do(vehicle, drive("west", "middle", "east"), for_s=10.99)
    yard.do(vehicle, drive("middle", "pit", order=2), for_s=100.0)
    assert [node for _, node in passed(yard)] == ["west", "middle", "pit"]


def test_many_new_ways_on_one_lane_leave_the_vehicle_on_its_lane(yard: Yard, vehicle: SimVehicle) -> None:
    yard.do(vehicle, drive("west", "middle"), for_s=3.0)
    for order in range(2, 8):
        goal = ("east", "pit", "west")[order % 3]
        yard.do(vehicle, drive("middle", goal, order=order), for_s=1.0)
    assert place(vehicle) == (8.0, 0.0)


@pytest.mark.parametrize(
    ("way", "reason"),
    [
        (drive("middle", "east", order=2), "the way must begin at west"),
        (drive("west", "east", order=2), "no lane from west to east"),
        (drive("west", "nowhere", order=2), "no lane from west to nowhere"),
        (drive(order=2), "the way must begin at west"),
        (drive("west", "middle", order=2, released=0), "0 of 2 nodes released"),
        (drive("west", "middle", order=2, released=3), "3 of 2 nodes released"),
    ],
)
def test_a_wrong_way_fails_and_a_standing_vehicle_stays(
    yard: Yard, vehicle: SimVehicle, way: Drive, reason: str
) -> None:
    assert yard.do(vehicle, way, for_s=10.0) == [ActionFailed(order=2, reason=reason)]
    assert place(vehicle) == (0.0, 0.0)


def test_a_wrong_way_lets_a_moving_vehicle_stop_at_the_next_node(yard: Yard, vehicle: SimVehicle) -> None:
    yard.do(vehicle, drive("west", "middle", "east"), for_s=6.0)
    said = yard.do(vehicle, drive("east", "north", order=2), for_s=100.0)
    assert said[0] == ActionFailed(order=2, reason="the way must begin at middle")
    assert said[-1] == WayDone(order=1, node="middle")
    assert place(vehicle) == (10.0, 0.0)


def test_a_wrong_way_ends_a_way_that_waits_for_its_release(yard: Yard, vehicle: SimVehicle) -> None:
    yard.do(vehicle, drive("west", "middle", "east", released=2), for_s=20.0)
    yard.do(vehicle, drive("west", "middle", order=2))
    yard.do(vehicle, ReleaseWay(order=1, released=3), for_s=20.0)
    assert place(vehicle) == (10.0, 0.0)
    yard.do(vehicle, drive("middle", "east", order=3), for_s=20.0)
    assert place(vehicle) == (20.0, 0.0)


# --- hold, speed ------------------------------------------------------------------------------------


def test_a_held_vehicle_brakes_at_once_and_stays(yard: Yard, vehicle: SimVehicle) -> None:
    yard.do(vehicle, drive("west", "middle", "east"), for_s=6.0)
    yard.do(vehicle, HOLD, HOLD, for_s=1.0)
    assert vehicle.sense().speed_mps == pytest.approx(0.5)
    yard.run(1000.0)
    assert place(vehicle) == (6.0, 0.0)
    assert vehicle.sense().held


def test_a_vehicle_goes_on_from_the_middle_of_a_lane(yard: Yard, vehicle: SimVehicle) -> None:
    yard.do(vehicle, drive("west", "middle", "east"), for_s=6.0)
    yard.do(vehicle, HOLD, for_s=94.0)
    yard.do(vehicle, UNHOLD, UNHOLD, for_s=100.0)
    assert passed(yard) == [(0.0, "west"), (105.0, "middle"), (116.0, "east")]


def test_a_node_that_is_passed_while_braking_is_reported(yard: Yard, vehicle: SimVehicle) -> None:
    yard.do(vehicle, drive("west", "middle", "east"), for_s=10.5)
    yard.do(vehicle, HOLD, for_s=100.0)
    assert [node for _, node in passed(yard)] == ["west", "middle"]
    assert place(vehicle) == (10.5, 0.0)
    assert vehicle.sense().next_node == "east"


def test_a_hold_while_braking_at_the_end_of_a_way_does_not_lose_the_end(
    yard: Yard, vehicle: SimVehicle
) -> None:
    yard.do(vehicle, drive("west", "middle"), for_s=11.0)
    yard.do(vehicle, HOLD, for_s=100.0)
    assert yard.said[-1][2] == WayDone(order=1, node="middle")


def test_a_held_vehicle_takes_a_new_way_and_drives_it_when_let_go(yard: Yard, vehicle: SimVehicle) -> None:
    yard.do(vehicle, HOLD, drive("west", "middle"), for_s=50.0)
    assert place(vehicle) == (0.0, 0.0)
    yard.do(vehicle, UNHOLD, for_s=50.0)
    assert passed(yard) == [(0.0, "west"), (62.0, "middle")]


def test_a_new_way_for_a_vehicle_that_is_held_on_a_lane_begins_at_its_end(
    yard: Yard, vehicle: SimVehicle
) -> None:
    yard.do(vehicle, drive("west", "middle", "east"), for_s=6.0)
    yard.do(vehicle, HOLD, for_s=10.0)
    yard.do(vehicle, drive("middle", "pit", order=2), for_s=10.0)
    assert place(vehicle) == (6.0, 0.0)
    yard.do(vehicle, UNHOLD, for_s=100.0)
    assert place(vehicle) == (10.0, -5.0)


def test_a_lower_speed_limit_is_braked_down_to_and_lifted_again(yard: Yard, vehicle: SimVehicle) -> None:
    yard.do(vehicle, drive("west", "middle", "east"), for_s=6.0)
    yard.do(vehicle, LimitSpeed(speed_frac=0.2), for_s=0.8)
    assert vehicle.sense().speed_mps == pytest.approx(0.6)
    yard.run(20.0)
    assert vehicle.sense().speed_mps == pytest.approx(0.2)
    yard.do(vehicle, LimitSpeed(speed_frac=1.0), for_s=1.0)
    assert vehicle.sense().speed_mps == pytest.approx(0.7)


@pytest.mark.parametrize(("asked", "speed_mps"), [(0.0, 0.01), (-1.0, 0.01), (5.0, 1.0)])
def test_a_speed_limit_is_clamped(yard: Yard, vehicle: SimVehicle, asked: float, speed_mps: float) -> None:
    yard.do(vehicle, LimitSpeed(speed_frac=asked), drive("west", "middle"), for_s=5.0)
    assert vehicle.sense().speed_mps == pytest.approx(speed_mps)


def test_a_vehicle_keeps_to_the_limit_of_its_type_and_refuses_a_lane_that_is_not_for_it() -> None:
    own = {("west", "middle"): (LaneType("light", 0.3),), ("middle", "pit"): (LaneType("other"),)}
    lanes = tuple(replace(lane, types=own.get((lane.start, lane.end), ())) for lane in PLANT.file.lanes)
    yard = Yard(Plant(replace(PLANT.file, lanes=lanes)))
    vehicle = yard.vehicle()
    yard.do(vehicle, drive("west", "middle", "pit"))
    assert isinstance(yard.said[-1][2], ActionFailed)
    assert yard.said[-1][2].reason == "no lane from middle to pit"
    yard.do(vehicle, drive("west", "middle", order=2), for_s=10.0)
    assert vehicle.sense().speed_mps == pytest.approx(0.3)
