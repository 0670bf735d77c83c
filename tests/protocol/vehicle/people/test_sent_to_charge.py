"""A vehicle that a person sends to charge does its work first, charges until it is full, and takes none before."""

from __future__ import annotations

from unittest.mock import Mock

from atv1 import SETTLED_S, parked
from defaults import PLANT
from effects import instructed, sent
from rigs import VehicleRig
from seals import granted
from spoken import announcement
from watches import carrying, newest, reborn

from dray.body import Charge, Drive
from dray.messages import Bid, CommandAnswered, CommandKind, CommandRefusal, Resigned, VehicleCommand
from dray.protocol.vehicle.charging import Charging
from dray.protocol.vehicle.dwell_points import CONTEST_S

HALF_FULL = 0.7
"""No vehicle goes to charge by itself with that."""


def told(rig: VehicleRig, kind: CommandKind) -> CommandAnswered:
    command = VehicleCommand(command=f"C{len(rig.all)}", kind=kind, issued_by="Maria")
    [answer] = sent(rig.on_message("gateway", granted("ATV1", command)), CommandAnswered)
    return answer


def bids(rig: VehicleRig) -> int:
    return len(sent(rig.on_message("M8", announcement()), Bid))


def test_it_drives_to_a_charger_at_once_and_takes_no_work_until_it_is_full() -> None:
    rig = parked(node="p8", battery_frac=HALF_FULL)
    rig.run(SETTLED_S)
    assert instructed(rig.all, Drive) == []
    assert told(rig, CommandKind.CHARGE).done
    rig.run(SETTLED_S + 1.0 + CONTEST_S)
    assert rig.last(Drive).nodes[-1] in {charger.node for charger in PLANT.chargers.values()}
    rig.arrive()
    assert rig.last(Charge)
    assert (newest(rig).sent_to_charge, bids(rig)) == (True, 0)
    rig.battery_frac = 0.94
    rig.run(rig.now_s + 60.0)
    assert (newest(rig).sent_to_charge, bids(rig)) == (True, 0), "enough for work by itself is not full"
    rig.battery_frac = 0.95
    rig.run(rig.now_s + 60.0)
    assert (newest(rig).sent_to_charge, bids(rig)) == (False, 1)


def test_its_present_work_it_does_first() -> None:
    rig = carrying()
    rig.battery_frac = HALF_FULL
    rig.run(rig.now_s + 5.0)
    assert told(rig, CommandKind.CHARGE).done
    rig.run(rig.now_s + 5.0)
    assert (newest(rig).task is None, sent(rig.all, Resigned)) == (False, [])
    assert instructed(rig.all, Charge) == []


def test_a_person_takes_it_back_by_putting_it_into_service() -> None:
    rig = parked(node="p8", battery_frac=HALF_FULL)
    assert told(rig, CommandKind.CHARGE).done
    assert told(rig, CommandKind.PUT_IN).done
    assert (newest(rig).sent_to_charge, bids(rig)) == (False, 1)
    assert told(rig, CommandKind.PUT_IN).reason is CommandRefusal.IN_SERVICE


def test_its_next_life_goes_to_charge_too() -> None:
    rig = parked(node="p8", battery_frac=HALF_FULL)
    assert told(rig, CommandKind.CHARGE).done
    again = reborn(rig)
    again.battery_frac = HALF_FULL
    again.run(1.0)
    assert (newest(again).sent_to_charge, bids(again)) == (True, 0)


def test_a_full_vehicle_is_sent_nowhere() -> None:
    rig = parked(node="p8", battery_frac=0.93)
    assert told(rig, CommandKind.CHARGE).reason is CommandRefusal.CHARGED
    assert (newest(rig).sent_to_charge, bids(rig)) == (False, 1)


def test_where_there_is_no_charger_it_is_refused() -> None:
    plant = Mock(chargers={}, vehicle_types=PLANT.vehicle_types, wraps=PLANT)
    charging = Charging(plant, "light")
    charging.note(0.3, "p8")
    assert charging.send() is CommandRefusal.NOT_SUPPORTED
    assert not charging.is_sent
