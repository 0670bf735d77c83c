"""A machine that is asked to leave, and one whose carrier leaves (paper, 4.2 case 6)."""

from __future__ import annotations

from itertools import pairwise

import msgspec
import pytest
from defaults import PLANT
from effects import award_number, facts, published, sent
from rigs import MachineRig
from spoken import announcement, production, rhb
from transports_rig import TransportsRig, watched

from dray.messages import (
    Award,
    Bid,
    Brief,
    Declined,
    MachineHeartbeat,
    Phase,
    Reason,
    Refusal,
    Resigned,
    Role,
    Superseded,
    TaskAnnounced,
)
from dray.messages.fact import BidRefused, CarrierChanged
from dray.protocol.liveness.suspicion import GOAL_SILENCE_S
from dray.protocol.runtime.shutdown import COORDINATOR_LEAVES_WITHIN_S

# --- its coordinator --------------------------------------------------------------------------------


def gives_back(rig: TransportsRig, atv: str = "ATV2", epoch: int = 1) -> None:
    resigned = Resigned(task="T1", epoch=epoch, role=Role.PRIMARY, reason=Reason.GRACEFUL_SHUTDOWN)
    rig.transports.on_resigned(atv, resigned, rig.now_s)


def test_in_a_planned_takeover_the_secondary_is_asked_and_nobody_else() -> None:
    rig = watched()
    gives_back(rig)
    assert sent(rig.out, Superseded, to="ATV2") == [Superseded(task="T1", epoch=2)]
    [asked] = sent(rig.out, Award, to="ATV1")[-1:]
    assert (asked.task, asked.epoch, asked.role) == ("T1", 2, Role.PRIMARY)
    rig.accepts("ATV1", epoch=2)
    assert (rig.task.primary, rig.task.epoch) == ("ATV1", 2)
    assert rig.asked(Role.PRIMARY) == ["ATV2", "ATV1"]
    announced = published(rig.out, TaskAnnounced)
    assert [said.epoch for said in announced if said.role is Role.PRIMARY] == [1]
    [changed] = facts(rig.out, CarrierChanged)
    assert (changed.replaced, changed.carrier, changed.reason) == ("ATV2", "", Reason.GRACEFUL_SHUTDOWN)


def test_a_secondary_that_declines_lets_the_task_be_announced() -> None:
    rig = watched()
    gives_back(rig)
    declined = Declined(
        task="T1", epoch=2, role=Role.PRIMARY, reason=Refusal.BUSY, number=award_number(rig.out, "ATV1")
    )
    rig.transports.on_declined("ATV1", declined, rig.now_s)
    rig.run(rig.now_s + 1.0)
    assert published(rig.out, TaskAnnounced)[-1].epoch == 2


def test_a_secondary_that_is_silent_is_released_and_the_task_announced() -> None:
    rig = watched()
    gives_back(rig)
    rig.run(rig.now_s + 2.0)
    assert rig.released()[-1] == ("ATV1", Role.PRIMARY)
    assert published(rig.out, TaskAnnounced)[-1].epoch == 2


def test_without_a_secondary_the_task_is_announced_at_once() -> None:
    rig = watched()
    rig.resigns("ATV1")
    gives_back(rig)
    [announced] = [said for said in published(rig.out, TaskAnnounced) if said.epoch == 2]
    assert (announced.role, announced.round) == (Role.PRIMARY, 1)


def test_who_did_not_hear_that_it_was_relieved_is_told_again() -> None:
    rig = watched()
    gives_back(rig)
    gives_back(rig)
    assert sent(rig.out, Superseded, to="ATV2") == [Superseded(task="T1", epoch=2)] * 2
    assert len(facts(rig.out, CarrierChanged)) == 1


@pytest.mark.parametrize("answers", [False, True])
def test_who_has_given_it_back_is_not_acknowledged_by_an_older_heartbeat(answers: bool) -> None:
    rig = watched()
    gives_back(rig)
    if answers:
        declined = Declined(
            task="T1",
            epoch=2,
            role=Role.PRIMARY,
            reason=Refusal.BUSY,
            number=award_number(rig.out, "ATV1"),
        )
        rig.transports.on_declined("ATV1", declined, rig.now_s)
    brief = Brief(task="T1", epoch=1, role=Role.PRIMARY, coordinator="M8", phase=Phase.RETURNING)
    rig.transports.acknowledge_carrier("ATV2", brief, rig.now_s)
    assert (rig.task.primary, rig.task.epoch) == ("", 2)


