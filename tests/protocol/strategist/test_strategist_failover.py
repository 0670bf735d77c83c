"""The strategist finds another machine for the goals of one that fails (paper, case 1)."""

from __future__ import annotations

import msgspec
import pytest
from bureau import announced, beats, brief, contract, making
from effects import facts, instructed, sent
from rigs import StrategistRig
from spoken import mhb

from dray.body import Admit, GoodsArrived
from dray.messages import HelpWanted, MachineStatus, OutOfService, Reason, Withdrawn
from dray.messages.fact import (
    GoalContracted,
    GoalLost,
    GoalWaits,
    GoodsDelivered,
    MachineFailure,
    OrderFulfilled,
    TaskClosed,
)
from dray.messages.people.command import PROMISE_MAX_S
from dray.protocol.liveness.suspicion import BREAKDOWN_S, GOAL_SILENCE_S
from dray.protocol.runtime.events import Woke


def test_a_machine_that_names_its_goal_keeps_it_for_as_long_as_it_takes() -> None:
    rig, goal = making()
    beats(rig, 3600.0, "M7", "M8", goals=(brief(goal),))
    assert facts(rig.all, GoalLost) == []
    assert rig.admitted(goal) == 24


def test_a_strategist_that_was_held_up_itself_takes_no_goal_away_for_that() -> None:
    rig, goal = making()
    rig.on_message("M7", mhb("M7", brief(goal), seq=1000))
    rig.now_s += GOAL_SILENCE_S + 30.0
    rig.handle(Woke(rig.sense(), late_s=GOAL_SILENCE_S + 29.0))
    rig.run(rig.now_s + 5.0)
    assert rig.admitted(goal) == 24
    beats(rig, rig.now_s + GOAL_SILENCE_S + 1.0, "M8")
    assert rig.admitted(goal) == 0


@pytest.mark.parametrize("delivered", [0, 10])
def test_what_has_not_arrived_from_a_silent_machine_is_put_up_under_a_new_name(delivered: int) -> None:
    rig, goal = making()
    if delivered:
        rig.arrive(goal, delivered)
    begun_s = rig.now_s
    effects = beats(rig, begun_s + GOAL_SILENCE_S + 1.0, "M8")
    assert rig.admitted(goal) == 0
    assert announced(effects) == []  # Not before the gate has said its last word.
    effects = rig.gate_answers(goal)
    [lost] = facts(effects, GoalLost)
    assert (lost.goal, lost.machine, lost.arrived) == (goal, "M7", delivered)
    assert announced(effects) == [(lost.successor, "pump-p3", 24 - delivered)]
    assert lost.successor != goal
    assert [fact.outcome for fact in facts(effects, TaskClosed)] == ["withdrawn"]
    contract(rig, lost.successor, "M8")
    assert rig.admitted(lost.successor) == 24 - delivered
    rig.arrive(lost.successor, 24 - delivered)
    assert [fact.order for fact in facts(rig.all, OrderFulfilled)] == ["O1"]


def test_pieces_that_get_in_before_the_gate_is_shut_count() -> None:
    rig, goal = making()
    rig.arrived[goal] = 4  # It has not told yet when the strategist shuts it.
    beats(rig, rig.now_s + GOAL_SILENCE_S + 1.0, "M8")
    late = GoodsArrived(goal=goal, arrived=3, admitted=24)
    assert facts(rig.report(late), GoalLost) == []
    [lost] = facts(rig.gate_answers(goal), GoalLost)
    assert lost.arrived == 4
    assert sum(fact.quantity for fact in facts(rig.all, GoodsDelivered)) == 4


def test_all_that_was_missing_may_get_in_before_the_gate_is_shut() -> None:
    rig, goal = making()
    rig.arrived[goal] = 24
    beats(rig, rig.now_s + GOAL_SILENCE_S + 1.0, "M8")
    effects = rig.gate_answers(goal)
    assert facts(effects, GoalLost) == []
    assert [fact.order for fact in facts(effects, OrderFulfilled)] == ["O1"]


def test_a_machine_that_comes_back_is_told_that_its_goal_is_anothers() -> None:
    rig, goal = making()
    beats(rig, rig.now_s + GOAL_SILENCE_S + 1.0, "M8")
    rig.gate_answers(goal)
    effects = rig.on_message("M7", mhb("M7", brief(goal), seq=1000))
    assert [message.task for message in sent(effects, Withdrawn, to="M7")] == [goal]


