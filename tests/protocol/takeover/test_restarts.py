"""A vehicle that is started again goes on with what its earlier life has left."""

from __future__ import annotations

from defaults import PLANT
from effects import instructed, sent
from rigs import VehicleRig
from seals import granted
from spoken import award
from watches import BOUND_S, carrying, claims, newest, reborn

from dray.body import Drive, Pick
from dray.messages import (
    AtvStatus,
    CommandAnswered,
    CommandKind,
    Docked,
    DockOpened,
    Handover,
    Role,
    VehicleCommand,
)
from dray.protocol.liveness.suspicion import LATENESS_MAX_S


def test_a_vehicle_that_is_restarted_empty_goes_on_to_its_source() -> None:
    rig = reborn(carrying())
    assert rig.last(Drive).nodes[-1] == PLANT.node_of("S3")
    assert newest(rig).status is AtvStatus.WORKING


def test_a_vehicle_that_is_restarted_with_its_load_carries_it_on() -> None:
    rig = carrying()
    rig.arrive()
    rig.picked()
    again = reborn(rig)
    assert again.last(Drive).nodes[-1] == PLANT.node_of("M8")
    again.arrive()
    assert sent(again.all, Docked, to="M8") == [Docked(task="M8-1", epoch=1, station="M8")]


def test_a_vehicle_that_is_restarted_after_unloading_hands_over() -> None:
    rig = carrying()
    rig.arrive()
    rig.picked()
    rig.arrive()
    rig.on_message("M8", DockOpened(task="M8-1", epoch=1, station="M8"))
    rig.dropped()
    again = reborn(rig)
    assert len(sent(again.all, Handover, to="M8")) == 1


def test_a_vehicle_whose_load_was_taken_off_meanwhile_fetches_another_one() -> None:
    rig = carrying()
    rig.arrive()
    rig.picked()
    rig.load = ("", 0)
    again = reborn(rig)
    assert len(instructed(again.all, Pick)) == 1, "it stands at the storage"


def test_a_stopped_vehicle_is_stopped_after_a_restart() -> None:
    rig = carrying()
    rig.on_message("operator", granted("ATV1", VehicleCommand(command="C1", kind=CommandKind.STOP)))
    rig.on_message("operator", granted("ATV1", VehicleCommand(command="C2", kind=CommandKind.ACKNOWLEDGE)))
    rig.held = True
    again = reborn(rig)
    assert newest(again).status is AtvStatus.STOPPED
    resume = VehicleCommand(command="C3", kind=CommandKind.RESUME)
    [answer] = sent(again.on_message("operator", granted("ATV1", resume)), CommandAnswered)
    assert answer.done, "it was acknowledged before"


def test_a_load_that_nobody_remembers_is_brought_back() -> None:
    rig = VehicleRig()
    rig.load = ("shaft", 40)
    rig.start()
    assert rig.last(Drive).nodes[-1] in {PLANT.node_of(each) for each in PLANT.storages_of("shaft")}
    rig.arrive()
    rig.dropped()
    assert newest(rig).status is AtvStatus.IDLE


def test_the_bound_of_a_vehicle_that_was_never_heard_allows_for_the_slowest_link() -> None:
    rig = VehicleRig()
    rig.start()
    rig.on_message("M8", award(role=Role.SECONDARY, primary="ATV2"))
    rig.run(LATENESS_MAX_S + BOUND_S - 0.1)
    assert claims(rig) == []
    rig.run(LATENESS_MAX_S + BOUND_S)
    assert len(claims(rig)) == 1
