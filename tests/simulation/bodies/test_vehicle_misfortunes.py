"""What befalls a vehicle's body: no power, a load that slips, no WLAN, and the hands of people.

The vehicle and the yard are those of `test_vehicle.py`: 1 m/s, 0.5 m/s2, lanes of 10 m.
"""

from __future__ import annotations

import pytest
from yard import PLANT, Yard, drive

from dray.body import (
    ActionDone,
    ActionFailed,
    Charge,
    Drop,
    Hold,
    LimitSpeed,
    LinkNoticed,
    NodePassed,
    OpenDock,
    Pick,
    ProblemCleared,
    ProblemRaised,
    ReleaseWay,
    Unhold,
    WayDone,
)
from dray.messages import Link
from dray_sim.bodies.gate import NOT_ADMITTED, Gate
from dray_sim.bodies.stores import DeliveryWarehouse
from dray_sim.bodies.vehicle.condition import LOAD_SHIFTED, SHIFTED
from dray_sim.bodies.vehicle.odometer import Activity
from dray_sim.bodies.vehicle.vehicle import MOVED_BY_HAND, SimVehicle

HOLD, UNHOLD = Hold(), Unhold()
PICK = Pick(order=5, station="S1", item="shaft", quantity=20)
DROP = Drop(order=6, station="M1")


def place(vehicle: SimVehicle) -> tuple[float, float]:
    pose = vehicle.sense().pose
    return round(pose.x_m, 6), round(pose.y_m, 6)


def loaded_at_dock(yard: Yard, vehicle: SimVehicle) -> None:
    """Bring twenty shafts to the open dock of M1."""
    yard.do(vehicle, PICK, for_s=10.0)
    yard.do(vehicle, drive("west", "middle", "east", "north"), for_s=100.0)
    yard.do(yard.workcell, OpenDock(vehicle="ATV1", item="shaft", quantity=20))


# --- no power ---


def test_a_vehicle_without_power_stands_in_that_moment_and_says_nothing(
    yard: Yard, vehicle: SimVehicle
) -> None:
    yard.do(vehicle, drive("west", "middle", "east"), for_s=6.0)
    vehicle.power_off()
    assert yard.do(vehicle, for_s=1000.0) == []
    assert place(vehicle) == (5.0, 0.0)
    assert (vehicle.sense().speed_mps, vehicle.off) == (0.0, True)


def test_a_vehicle_without_power_spends_none(yard: Yard, vehicle: SimVehicle) -> None:
    yard.run(100.0)
    vehicle.power_off()
    yard.run(1e6)
    assert vehicle.sense().battery_frac == pytest.approx(0.89)
    assert vehicle.odometer().seconds[Activity.OFF] == pytest.approx(1e6 - 100.0)


def test_a_vehicle_without_power_hears_nothing(yard: Yard, vehicle: SimVehicle) -> None:
    vehicle.power_off()
    assert yard.do(vehicle, drive("west", "middle"), HOLD, PICK, for_s=100.0) == []
    vehicle.power_on()
    assert yard.do(vehicle, for_s=100.0) == []
    assert (place(vehicle), vehicle.sense().held, vehicle.sense().load) == ((0.0, 0.0), False, "")


def test_a_vehicle_that_has_power_again_stays_where_it_is(yard: Yard, vehicle: SimVehicle) -> None:
    yard.do(vehicle, drive("west", "middle", "east", released=2), for_s=6.0)
    vehicle.power_off()
    yard.run(50.0)
    vehicle.power_on()
    late = (ReleaseWay(order=1, released=3), HOLD, UNHOLD, LimitSpeed(speed_frac=1.0))
    assert yard.do(vehicle, *late, for_s=100.0) == []
    assert place(vehicle) == (5.0, 0.0)


def test_a_vehicle_that_has_power_again_goes_on_from_the_end_of_its_lane(
    yard: Yard, vehicle: SimVehicle
) -> None:
    yard.do(vehicle, drive("west", "middle", "east"), for_s=6.0)
    vehicle.power_off()
    vehicle.power_on()
    assert (vehicle.sense().node, vehicle.sense().next_node) == ("west", "middle")
    # The 5 m that are left of the lane from standstill to standstill: 2 s, 2 s and 3 m at full speed.
    said = yard.do(vehicle, drive("middle", order=2), for_s=7.0)
    assert said[-1] == WayDone(order=2, node="middle")
    assert yard.said[-1][0] == pytest.approx(6.0 + 7.0)