def test_a_machine_that_has_forgotten_its_goal_may_bid_for_the_rest() -> None:
    rig, goal = making()
    beats(rig, rig.now_s + GOAL_SILENCE_S + 1.0, "M7")
    [lost] = facts(rig.gate_answers(goal), GoalLost)
    contract(rig, lost.successor, "M7")
    assert [fact.machine for fact in facts(rig.all, GoalContracted)] == ["M7", "M7"]


def test_while_nobody_else_lives_the_goal_stays_and_its_order_says_that_it_waits() -> None:
    rig, goal = making()
    rig.run(600.0)
    [waits] = facts(rig.all, GoalWaits)
    assert (waits.goal, waits.order) == (goal, "O1")
    assert MachineFailure("M7", Reason.SILENT) in waits.machines
    assert rig.admitted(goal) == 24
    beats(rig, 700.0, "M7", goals=(brief(goal),))
    assert facts(rig.all, GoalLost) == []
    rig.arrive(goal, 24)
    assert facts(rig.all, OrderFulfilled)


def test_a_goal_that_waits_goes_on_with_whoever_comes_back_first() -> None:
    rig, goal = making()
    rig.run(600.0)
    beats(rig, 620.0, "M9")
    [lost] = facts(rig.gate_answers(goal), GoalLost)
    contract(rig, lost.successor, "M9")
    assert facts(rig.all, GoalContracted)[-1].machine == "M9"


@pytest.mark.parametrize(("broken_s", "loses"), [(BREAKDOWN_S - 60.0, False), (BREAKDOWN_S + 60.0, True)])
def test_a_broken_machine_keeps_its_goals_for_as_long_as_a_repair_takes(broken_s: float, loses: bool) -> None:
    rig, goal = making()
    begun_s = rig.now_s
    while rig.now_s < begun_s + broken_s:
        rig.run(rig.now_s + 1.0)
        seq = round(rig.now_s * 10)
        ill = msgspec.structs.replace(mhb("M7", brief(goal), seq=seq), status=MachineStatus.ERROR)
        rig.on_message("M7", ill)
        rig.on_message("M8", mhb("M8", seq=seq))
    if rig.admitted(goal) == 0:
        rig.gate_answers(goal)
    assert bool(facts(rig.all, GoalLost)) is loses


@pytest.mark.parametrize("status", [MachineStatus.ERROR, MachineStatus.IDLE])
def test_a_goal_that_its_machine_offers_goes_to_another_at_once(status: MachineStatus) -> None:
    rig, goal = making()
    rig.on_message("M8", mhb("M8"))
    rig.arrived[goal] = 5
    _offer(rig, goal, status)
    assert rig.admitted(goal) == 0
    [lost] = facts(rig.gate_answers(goal), GoalLost)
    assert (lost.machine, lost.arrived) == ("M7", 5)
    contract(rig, lost.successor, "M8")
    assert rig.admitted(lost.successor) == 19


def test_a_goal_that_nobody_else_can_make_stays_and_its_order_says_so_until_its_machine_is_back() -> None:
    rig, goal = making()
    rig.run(rig.now_s + 10.0)
    rig.on_message("M7", mhb("M7", brief(goal), seq=900))
    rig.run(rig.now_s + GOAL_SILENCE_S - 10.0)
    _offer(rig, goal, MachineStatus.IDLE)
    assert rig.admitted(goal) == 24
    [waits] = facts(rig.all, GoalWaits)
    assert MachineFailure("M7", Reason.OUT_OF_SERVICE) in waits.machines
    rig.on_message("M7", mhb("M7", brief(goal), seq=1001))
    rig.on_message("M8", mhb("M8", seq=1001))
    rig.run(rig.now_s + 2.0)
    assert rig.admitted(goal) == 24
    assert facts(rig.all, GoalLost) == []


def test_whoever_is_out_of_service_is_nobody_who_could_make_it() -> None:
    rig, goal = making()
    out = OutOfService(by="Maria", since_s=0.0)
    others = ("M6", "M8", "M9", "M11")
    for each in others:
        rig.on_message(each, msgspec.structs.replace(mhb(each, seq=900), out_of_service=out))
    _offer(rig, goal, MachineStatus.ERROR)
    [waits] = facts(rig.all, GoalWaits)
    assert {MachineFailure(each, Reason.OUT_OF_SERVICE) for each in others} < set(waits.machines)