def test_who_gives_back_what_has_ended_is_told_so() -> None:
    rig = watched()
    rig.transports.close(rig.task, "delivered")
    gives_back(rig)
    assert sent(rig.out, Superseded, to="ATV2") == [Superseded(task="T1", epoch=1)]


# --- a machine --------------------------------------------------------------------------------------


def supplied(**stock: int) -> MachineRig:
    """M7 with a goal, and with material but for what is said."""
    full = {material: PLANT.materials[material].buffer for material in PLANT.materials_of("M7")}
    rig = MachineRig("M7", full | stock)
    rig.start()
    rig.take_goal("G1", production())
    return rig


def test_a_machine_that_waits_for_nobody_leaves_at_once() -> None:
    rig = supplied()
    rig.leave()
    assert rig.has_left
    assert rig.heartbeats(MachineHeartbeat)[-1].draining


def test_it_takes_no_goals_any_more() -> None:
    rig = supplied(housing=0)
    rig.leave()
    assert not rig.has_left, "somebody may be about to bid for the housings"
    goal = announcement(task="G2", coordinator="STRATEGIST", work=production())
    effects = rig.on_message("STRATEGIST", goal)
    assert not sent(effects, Bid)
    assert [refused.detail for refused in facts(effects, BidRefused)] == ["draining"]
    [declined] = sent(rig.award_goal("G2", production()), Declined)
    assert declined.reason is Refusal.NOT_FIT


def test_it_goes_on_making_and_announces_nothing() -> None:
    rig = supplied(housing=0)
    rig.leave()
    rig.stocked("housing", 1, "ATV9")
    announced = {said.task for said in published(rig.all, TaskAnnounced)}
    while rig.is_cycling:
        rig.cycle()
    assert {said.task for said in published(rig.all, TaskAnnounced)} == announced


def test_an_auction_that_has_begun_is_brought_to_its_end() -> None:
    rig = supplied(housing=0)
    [task] = {said.task for said in published(rig.all, TaskAnnounced)}
    rig.leave()
    rig.hire(task, "ATV1")
    assert rig.has_left


def test_an_auction_in_which_nobody_bids_holds_nobody() -> None:
    rig = supplied(housing=0)
    rig.leave()
    rig.run(rig.now_s + 5.0)
    assert rig.has_left


def at_the_dock(rig: MachineRig, task: str, seq: int, phase: Phase) -> None:
    brief = Brief(task=task, epoch=1, role=Role.PRIMARY, coordinator="M7", phase=phase)
    heartbeat = rhb("ATV1", seq, rig.now_s, task=task, coordinator="M7")
    rig.on_message("ATV1", msgspec.structs.replace(heartbeat, task=brief))


def with_a_carrier() -> tuple[MachineRig, str]:
    rig = supplied(housing=0)
    [task] = {said.task for said in published(rig.all, TaskAnnounced)}
    rig.hire(task, "ATV1")
    return rig, task


def test_a_vehicle_on_its_way_does_not_hold_it() -> None:
    rig, task = with_a_carrier()
    at_the_dock(rig, task, 1, Phase.CARRYING)
    rig.leave()
    assert rig.has_left


@pytest.mark.parametrize("phase", [Phase.UNLOADING, Phase.HANDING_OVER])
def test_a_vehicle_at_its_dock_holds_it_for_a_bounded_time(phase: Phase) -> None:
    rig, task = with_a_carrier()
    at_the_dock(rig, task, 1, phase)
    rig.leave()
    asked_s = rig.now_s
    for seq in range(2, 30):
        rig.run(asked_s + seq - 1)
        at_the_dock(rig, task, seq, phase)
        assert not rig.has_left
    rig.run(asked_s + COORDINATOR_LEAVES_WITHIN_S)
    assert rig.has_left
    said_s = [heartbeat.at_s for heartbeat in rig.heartbeats(MachineHeartbeat)]
    assert max(later_s - earlier_s for earlier_s, later_s in pairwise(said_s)) < GOAL_SILENCE_S
    assert said_s[-1] == rig.now_s, "only its absence counts as silence"
