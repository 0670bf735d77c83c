"""The simulated vehicle, instruction by instruction.

A vehicle of the yard does 1 m/s, speeds up and brakes with 0.5 m/s2: a lane of 10 m from standstill to
standstill takes 12 s, 2 s and 1 m of it speeding up and as much braking.
"""

from __future__ import annotations

from dataclasses import replace
from math import pi

import msgspec
import pytest
from yard import LIGHT, PLANT, TO_CORNER, Yard, drive

from dray.body import (
    ActionDone,
    ActionFailed,
    Charge,
    Drive,
    Drop,
    Hold,
    LimitSpeed,
    NodePassed,
    OpenDock,
    Pick,
    ProblemCleared,
    ProblemRaised,
    ReleaseWay,
    StartCycle,
    StockChanged,
    Unhold,
    WayDone,
)
from dray.messages import Pose
from dray_sim.bodies.condition import BATTERY_EMPTY
from dray_sim.bodies.docks import SHUT
from dray_sim.bodies.odometer import Activity
from dray_sim.bodies.stores import NO_ROOM, NOT_KEPT, TOO_LITTLE
from dray_sim.bodies.vehicle import SimVehicle

HOLD, UNHOLD = Hold(), Unhold()


@pytest.fixture
def yard() -> Yard:
    return Yard()


@pytest.fixture
def vehicle(yard: Yard) -> SimVehicle:
    return yard.vehicle()


def passed(yard: Yard) -> list[tuple[float, str]]:
    """When which node was passed, in hundredths of a second."""
    return [(round(at_s, 2), said.node) for at_s, _, said in yard.said if isinstance(said, NodePassed)]


def place(vehicle: SimVehicle) -> tuple[float, float]:
    pose = vehicle.sense().pose
    return round(pose.x_m, 6), round(pose.y_m, 6)


# --- ways ---


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


# --- released ways ---


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


# --- new ways ---


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


# --- hold, speed ---


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


# --- loading and unloading ---

PICK = Pick(order=5, station="S1", item="shaft", quantity=20)


def test_a_load_changes_hands_at_the_end_of_the_manoeuvre(yard: Yard, vehicle: SimVehicle) -> None:
    assert yard.do(vehicle, PICK, for_s=9.9) == []
    assert (vehicle.sense().load, yard.storage.stock["shaft"]) == ("", 60)
    assert yard.do(vehicle, for_s=0.2) == [ActionDone(order=5)]
    assert (vehicle.sense().load, vehicle.sense().load_quantity) == ("shaft", 20)
    assert yard.storage.stock["shaft"] == 40


def test_a_machine_is_supplied_through_its_dock(yard: Yard, vehicle: SimVehicle) -> None:
    yard.do(vehicle, PICK, for_s=10.0)
    yard.do(vehicle, drive(*TO_CORNER[:4]), for_s=100.0)
    yard.do(yard.workcell, OpenDock(vehicle="ATV1", item="shaft", quantity=20))
    said = yard.do(vehicle, Drop(order=6, station="M1"), for_s=20.0)
    assert ActionDone(order=6) in said
    assert StockChanged(item="shaft", change=20, seq=1, vehicle="ATV1") in said
    assert yard.workcell.sense().stock["shaft"] == 20
    assert (vehicle.sense().load, vehicle.sense().load_quantity) == ("", 0)


def test_a_drop_at_a_shut_dock_fails_and_the_load_stays_on_board(yard: Yard, vehicle: SimVehicle) -> None:
    yard.do(vehicle, PICK, for_s=10.0)
    yard.do(vehicle, drive(*TO_CORNER[:4]), for_s=100.0)
    assert yard.do(vehicle, Drop(order=6, station="M1"), for_s=20.0) == [ActionFailed(order=6, reason=SHUT)]
    assert vehicle.sense().load == "shaft"


def test_a_drop_without_room_fails_and_the_load_stays_on_board(yard: Yard, vehicle: SimVehicle) -> None:
    yard.do(vehicle, PICK, for_s=10.0)
    yard.storage.put("ATV2", "shaft", 10)
    said = yard.do(vehicle, Drop(order=6, station="S1"), for_s=20.0)
    assert said == [ActionFailed(order=6, reason=NO_ROOM)]
    assert vehicle.sense().load_quantity == 20


def test_a_pick_of_what_is_not_there_fails(yard: Yard, vehicle: SimVehicle) -> None:
    yard.storage.take("ATV2", "shaft", 50)
    assert yard.do(vehicle, PICK, for_s=10.0) == [ActionFailed(order=5, reason=TOO_LITTLE)]
    assert vehicle.sense().load == ""


def test_a_held_manoeuvre_pauses(yard: Yard, vehicle: SimVehicle) -> None:
    yard.do(vehicle, PICK, for_s=4.0)
    yard.do(vehicle, HOLD, for_s=100.0)
    assert vehicle.sense().load == ""
    yard.do(vehicle, UNHOLD, for_s=5.9)
    assert vehicle.sense().load == ""
    assert yard.do(vehicle, for_s=0.2) == [ActionDone(order=5)]


