"""A secondary takes over from a primary that is silent (protocol, "When something fails")."""

from __future__ import annotations

import pytest
from defaults import PLANT
from effects import facts, sent
from spoken import award
from watches import BOUND_S, GOODS, beat, claims, guard, reborn

from dray.body import Drive
from dray.memory import AtvMemory
from dray.messages import (
    AtvHeartbeat,
    AtvStatus,
    Confirmed,
    Link,
    Phase,
    Reason,
    Release,
    Resigned,
    Role,
    TakenOver,
)
from dray.messages.fact import ContractEnded, TookOver
from dray.protocol.runtime.events import Commit
from dray.protocol.runtime.retransmission import ASK_AGAIN_S


def test_a_secondary_takes_over_as_soon_as_its_primary_has_been_silent_for_the_bound() -> None:
    rig = guard()
    rig.run(BOUND_S - 0.01)
    assert claims(rig) == []
    rig.run(BOUND_S)
    [claim] = claims(rig)
    assert (claim.task, claim.epoch, claim.primary, claim.source) == ("M8-1", 2, "ATV2", "S3")
    [took] = facts(rig.all, TookOver)
    assert (took.silent_s, took.reason) == (BOUND_S, Reason.SILENT)
    assert rig.last(Drive).nodes[-1] == PLANT.node_of("S3")
    rig.run(rig.now_s)
    heartbeat = rig.heartbeats(AtvHeartbeat)[-1]
    assert heartbeat.status is AtvStatus.WORKING
    assert heartbeat.task is not None
    assert (heartbeat.task.task, heartbeat.task.epoch) == ("M8-1", 2)


def test_a_heartbeat_that_came_through_the_mesh_is_a_heartbeat() -> None:
    rig = guard()
    for seq in range(2, 40):
        rig.run(float(seq - 1))
        beat(rig, seq, link=Link.MESH, via=("ATV5",))
    assert claims(rig) == []


def test_it_says_so_until_the_machine_has_confirmed() -> None:
    rig = guard()
    rig.run(BOUND_S + 2.5 * ASK_AGAIN_S)
    assert len(claims(rig)) == 3
    rig.on_message("M8", Confirmed(task="M8-1", epoch=2))
    rig.run(rig.now_s + 5 * ASK_AGAIN_S)
    assert len(claims(rig)) == 3


def test_a_confirmation_of_an_earlier_epoch_confirms_nothing() -> None:
    rig = guard()
    rig.run(BOUND_S)
    rig.on_message("M8", Confirmed(task="M8-1", epoch=1))
    rig.on_message("M3", Confirmed(task="M8-1", epoch=2))
    rig.run(BOUND_S + ASK_AGAIN_S)
    assert len(claims(rig)) == 2


def test_its_next_life_says_so_too_until_the_machine_has_confirmed() -> None:
    rig = guard()
    rig.run(BOUND_S)
    again = reborn(rig)
    assert claims(again) == claims(rig)
    again.on_message("M8", Confirmed(task="M8-1", epoch=2))
    again.run(again.now_s + 5 * ASK_AGAIN_S)
    assert len(claims(again)) == 1


def test_a_takeover_that_the_machine_refuses_ends() -> None:
    rig = guard()
    rig.run(BOUND_S)
    rig.on_message("M8", Release(task="M8-1", epoch=2, role=Role.PRIMARY, reason=Reason.IS_HEARD))
    assert facts(rig.all, ContractEnded)[-1].reason == Reason.RELEASED
    said = len(claims(rig))
    rig.run(rig.now_s + 10 * ASK_AGAIN_S)
    assert len(claims(rig)) == said


def test_what_is_carried_in_its_stead_is_written_down_before_it_is_said() -> None:
    rig = guard()
    effects = rig.run(BOUND_S)
    kinds = [type(effect) for effect in effects if isinstance(effect, Commit) or sent([effect], TakenOver)]
    assert kinds[0] is Commit
    [commit] = [effect for effect in effects if isinstance(effect, Commit)]
    assert isinstance(commit.note, AtvMemory)
    assert commit.note.contract is not None
    assert commit.note.contract.epoch == 2


@pytest.mark.parametrize("phase", [Phase.CARRYING, Phase.UNLOADING, Phase.HANDING_OVER])
def test_goods_that_are_on_board_cannot_be_fetched_by_another_one(phase: Phase) -> None:
    rig = guard(work=GOODS)
    beat(rig, 2, phase=phase)
    rig.run(60.0)
    assert claims(rig) == []


def test_goods_that_are_not_fetched_yet_can() -> None:
    rig = guard(work=GOODS)
    beat(rig, 2, phase=Phase.APPROACHING)
    rig.run(BOUND_S)
    assert len(claims(rig)) == 1


def test_one_that_cannot_carry_it_any_more_resigns_from_its_watch() -> None:
    rig = guard()
    rig.battery_frac = 0.05
    rig.run(60.0)
    assert claims(rig) == []
    [resigned] = sent(rig.all, Resigned, to="M8")
    assert (resigned.role, resigned.epoch) == (Role.SECONDARY, 1)


def test_of_two_tasks_it_takes_one_and_gives_the_other_back() -> None:
    rig = guard()
    rig.on_message("M9", award(task="M9-1", role=Role.SECONDARY, primary="ATV2"))
    rig.run(2 * BOUND_S)
    assert {claim.task for claim in sent(rig.all, TakenOver)} == {"M8-1"}
    assert len(sent(rig.all, Resigned)) == 1
