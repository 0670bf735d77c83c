"""The simulated vehicle takes a load and puts it down."""

from __future__ import annotations

import msgspec
import pytest
from yard import HOLD, PICK, TO_CORNER, UNHOLD, Yard, drive

from dray.body import (
    ActionDone,
    ActionFailed,
    Charge,
    Drop,
    OpenDock,
    Pick,
    StartCycle,
    StockChanged,
    WayDone,
)
from dray_sim.bodies.docks import SHUT
from dray_sim.bodies.stores import NO_ROOM, NOT_KEPT, TOO_LITTLE
from dray_sim.bodies.vehicle.vehicle import SimVehicle


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


def test_what_a_station_does_not_keep_is_not_picked(yard: Yard, vehicle: SimVehicle) -> None:
    said = yard.do(vehicle, msgspec.structs.replace(PICK, item="bolt"), for_s=100.0)
    assert said == [ActionFailed(order=5, reason=NOT_KEPT)]


@pytest.mark.parametrize(
    ("action", "reason"),
    [
        (msgspec.structs.replace(PICK, station="M1"), "not at M1"),
        (msgspec.structs.replace(PICK, station="XX"), "no station XX"),
        (msgspec.structs.replace(PICK, station="CH1"), "no station CH1"),
        (msgspec.structs.replace(PICK, item="block"), "cannot carry pallet"),
        (msgspec.structs.replace(PICK, quantity=21), "21 is not within a lot of 20"),
        (msgspec.structs.replace(PICK, quantity=0), "0 is not within a lot of 20"),
        (msgspec.structs.replace(PICK, item="bolt", quantity=0), "nothing to pick"),
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