@pytest.mark.parametrize(("promised_s", "loses"), [(300.0, False), (1e6, True)])
def test_a_promise_is_waited_for_though_the_repair_takes_long_but_not_for_ever(
    promised_s: float, loses: bool
) -> None:
    rig, goal = making()
    begun_s = rig.now_s
    while rig.now_s < begun_s + BREAKDOWN_S + (200.0 if not loses else PROMISE_MAX_S + 60.0):
        rig.run(rig.now_s + 1.0)
        seq = round(rig.now_s * 10)
        wanted = HelpWanted(until_s=promised_s, promised_by="Maria")
        ill = mhb("M7", brief(goal), seq=seq)
        rig.on_message("M7", msgspec.structs.replace(ill, status=MachineStatus.ERROR, help=wanted))
        rig.on_message("M8", mhb("M8", seq=seq))
    if rig.admitted(goal) == 0:
        rig.gate_answers(goal)
    assert bool(facts(rig.all, GoalLost)) is loses


def _offer(rig: StrategistRig, goal: str, status: MachineStatus) -> None:
    """M7 asks that others make the rest: it is broken, or out of service."""
    offered = msgspec.structs.replace(brief(goal), offered=True)
    out = OutOfService(by="Maria", since_s=0.0) if status is MachineStatus.IDLE else msgspec.UNSET
    beat = msgspec.structs.replace(mhb("M7", offered, seq=1000), status=status, out_of_service=out)
    rig.on_message("M7", beat)


@pytest.mark.parametrize("others_live", [True, False])
def test_what_a_machine_that_works_offers_goes_to_others_and_not_back_to_it(others_live: bool) -> None:
    rig, goal = making()
    offered = msgspec.structs.replace(brief(goal), offered=True)
    live = ("M7", "M8") if others_live else ("M7",)
    beats(rig, rig.now_s + 2.0 * GOAL_SILENCE_S, *live, goals=(brief(goal),))
    effects = beats(rig, rig.now_s + 2.0 * GOAL_SILENCE_S, *live, goals=(offered,))
    assert (rig.admitted(goal) == 0) is others_live
    reasons = {each.machine: each.reason for fact in facts(effects, GoalWaits) for each in fact.machines}
    assert reasons.get("M7") == (None if others_live else Reason.CLOSED)


def test_what_was_offered_by_a_machine_that_has_forgotten_it_may_go_back_to_it() -> None:
    rig, goal = making()
    offered = msgspec.structs.replace(brief(goal), offered=True)
    beats(rig, rig.now_s + 2.0 * GOAL_SILENCE_S, "M7", goals=(brief(goal),))
    beats(rig, rig.now_s + 2.0 * GOAL_SILENCE_S, "M7", goals=(offered,))
    assert rig.admitted(goal) == 24, "it is the only one that lives"
    beats(rig, rig.now_s + 2.0 * GOAL_SILENCE_S, "M7")
    assert rig.admitted(goal) == 0


def test_a_machine_that_is_back_when_the_gate_is_shut_comes_too_late() -> None:
    rig, goal = making()
    beats(rig, rig.now_s + GOAL_SILENCE_S + 1.0, "M8")
    assert rig.admitted(goal) == 0
    beats(rig, rig.now_s + GOAL_SILENCE_S + 2.0, "M7", "M8", goals=(brief(goal),))
    assert rig.admitted(goal) == 0
    assert facts(rig.gate_answers(goal), GoalLost)


def test_a_gate_that_does_not_answer_is_shut_again_until_it_does() -> None:
    rig, _ = making()
    effects = beats(rig, rig.now_s + 5 * GOAL_SILENCE_S, "M8")
    assert len([admit for admit in instructed(effects, Admit) if not admit.quantity]) > 2
    assert facts(effects, GoalLost) == []


def test_an_old_heartbeat_keeps_no_goal() -> None:
    rig, goal = making()
    rig.on_message("M7", mhb("M7", brief(goal), seq=50))
    for _ in range(20):
        rig.run(rig.now_s + 1.0)
        rig.on_message("M7", mhb("M7", brief(goal), seq=49))
        rig.on_message("M8", mhb("M8", seq=round(rig.now_s * 10)))
    assert rig.admitted(goal) == 0
