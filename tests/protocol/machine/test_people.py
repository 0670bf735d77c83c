"""A machine asks people for help, obeys them where they may command, and lets others make what it cannot (paper, case 1)."""

from __future__ import annotations

import pytest
from defaults import PLANT
from effects import committed, facts, instructed, published, sent
from m7 import m7, outgoing
from msgspec import UNSET
from rigs import MachineRig
from seals import granted
from spoken import announcement, production

from dray.body import Broken, Repaired, ResetFault, SetPace
from dray.messages import (
    Bid,
    CommandAnswered,
    CommandRefusal,
    Confirmed,
    HelpWanted,
    MachineCommand,
    MachineCommandKind,
    MachineHeartbeat,
    MachineStatus,
    OutOfService,
    Problem,
    ProblemEnded,
    ProblemKind,
    Withdrawn,
)
from dray.messages.fact import CommandObeyed, HelpAsked, HelpPromised, TaskClosed
from dray.messages.people.command import OUT_MAX_S, PROMISE_MAX_S
from dray.protocol.liveness.suspicion import BREAKDOWN_S
from dray.protocol.machine.people.breakdown import GOAL_PATIENCE_MIN_S
from dray.protocol.machine.people.command_handling import NO_UPDATES, NOTHING_RESTARTS, ONE_SPEED
from dray.protocol.machine.production import GOODS_LEAVE_S
from dray.protocol.runtime.events import Leave
from dray.protocol.runtime.running import Running

TOOL = Problem(kind=ProblemKind.TOOL)
JAM = Problem(kind=ProblemKind.JAM)
KIND = MachineCommandKind


def told(rig: MachineRig, kind: MachineCommandKind, **more: object) -> CommandAnswered:
    command = MachineCommand(command=f"C{len(rig.all)}", kind=kind, issued_by="Maria", **more)  # type: ignore[arg-type]
    [answer] = sent(rig.on_message("gateway", granted("M7", command)), CommandAnswered)
    return answer


def newest(rig: MachineRig) -> MachineHeartbeat:
    rig.run(rig.now_s + 0.001)
    return published(rig.all, MachineHeartbeat)[-1]


def broken(rig: MachineRig, problem: Problem | None = None, *, resettable: bool = False) -> None:
    rig.broken = "it stands"
    rig.report(Broken("it stands", problem or Problem(), resettable))


def offered(rig: MachineRig) -> list[str]:
    return [brief.goal for brief in newest(rig).goals if brief.offered is True]


# --- what is asked for, and for how long ---


def test_of_a_breakdown_with_words_only_its_goals_wait_as_ever() -> None:
    rig = m7(goal=24)
    broken(rig)
    beat = newest(rig)
    assert (beat.status, beat.problem, beat.about_problem) == (MachineStatus.ERROR, "it stands", UNSET)
    assert beat.help == HelpWanted(until_s=BREAKDOWN_S)
    [asked] = facts(rig.all, HelpAsked)
    assert (asked.task, asked.until_s) == ("G1", BREAKDOWN_S)
    rig.run(BREAKDOWN_S - 1.0)
    assert offered(rig) == []


def test_what_takes_longer_than_the_deadline_allows_is_offered_at_once_and_a_person_asked_all_the_same() -> (
    None
):
    rig = m7(goal=24)
    broken(rig, TOOL)
    assert newest(rig).help == HelpWanted(until_s=0.0)
    assert newest(rig).about_problem == TOOL
    assert offered(rig) == ["G1"]
    assert len(facts(rig.all, HelpAsked)) == 1


def test_what_is_usually_over_sooner_is_waited_for_and_how_long_that_was_all_machines_hear() -> None:
    rig = m7()
    rig.take_goal("G1", production(quantity=4), deadline_s=600.0)
    broken(rig, JAM)
    left_s = 600.0 - 4 * PLANT.cycle_s("M7", "pump-p3")
    assert newest(rig).help == HelpWanted(until_s=left_s)
    rig.run(50.0)
    rig.broken = ""
    [ended] = published(rig.report(Repaired()), ProblemEnded)
    assert (ended.agent, ended.problem) == ("M7", JAM)
    assert 49.0 < ended.lasted_s <= 50.1
    assert newest(rig).help is UNSET


def test_it_learns_from_the_breakdowns_of_others() -> None:
    rig = m7()
    rig.take_goal("G1", production(quantity=4), deadline_s=600.0)
    for other in ("M1", "M2", "M3", "M4"):
        rig.on_message(other, ProblemEnded(agent=other, problem=JAM, lasted_s=1500.0))
    broken(rig, JAM)
    assert newest(rig).help == HelpWanted(until_s=rig.now_s - 0.001) or offered(rig) == ["G1"]
    assert offered(rig) == ["G1"]


def test_a_goal_that_is_late_already_is_waited_for_shortly() -> None:
    rig = m7()
    rig.take_goal("G1", production(quantity=24), deadline_s=1.0)
    broken(rig, Problem(kind=ProblemKind.UNKNOWN, passes=True))
    assert newest(rig).help == HelpWanted(until_s=GOAL_PATIENCE_MIN_S)
    rig.run(GOAL_PATIENCE_MIN_S + 1.0)
    assert offered(rig) == ["G1"]