def test_a_vehicle_that_lost_power_at_a_node_begins_there(yard: Yard, vehicle: SimVehicle) -> None:
    yard.do(vehicle, drive("west", "middle", "east", released=2), for_s=20.0)
    vehicle.power_off()
    vehicle.power_on()
    assert vehicle.sense().next_node == "middle"
    said = yard.do(vehicle, drive("middle", "west", order=2), for_s=20.0)
    assert said[-1] == WayDone(order=2, node="west")


def test_a_hold_holds_without_power_and_after(yard: Yard, vehicle: SimVehicle) -> None:
    yard.do(vehicle, HOLD)
    vehicle.power_off()
    vehicle.power_on()
    assert vehicle.sense().held
    yard.do(vehicle, drive("west", "middle", order=2), for_s=100.0)
    assert place(vehicle) == (0.0, 0.0)
    assert yard.do(vehicle, UNHOLD, for_s=100.0)[-1] == WayDone(order=2, node="middle")


def test_a_speed_limit_outlives_a_loss_of_power(yard: Yard, vehicle: SimVehicle) -> None:
    yard.do(vehicle, LimitSpeed(speed_frac=0.5))
    vehicle.power_off()
    vehicle.power_on()
    yard.do(vehicle, drive("west", "middle", order=2), for_s=5.0)
    assert vehicle.sense().speed_mps == pytest.approx(0.5)


def test_a_manoeuvre_that_loses_power_has_no_effect(yard: Yard, vehicle: SimVehicle) -> None:
    yard.do(vehicle, PICK, for_s=9.0)
    vehicle.power_off()
    vehicle.power_on()
    assert yard.do(vehicle, for_s=100.0) == []
    assert (vehicle.sense().load, yard.storage.stock["shaft"]) == ("", 60)
    assert yard.do(vehicle, PICK, for_s=10.0) == [ActionDone(order=5)]


def test_a_load_stays_on_board_without_power(yard: Yard, vehicle: SimVehicle) -> None:
    loaded_at_dock(yard, vehicle)
    yard.do(vehicle, DROP, for_s=19.0)
    vehicle.power_off()
    yard.run(1000.0)
    assert (vehicle.sense().load, vehicle.sense().load_quantity) == ("shaft", 20)
    assert yard.workcell.sense().stock["shaft"] == 0


def test_a_charge_ends_with_the_power_and_the_plug_stays_in(yard: Yard) -> None:
    vehicle = yard.vehicle("east", battery_frac=0.5)
    charge = Charge(order=5, charger="CH1")
    yard.do(vehicle, charge, for_s=6.0)
    vehicle.power_off()
    yard.run(1000.0)
    assert vehicle.sense().battery_frac == pytest.approx(0.51)
    assert yard.chargers.occupant("CH1") == "ATV1"
    vehicle.power_on()
    assert not vehicle.sense().charging
    yard.do(vehicle, charge, for_s=6.0)
    assert vehicle.sense().battery_frac == pytest.approx(0.52)


def test_what_was_not_heard_before_the_power_was_lost_is_never_heard(yard: Yard, vehicle: SimVehicle) -> None:
    vehicle.instruct(drive("west", "middle"))
    vehicle.power_off()
    vehicle.power_on()
    assert yard.do(vehicle, for_s=100.0) == []


def test_what_breaks_without_power_is_sensed_with_it(yard: Yard, vehicle: SimVehicle) -> None:
    vehicle.power_off()
    vehicle.break_down("wheel")
    vehicle.power_on()
    assert yard.do(vehicle) == []
    assert vehicle.sense().problem == "wheel"
    vehicle.repair()
    assert yard.do(vehicle) == [ProblemCleared()]


def test_power_that_is_switched_twice_is_switched_once(yard: Yard, vehicle: SimVehicle) -> None:
    yard.do(vehicle, drive("west", "middle"), for_s=5.0)
    vehicle.power_on()
    assert yard.do(vehicle, for_s=20.0)[-1] == WayDone(order=1, node="middle")
    vehicle.power_off()
    yard.run(50.0)
    vehicle.power_off()
    vehicle.power_on()
    assert vehicle.odometer().seconds[Activity.OFF] == pytest.approx(25.0)