def test_a_new_way_ends_a_manoeuvre_without_effect(yard: Yard, vehicle: SimVehicle) -> None:
    yard.do(vehicle, PICK, for_s=4.0)
    said = yard.do(vehicle, drive("west", "middle", order=6), for_s=100.0)
    assert said[0] == ActionFailed(order=5, reason="a new way was given")
    assert said[-1] == WayDone(order=6, node="middle")
    assert vehicle.sense().load == ""


@pytest.mark.parametrize(
    ("action", "reason"),
    [
        (msgspec.structs.replace(PICK, station="M1"), "not at M1"),
        (msgspec.structs.replace(PICK, station="XX"), "no station XX"),
        (msgspec.structs.replace(PICK, station="CH1"), "no station CH1"),
        (msgspec.structs.replace(PICK, item="bolt"), "no item bolt"),
        (msgspec.structs.replace(PICK, item="block"), "cannot carry pallet"),
        (msgspec.structs.replace(PICK, quantity=21), "21 is not within a lot of 20"),
        (msgspec.structs.replace(PICK, quantity=0), "0 is not within a lot of 20"),
        (Drop(order=5, station="S1"), "nothing on board"),
        (Charge(order=5, charger="CH1"), "not at CH1"),
        (Charge(order=5, charger="S1"), "no charger S1"),
    ],
)
def test_an_action_that_cannot_be_done_fails_at_once(
    yard: Yard, vehicle: SimVehicle, action: Pick | Drop | Charge, reason: str
) -> None:
    assert yard.do(vehicle, action) == [ActionFailed(order=5, reason=reason)]


def test_what_a_place_does_not_keep_is_found_out_at_the_end_of_the_manoeuvre(
    yard: Yard, vehicle: SimVehicle
) -> None:
    said = yard.do(vehicle, Pick(order=5, station="S1", item="gear", quantity=1), for_s=10.0)
    assert said == [ActionFailed(order=5, reason=NOT_KEPT)]


def test_a_second_pick_fails_and_the_first_goes_on(yard: Yard, vehicle: SimVehicle) -> None:
    other = msgspec.structs.replace(PICK, order=6)
    said = yard.do(vehicle, PICK, other, for_s=10.0)
    assert said == [ActionFailed(order=6, reason="busy with another action"), ActionDone(order=5)]
    again = yard.do(vehicle, other)
    assert again == [ActionFailed(order=6, reason="shaft is on board")]


def test_an_action_on_the_way_fails(yard: Yard, vehicle: SimVehicle) -> None:
    said = yard.do(vehicle, drive("west", "middle", released=1), PICK)
    assert said[-1] == ActionFailed(order=5, reason="the way is not finished")


def test_what_only_a_workcell_can_do_is_ignored(yard: Yard, vehicle: SimVehicle) -> None:
    assert yard.do(vehicle, StartCycle(product="gear"), for_s=100.0) == []


# --- battery ---


def test_metres_and_seconds_empty_the_battery(yard: Yard, vehicle: SimVehicle) -> None:
    yard.do(vehicle, PICK, for_s=10.0)
    assert vehicle.sense().battery_frac == pytest.approx(0.9 - 10e-4)
    yard.do(vehicle, drive("west", "middle"), for_s=12.0)
    assert vehicle.sense().battery_frac == pytest.approx(0.9 - 22e-4 - 40e-4)


def test_a_vehicle_charges_until_it_is_full(yard: Yard) -> None:
    vehicle = yard.vehicle("east", battery_frac=0.5)
    yard.do(vehicle, Charge(order=5, charger="CH1"), for_s=60.0)
    assert vehicle.sense().charging
    assert vehicle.sense().battery_frac == pytest.approx(0.5 + 60.0 * 600.0 / 3600.0 / 100.0)
    said = yard.do(vehicle, for_s=1000.0)
    assert said == [ActionDone(order=5)]
    assert not vehicle.sense().charging
    assert vehicle.odometer().seconds[Activity.CHARGING] == pytest.approx(yard.said[-1][0])


def test_a_new_way_ends_charging_without_a_word(yard: Yard) -> None:
    vehicle = yard.vehicle("east", battery_frac=0.5)
    yard.do(vehicle, Charge(order=5, charger="CH1"), for_s=60.0)
    said = yard.do(vehicle, drive("east", "north", order=6), for_s=5.0)
    assert said == [NodePassed(order=6, node="east", index=0, battery_frac=pytest.approx(0.6))]
    assert not vehicle.sense().charging
    assert vehicle.sense().battery_frac < 0.6


def test_any_other_action_ends_charging(yard: Yard) -> None:
    vehicle = yard.vehicle("corner", battery_frac=0.5)
    yard.do(vehicle, Charge(order=5, charger="CH2"), for_s=60.0)
    said = yard.do(vehicle, Drop(order=6, station="DELIVERY"))
    assert said == [ActionFailed(order=6, reason="nothing on board")]
    assert not vehicle.sense().charging