# --- what people say to it ---


def test_a_promise_is_waited_for_and_no_longer() -> None:
    rig = m7(goal=24)
    assert told(rig, KIND.PROMISE, wait_s=60.0).reason is CommandRefusal.NOT_WAITING
    broken(rig, TOOL)
    assert told(rig, KIND.PROMISE, wait_s=PROMISE_MAX_S + 1.0).reason is CommandRefusal.WAIT_OUT_OF_RANGE
    assert told(rig, KIND.PROMISE, wait_s=60.0).done
    assert newest(rig).help == HelpWanted(until_s=rig.now_s - 0.001 + 60.0, promised_by="Maria")
    assert offered(rig) == []
    assert [fact.promised_by for fact in facts(rig.all, HelpPromised)] == ["Maria"]
    rig.run(rig.now_s + 61.0)
    assert offered(rig) == ["G1"]


def test_a_person_hands_its_goals_over_now_and_a_repair_keeps_those_that_nobody_has_taken() -> None:
    rig = m7(goal=24)
    assert told(rig, KIND.HAND_OVER).reason is CommandRefusal.NOT_WAITING
    broken(rig)
    assert told(rig, KIND.HAND_OVER).done
    assert offered(rig) == ["G1"]
    assert newest(rig).status is MachineStatus.ERROR
    rig.broken = ""
    rig.report(Repaired())
    assert offered(rig) == []
    assert newest(rig).status is MachineStatus.PRODUCING


def test_what_the_strategist_gives_to_another_is_not_made_here_any_more() -> None:
    rig = m7(goal=24)
    broken(rig)
    told(rig, KIND.HAND_OVER)
    rig.on_message("STRATEGIST", Withdrawn(task="G1", epoch=1))
    rig.broken = ""
    rig.report(Repaired())
    assert newest(rig).goals == ()
    rig.cycle()  # What was begun comes out, and is spare.
    assert not rig.is_cycling


def test_what_was_made_leaves_before_the_rest_is_offered_or_is_made_again_after_a_while() -> None:
    rig = m7(goal=24)
    rig.cycles(3)
    broken(rig)
    told(rig, KIND.HAND_OVER)
    assert outgoing(rig.all) == [("G1", 3)], "less than a container is fetched, since no more will come"
    assert offered(rig) == []
    rig.run(rig.now_s + GOODS_LEAVE_S + 5.0)
    assert offered(rig) == ["G1"]


def test_nothing_more_is_brought_for_what_is_given_back() -> None:
    rig = m7(stock={}, goal=24)
    rig.run(30.0)
    open_before = {brief.task for brief in newest(rig).tasks}
    assert open_before
    broken(rig)
    told(rig, KIND.HAND_OVER)
    assert newest(rig).tasks == ()
    assert {fact.task for fact in facts(rig.all, TaskClosed) if fact.outcome == "withdrawn"} == open_before


def test_a_fault_is_cleared_when_the_sensors_find_nothing_any_more_and_not_before() -> None:
    rig = m7(goal=24)
    assert told(rig, KIND.CLEAR_FAULT).reason is CommandRefusal.NOT_FAULTY
    broken(rig, JAM)
    answer = told(rig, KIND.CLEAR_FAULT)
    assert (answer.reason, answer.detail) == (CommandRefusal.FAULTY, "it stands")
    assert instructed(rig.all, ResetFault) == []
    broken(rig, JAM, resettable=True)
    assert newest(rig).resettable is True
    assert len(facts(rig.all, HelpAsked)) == 1
    assert told(rig, KIND.CLEAR_FAULT).done
    assert len(instructed(rig.all, ResetFault)) == 1


def test_it_works_slowly_by_a_persons_word_and_its_promises_count_that() -> None:
    rig = m7()
    assert told(rig, KIND.SET_SPEED, speed_frac=0.5).done
    assert instructed(rig.all, SetPace) == [SetPace(0.5)]
    assert newest(rig).speed_frac == 0.5
    effects = rig.on_message("S", announcement(task="G1", coordinator="S", work=production()))
    assert [bid.cost.total_s for bid in sent(effects, Bid)] == [2 * 24 * PLANT.cycle_s("M7", "pump-p3")]
    assert told(rig, KIND.SET_SPEED, speed_frac=1.0).done
    assert newest(rig).speed_frac is UNSET
    assert told(rig, KIND.SET_SPEED, speed_frac=0.0).reason is CommandRefusal.SPEED_OUT_OF_RANGE


def test_what_its_body_or_whoever_runs_it_cannot_do_is_refused_with_that_as_the_reason() -> None:
    rig = MachineRig("M7")
    rig.paces = False
    rig.start()
    for kind, detail in (
        (KIND.SET_SPEED, ONE_SPEED),
        (KIND.RESTART, NOTHING_RESTARTS),
        (KIND.UPDATE, NOTHING_RESTARTS),
    ):
        answer = told(rig, kind, speed_frac=0.5 if kind is KIND.SET_SPEED else None)
        assert (answer.reason, answer.detail) == (CommandRefusal.NOT_SUPPORTED, detail)
    rig = MachineRig("M7", running=Running(starts_again=True))
    rig.start()
    assert told(rig, KIND.UPDATE).detail == NO_UPDATES