def test_a_battery_watch_begins_anew_with_the_power(yard: Yard) -> None:
    vehicle = yard.vehicle(battery_frac=0.001)
    yard.run(5.0)
    vehicle.power_off()
    yard.run(1000.0)
    vehicle.power_on()
    said = yard.do(vehicle, for_s=10.0)
    assert [type(report) for report in said] == [ProblemRaised]
    assert yard.said[-1][0] == pytest.approx(1005.0, abs=1e-3)


# --- no agent ---


def test_a_vehicle_whose_agent_is_gone_drives_as_far_as_was_released_and_stands(
    yard: Yard, vehicle: SimVehicle
) -> None:
    yard.do(vehicle, drive("west", "middle", "east", "north", released=3), for_s=5.0)
    vehicle.attach(lambda _report: None)
    yard.run(1000.0)
    assert (place(vehicle), vehicle.sense().speed_mps) == ((20.0, 0.0), 0.0)


def test_a_manoeuvre_is_finished_though_the_agent_is_gone(yard: Yard, vehicle: SimVehicle) -> None:
    yard.do(vehicle, PICK, for_s=5.0)
    vehicle.attach(lambda _report: None)
    yard.run(1000.0)
    assert vehicle.sense().load == "shaft"


# --- a load that slips ---


def test_a_load_that_slips_while_it_is_taken_on_holds_the_manoeuvre_up(
    yard: Yard, vehicle: SimVehicle
) -> None:
    yard.do(vehicle, PICK, for_s=4.0)
    assert vehicle.shift_load()
    assert yard.do(vehicle, for_s=100.0) == [ProblemRaised(reason=LOAD_SHIFTED, problem=SHIFTED)]
    assert (vehicle.sense().problem, vehicle.sense().load) == (LOAD_SHIFTED, "")
    vehicle.repair()
    assert yard.do(vehicle, for_s=5.9) == [ProblemCleared()]
    assert yard.do(vehicle, for_s=0.2) == [ActionDone(order=5)]


def test_a_load_that_slips_while_it_is_put_down_stays_on_board_until_the_repair(
    yard: Yard, vehicle: SimVehicle
) -> None:
    loaded_at_dock(yard, vehicle)
    yard.do(vehicle, DROP, for_s=5.0)
    vehicle.shift_load()
    yard.run(1000.0)
    assert vehicle.sense().load == "shaft"
    vehicle.repair()
    assert ActionDone(order=6) in yard.do(vehicle, for_s=15.0)
    assert yard.workcell.sense().stock["shaft"] == 20


def test_a_load_that_slips_on_the_way_stops_the_vehicle(yard: Yard, vehicle: SimVehicle) -> None:
    yard.do(vehicle, PICK, for_s=10.0)
    yard.do(vehicle, drive("west", "middle", "east"), for_s=6.0)
    vehicle.shift_load()
    yard.run(100.0)
    assert place(vehicle) == (6.0, 0.0)


def test_a_repaired_load_does_not_let_a_held_vehicle_go_on(yard: Yard, vehicle: SimVehicle) -> None:
    yard.do(vehicle, PICK, for_s=4.0)
    vehicle.shift_load()
    yard.do(vehicle, HOLD)
    vehicle.repair()
    yard.run(100.0)
    assert vehicle.sense().load == ""
    assert yard.do(vehicle, UNHOLD, for_s=6.0) == [ActionDone(order=5)]


def test_nothing_slips_where_no_load_is(yard: Yard, vehicle: SimVehicle) -> None:
    yard.do(vehicle, drive("west", "middle"), for_s=1.0)
    assert not vehicle.shift_load()
    assert yard.do(vehicle, for_s=100.0)[-1] == WayDone(order=1, node="middle")


# --- the WLAN ---


def test_a_change_of_the_link_is_told_once_and_sensed(yard: Yard, vehicle: SimVehicle) -> None:
    vehicle.notice_link(Link.WLAN)
    assert yard.do(vehicle) == []
    vehicle.notice_link(Link.MESH)
    vehicle.notice_link(Link.MESH)
    assert yard.do(vehicle) == [LinkNoticed(link=Link.MESH)]
    assert vehicle.sense().link is Link.MESH
    vehicle.notice_link(Link.WLAN)
    assert yard.do(vehicle) == [LinkNoticed(link=Link.WLAN)]


