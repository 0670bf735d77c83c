"""The simulated vehicle's battery: it empties, is charged, and ends."""

from __future__ import annotations

import msgspec
import pytest
from yard import HOLD, LIGHT, PICK, UNHOLD, Yard, drive, place

from dray.body import (
    ActionDone,
    ActionFailed,
    Charge,
    Drop,
    NodePassed,
    ProblemCleared,
    ProblemRaised,
    WayDone,
)
from dray_sim.bodies.vehicle.condition import BATTERY_EMPTY, EMPTY
from dray_sim.bodies.vehicle.odometer import Activity
from dray_sim.bodies.vehicle.vehicle import SimVehicle


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
    assert said[-1] == ProblemRaised(reason=BATTERY_EMPTY, problem=EMPTY)
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
    assert yard.said == [
        (pytest.approx(5000.0, abs=1e-3), "ATV1", ProblemRaised(reason=BATTERY_EMPTY, problem=EMPTY))
    ]
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