@pytest.mark.parametrize("kind", [KIND.RESTART, KIND.UPDATE])
def test_it_leaves_in_order_to_be_started_again(kind: MachineCommandKind) -> None:
    rig = MachineRig("M7", running=Running(starts_again=True, updates=True))
    rig.start()
    assert told(rig, kind).done
    assert rig.all[-1] == Leave(again=True, update=kind is KIND.UPDATE)


def test_a_grant_for_another_area_or_another_machine_moves_nothing() -> None:
    rig = m7(goal=24)
    command = MachineCommand(command="C1", kind=KIND.TAKE_OUT)
    areas = set(PLANT.areas) - set(PLANT.areas_at(*PLANT.position_of("M7")))
    for words, why in (
        (granted("M7", command, areas=areas), CommandRefusal.NOT_HERE),
        (granted("M8", command), CommandRefusal.NOT_TRUSTED),
        (command, CommandRefusal.NOT_GRANTED),
    ):
        [answer] = sent(rig.on_message("gateway", words), CommandAnswered)
        assert answer.reason is why
    assert newest(rig).out_of_service is UNSET
    assert [fact.done for fact in facts(rig.all, CommandObeyed)] == [False] * 3


# --- out of service ---


def test_out_of_service_it_says_who_why_and_until_when_and_takes_no_goals() -> None:
    rig = m7()
    assert told(rig, KIND.TAKE_OUT, reason="new bearings", wait_s=OUT_MAX_S + 1.0).reason is not None
    assert told(rig, KIND.TAKE_OUT, reason="new bearings", wait_s=3600.0).done
    out = OutOfService(by="Maria", since_s=0.0, reason="new bearings", back_s=3600.0)
    assert newest(rig).out_of_service == out
    assert sent(rig.on_message("S", announcement(task="G1", coordinator="S", work=production())), Bid) == []
    assert told(rig, KIND.PUT_IN).done
    assert told(rig, KIND.PUT_IN).reason is CommandRefusal.IN_SERVICE
    assert (
        len(sent(rig.on_message("S", announcement(task="G2", coordinator="S", work=production())), Bid)) == 1
    )


def test_what_is_being_made_ends_and_all_else_is_offered() -> None:
    rig = m7(goal=24)
    assert rig.is_cycling
    told(rig, KIND.TAKE_OUT)
    assert offered(rig) == ["G1"]
    rig.cycle()
    assert not rig.is_cycling
    assert newest(rig).status is MachineStatus.IDLE


def test_after_the_present_work_it_finishes_the_goal_it_works_at_and_offers_the_others() -> None:
    rig = m7(goal=4)
    rig.take_goal("G2", production(quantity=24), deadline_s=7200.0)
    told(rig, KIND.TAKE_OUT, after_work=True)
    assert offered(rig) == ["G2"]
    rig.cycles(4)
    assert not rig.is_cycling
    assert outgoing(rig.all) == [("G1", 4)]


def test_one_that_is_back_goes_on_with_what_nobody_has_taken() -> None:
    rig = m7(goal=4)
    told(rig, KIND.TAKE_OUT)
    rig.cycle()
    told(rig, KIND.PUT_IN)
    assert offered(rig) == []
    assert rig.is_cycling


def test_what_is_broken_is_not_put_into_service() -> None:
    rig = m7()
    told(rig, KIND.TAKE_OUT)
    broken(rig)
    assert told(rig, KIND.PUT_IN).reason is CommandRefusal.FAULTY


def test_its_next_life_knows_what_it_was_told_and_does_no_old_word_again() -> None:
    rig = m7(goal=24)
    told(rig, KIND.SET_SPEED, speed_frac=0.5)
    command = granted("M7", MachineCommand(command="OUT", kind=KIND.TAKE_OUT, reason="new bearings"))
    rig.on_message("gateway", command)
    broken(rig)
    told(rig, KIND.PROMISE, wait_s=60.0)
    again = MachineRig("M7", rig.stock, incarnation=2)
    again.memory, again.now_s, again.broken = committed(rig.all), rig.now_s, rig.broken
    again.start()
    beat = newest(again)
    assert beat.out_of_service is not UNSET
    assert beat.speed_frac == 0.5
    assert beat.help is not UNSET
    assert beat.help.promised_by == "Maria"
    assert instructed(again.all, SetPace) == [SetPace(0.5)]
    again.broken = ""
    again.report(Repaired())
    told(again, KIND.PUT_IN)
    again.on_message("gateway", command)
    assert newest(again).out_of_service is UNSET


def test_a_goal_that_is_confirmed_while_it_is_out_is_offered_too() -> None:
    rig = m7()
    rig.award_goal("G1", production(quantity=24))
    told(rig, KIND.TAKE_OUT)
    rig.on_message("STRATEGIST", Confirmed(task="G1", epoch=1))
    assert offered(rig) == ["G1"]
    assert not rig.is_cycling