# --- the hands of people ---


def test_a_person_takes_the_load_off_a_dead_vehicle(yard: Yard, vehicle: SimVehicle) -> None:
    yard.do(vehicle, PICK, for_s=10.0)
    vehicle.power_off()
    assert vehicle.recover_load() == ("shaft", 20)
    assert vehicle.recover_load() == ("", 0)
    assert (vehicle.sense().load, vehicle.sense().load_quantity) == ("", 0)


def test_a_drop_whose_load_is_taken_off_by_hand_fails(yard: Yard, vehicle: SimVehicle) -> None:
    loaded_at_dock(yard, vehicle)
    yard.do(vehicle, DROP, for_s=5.0)
    assert vehicle.recover_load() == ("shaft", 20)
    said = yard.do(vehicle, for_s=100.0)
    assert [report for report in said if isinstance(report, ActionFailed)] == said
    assert yard.workcell.sense().stock["shaft"] == 0


def test_a_vehicle_is_carried_without_driving(yard: Yard, vehicle: SimVehicle) -> None:
    yard.do(vehicle, drive("west", "middle"), for_s=6.0)
    vehicle.power_off()
    vehicle.place_at("corner")
    assert place(vehicle) == (30.0, 10.0)
    vehicle.power_on()
    assert (vehicle.sense().node, vehicle.sense().next_node) == ("corner", "corner")
    assert yard.do(vehicle, Charge(order=7, charger="CH2"), for_s=1.0) == []
    assert vehicle.sense().charging
    assert vehicle.odometer().metres_m == pytest.approx(5.0)


def test_a_vehicle_that_is_carried_away_gives_up_its_way(yard: Yard, vehicle: SimVehicle) -> None:
    yard.do(vehicle, drive("west", "middle"), for_s=6.0)
    vehicle.place_at("west")
    assert yard.do(vehicle, for_s=100.0) == [ActionFailed(order=1, reason=MOVED_BY_HAND)]
    said = yard.do(vehicle, drive("west", "middle", order=2), for_s=100.0)
    assert [type(report) for report in said] == [NodePassed, NodePassed, WayDone]


def test_a_vehicle_that_is_carried_away_gives_up_its_manoeuvre(yard: Yard, vehicle: SimVehicle) -> None:
    yard.do(vehicle, PICK, for_s=4.0)
    vehicle.place_at("corner")
    assert yard.do(vehicle, for_s=100.0) == [ActionFailed(order=5, reason=MOVED_BY_HAND)]


def test_a_vehicle_that_is_carried_away_leaves_its_charger(yard: Yard) -> None:
    vehicle = yard.vehicle("east", battery_frac=0.5)
    yard.do(vehicle, Charge(order=5, charger="CH1"), for_s=6.0)
    vehicle.place_at("west")
    assert yard.chargers.occupant("CH1") == ""
    assert not vehicle.sense().charging


# --- goods at the gate ---


def test_goods_that_the_gate_refuses_stay_on_board_and_can_be_set_aside(yard: Yard) -> None:
    warehouse = DeliveryWarehouse("DELIVERY", PLANT.materials, Gate(yard.clock))
    yard.places["DELIVERY"] = warehouse
    vehicle = yard.vehicle("north")
    assert yard.workcell.put_by_hand("gear", 5) == ""
    yard.do(yard.workcell, OpenDock(vehicle="ATV1", item="gear", quantity=5))
    yard.do(vehicle, Pick(order=1, station="M1", item="gear", quantity=5), for_s=10.0)
    yard.do(vehicle, drive("north", "corner", order=2), for_s=20.0)
    said = yard.do(vehicle, Drop(order=3, station="DELIVERY", goal="G1"), for_s=20.0)
    assert said == [ActionFailed(order=3, reason=NOT_ADMITTED)]
    assert vehicle.sense().load == "gear"
    assert yard.do(vehicle, Drop(order=4, station="DELIVERY"), for_s=20.0) == [ActionDone(order=4)]
    assert warehouse.aside == {"gear": 5}