def test_a_held_vehicle_does_not_charge(yard: Yard) -> None:
    vehicle = yard.vehicle("east", battery_frac=0.5)
    yard.do(vehicle, Charge(order=5, charger="CH1"), HOLD, for_s=100.0)
    assert not vehicle.sense().charging
    assert vehicle.sense().battery_frac == pytest.approx(0.49)
    yard.do(vehicle, UNHOLD, for_s=6.0)
    assert vehicle.sense().battery_frac == pytest.approx(0.5)


def test_an_occupied_charger_is_refused_until_its_vehicle_has_left(yard: Yard) -> None:
    first, second = yard.vehicle("east", id_="ATV1"), yard.vehicle("east", id_="ATV2")
    charge = Charge(order=5, charger="CH1")
    yard.do(first, charge)
    assert yard.do(second, charge) == [ActionFailed(order=5, reason="occupied by ATV1")]
    assert yard.chargers.occupant("CH1") == "ATV1"
    yard.do(first, for_s=2000.0)
    assert yard.do(second, charge) == [ActionFailed(order=5, reason="occupied by ATV1")]
    yard.do(first, drive("east", "north"))
    assert yard.chargers.occupant("CH1") == ""
    assert yard.do(second, charge) == []
    assert second.sense().charging


def test_a_full_vehicle_is_charged_at_once(yard: Yard) -> None:
    vehicle = yard.vehicle("east", battery_frac=1.0)
    assert yard.do(vehicle, Charge(order=5, charger="CH1")) == [ActionDone(order=5)]


def test_a_battery_that_ends_on_the_way_stops_the_vehicle_dead(yard: Yard) -> None:
    vehicle = yard.vehicle("west", battery_frac=0.004)
    said = yard.do(vehicle, drive("west", "middle", "east"), for_s=100.0)
    assert said[-1] == ProblemRaised(reason=BATTERY_EMPTY)
    # After the first two seconds and metre 4e-4 per second or metre: at 1 m/s from 5 m/10^4 on.
    assert yard.said[-1][0] == pytest.approx(2.0 + (0.004 - 5e-4) / 4e-4)
    assert place(vehicle) == (9.75, 0.0)
    assert vehicle.sense().battery_frac == 0.0
    assert vehicle.problem == BATTERY_EMPTY


def test_a_battery_that_ends_while_nothing_happens_is_reported_when_it_ends(yard: Yard) -> None:
    vehicle = yard.vehicle(battery_frac=0.5)
    yard.run(4999.0)
    assert yard.said == []
    yard.run(5001.0)
    assert yard.said == [(pytest.approx(5000.0, abs=1e-3), "ATV1", ProblemRaised(reason=BATTERY_EMPTY))]
    assert vehicle.sense().battery_frac == 0.0


def test_driving_about_leaves_only_a_handful_of_calls_open(yard: Yard, vehicle: SimVehicle) -> None:
    for order in range(1, 40, 2):
        yard.do(vehicle, drive("west", "middle", order=order), for_s=12.0)
        yard.do(vehicle, drive("middle", "west", order=order + 1), for_s=12.0)
    assert len(yard.clock.heap) <= 4


def test_another_battery_lets_an_empty_vehicle_go_on(yard: Yard) -> None:
    vehicle = yard.vehicle("west", battery_frac=0.004)
    yard.do(vehicle, drive("west", "middle", "east"), for_s=100.0)
    vehicle.replace_battery()
    said = yard.do(vehicle, for_s=100.0)
    assert said[0] == ProblemCleared()
    assert said[-1] == WayDone(order=1, node="east")


def test_an_empty_vehicle_at_a_charger_can_be_charged_and_drives_again(yard: Yard) -> None:
    vehicle = yard.vehicle("east", battery_frac=0.001)
    yard.run(60.0)
    assert yard.do(vehicle, Charge(order=5, charger="CH1"), for_s=60.0) == [ProblemCleared()]
    said = yard.do(vehicle, drive("east", "north", order=6), for_s=60.0)
    assert said[-1] == WayDone(order=6, node="north")


def test_an_empty_vehicle_without_idle_power_keeps_standing(yard: Yard) -> None:
    silent = msgspec.structs.replace(LIGHT, idle_w=0.0)
    vehicle = yard.vehicle(battery_frac=0.0015, type_=silent)
    yard.run(1e6)
    assert yard.said == []
    yard.do(vehicle, drive("west", "middle"), for_s=100.0)
    assert place(vehicle) == (5.0, 0.0)


# --- breakdowns ---


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
    assert yard.do(vehicle) == [ProblemRaised(reason=BATTERY_EMPTY)]
    vehicle.replace_battery(0.5)
    assert yard.do(vehicle) == [ProblemCleared()]


# --- odometer ---


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
