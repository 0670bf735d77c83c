"""When links fail: a vehicle on the radio mesh, and a load for a machine that is silent."""

from __future__ import annotations

from defaults import PLANT
from effects import instructed, sent
from msgspec import UNSET
from rigs import VehicleRig
from spoken import award
from watches import GOODS, carrying, guard, newest

from dray.body import Drive, Drop, LinkNoticed
from dray.messages import (
    Accepted,
    AtvStatus,
    Declined,
    Docked,
    DockOpened,
    Handover,
    Link,
    LostWlan,
    Resigned,
    Role,
)
from dray.protocol.runtime.retransmission import ASK_AGAIN_S
from dray.protocol.vehicle.job.job_messages import GIVE_UP_AFTER


def test_a_vehicle_on_the_mesh_keeps_its_task_and_takes_nothing_else() -> None:
    rig = carrying()
    rig.on_message("M9", award(task="M9-1", role=Role.SECONDARY, primary="ATV2"))
    rig.report(LinkNoticed(link=Link.MESH))
    assert newest(rig).link is Link.MESH
    assert newest(rig).task is not None
    declined = sent(rig.on_message("M9", award(task="M9-2", role=Role.SECONDARY, primary="ATV2")), Declined)
    assert len(declined) == 1


def test_a_heartbeat_tells_since_when_there_is_no_wlan_and_by_which_access_point_there_was() -> None:
    rig = carrying()
    assert newest(rig).lost_wlan is UNSET
    rig.report(LinkNoticed(link=Link.MESH, access_point="AP3"))
    lost = LostWlan(since_s=rig.now_s, access_point="AP3")
    assert newest(rig).lost_wlan == lost
    rig.run(rig.now_s + 30.0)
    assert newest(rig).lost_wlan == lost
    rig.report(LinkNoticed(link=Link.WLAN))
    assert newest(rig).lost_wlan is UNSET


def test_a_watch_is_given_back_on_the_mesh_and_taken_again_after_the_repair() -> None:
    rig = guard()
    rig.report(LinkNoticed(link=Link.MESH))
    assert len(sent(rig.all, Resigned, to="M8")) == 1
    rig.report(LinkNoticed(link=Link.WLAN))
    answers = sent(rig.on_message("M8", award(task="M8-7", role=Role.SECONDARY, primary="ATV2")), Accepted)
    assert len(answers) == 1


# --- silent machines --------------------------------------------------------------------------------


def test_a_load_for_a_silent_machine_goes_back_to_a_storage() -> None:
    rig = carrying()
    rig.arrive()
    rig.picked()
    rig.arrive()
    rig.run(rig.now_s + GIVE_UP_AFTER * ASK_AGAIN_S + 1.0)
    assert len(sent(rig.all, Docked, to="M8")) == GIVE_UP_AFTER
    assert len(sent(rig.all, Resigned, to="M8")) == 1
    assert rig.last(Drive).nodes[-1] in {PLANT.node_of(each) for each in PLANT.storages_of("shaft")}
    rig.arrive()
    rig.dropped()
    assert newest(rig).status is AtvStatus.IDLE


def test_a_handover_that_nobody_answers_ends() -> None:
    rig = carrying()
    rig.arrive()
    rig.picked()
    rig.arrive()
    rig.on_message("M8", DockOpened(task="M8-1", epoch=1, station="M8"))
    rig.dropped()
    rig.run(rig.now_s + GIVE_UP_AFTER * ASK_AGAIN_S + 1.0)
    # Once more as a free vehicle: it goes on telling (`put_down`).
    assert len(sent(rig.all, Handover)) == GIVE_UP_AFTER + 1
    assert newest(rig).status is AtvStatus.IDLE


def test_goods_that_the_gate_refuses_are_set_aside() -> None:
    rig = VehicleRig()
    rig.start()
    rig.on_message("M8", award(work=GOODS, deadline_s=3600.0))
    rig.arrive()
    rig.on_message("M8", DockOpened(task="M8-1", epoch=1, station="M8"))
    rig.picked()
    rig.arrive()
    for _ in range(3):
        rig.failed(Drop, "not admitted")
        rig.run(rig.now_s + 6.0)
    assert [drop.goal for drop in instructed(rig.all, Drop)] == ["G8", "G8", "G8", ""]
    assert len(sent(rig.all, Resigned, to="M8")) == 1
    rig.dropped()
    assert newest(rig).status is AtvStatus.IDLE
