"""A vehicle that has stopped itself calls people until one has seen to it, and says why it stands."""

from __future__ import annotations

from atv1 import command, last_beat, parked, secondary
from effects import committed, facts, instructed, published, sent
from msgspec.structs import replace
from placing import TRAFFIC, answer
from rigs import VehicleRig
from spoken import announcement, award

from dray.body import Hold, ProblemCleared, ProblemRaised
from dray.memory import WHOLE, AtvMemory
from dray.messages import (
    AtvStatus,
    CallState,
    CommandKind,
    CommandRefusal,
    HelpCall,
    HoldsAsked,
    Reason,
    Resigned,
)
from dray.messages.fact import BidRefused
from dray.protocol.traffic.traffic_map import TrafficMap
from dray.protocol.vehicle.atv import Atv
from dray.protocol.vehicle.people.command_handling import ALONE, DENIED, DOUBLED, FORGOTTEN
from dray.protocol.vehicle.people.problem_handling import DOUBLED_S


def doubled() -> VehicleRig:
    """ATV1, which has just been answered what it has not said."""
    rig = parked()
    agent = rig.agent
    assert isinstance(agent, Atv)
    agent.problems.note_doubled(rig.now_s)
    rig.held = True
    rig.wake()
    return rig


def denied() -> VehicleRig:
    """ATV1, which has just heard on its way to S3 that it was carried away."""
    rig = parked(traffic=TRAFFIC)
    answer(rig)
    rig.on_message("M8", award())
    answer(rig)
    answer(rig, removal=1, grants=False)
    rig.held = True
    rig.wake()
    return rig


def ask_holds(rig: VehicleRig) -> None:
    """Two replicas of reservation tables ask it what it holds."""
    for replica in ("M1", "M2"):
        rig.on_message(replica, HoldsAsked(district="M1.0", epoch=0))


def alone() -> VehicleRig:
    """ATV1 without right of way, which has just heard that others have it."""
    rig = parked()
    ask_holds(rig)
    rig.held = True
    rig.wake()
    return rig


def next_life(before: VehicleRig, *, traffic: TrafficMap | None = None, held: bool = True) -> VehicleRig:
    """It starts again with what it has noted; `held`: its body still stands."""
    rig = VehicleRig(incarnation=2, traffic=traffic)
    rig.held = held
    rig.memory = committed(before.all)
    rig.start()
    return rig


def says(rig: VehicleRig, task: str) -> str:
    """Why it does not bid for a new task."""
    [refused] = facts(rig.on_message("M8", announcement(task=task)), BidRefused)
    return refused.detail


def calls(rig: VehicleRig) -> tuple[str, bool]:
    """What its newest call is for, and whether it goes on."""
    newest = published(rig.all, HelpCall)[-1]
    return newest.reason, newest.state is not CallState.ENDED


def test_it_calls_on_when_nothing_more_is_heard_of_the_other_one() -> None:
    rig = doubled()
    rig.run(rig.now_s + 3.0 * DOUBLED_S)
    beat = last_beat(rig)
    assert (beat.status, beat.problem) == (AtvStatus.STOPPED, "")
    assert calls(rig) == (DOUBLED, True)
    assert len({call.call for call in published(rig.all, HelpCall)}) == 1


def test_a_person_lets_it_go_when_the_other_one_is_quiet_and_is_called_no_more() -> None:
    rig = doubled()
    rig.run(rig.now_s + 0.5 * DOUBLED_S)
    assert command(rig, CommandKind.ACKNOWLEDGE).reason is CommandRefusal.FAULTY
    rig.run(rig.now_s + DOUBLED_S)
    assert command(rig, CommandKind.ACKNOWLEDGE).done
    rig.run(rig.now_s + 1.0)
    assert calls(rig) == (DOUBLED, False)
    assert command(rig, CommandKind.RESUME).done


def test_a_problem_of_its_body_that_passes_leaves_the_call() -> None:
    rig = doubled()
    rig.report(ProblemRaised(reason="a wheel is stuck"))
    rig.report(ProblemCleared())
    rig.run(rig.now_s + 3.0 * DOUBLED_S)
    assert calls(rig) == (DOUBLED, True)


def test_its_next_life_calls_too() -> None:
    rig = next_life(doubled())
    rig.run(DOUBLED_S)
    assert calls(rig) == (DOUBLED, True)
    assert command(rig, CommandKind.ACKNOWLEDGE).done


def test_its_next_life_calls_also_when_its_memory_is_lost() -> None:
    """Its body stands, and it cannot know whether a person has stopped it."""
    rig = VehicleRig(incarnation=2)
    rig.held = True
    rig.start()
    rig.run(DOUBLED_S)
    assert last_beat(rig).status is AtvStatus.STOPPED
    assert calls(rig) == (FORGOTTEN, True)
    assert command(rig, CommandKind.ACKNOWLEDGE).done
    rig.run(rig.now_s + 1.0)
    assert calls(rig) == (FORGOTTEN, False)
    assert command(rig, CommandKind.RESUME).done


def test_its_next_life_stands_also_where_its_body_has_not_heard_of_it() -> None:
    rig = next_life(doubled(), held=False)
    assert instructed(rig.all, Hold) == [Hold()]
    rig.held = True
    rig.run(DOUBLED_S)
    assert last_beat(rig).status is AtvStatus.STOPPED
    assert calls(rig) == (DOUBLED, True)


def test_one_that_a_person_has_stopped_calls_nobody() -> None:
    rig = parked()
    command(rig, CommandKind.STOP)
    rig.run(rig.now_s + DOUBLED_S)
    assert published(rig.all, HelpCall) == []


def test_one_that_drives_on_what_is_not_its_own_calls_until_a_person_has_acknowledged_its_stop() -> None:
    rig = denied()
    rig.run(rig.now_s + 3.0 * DOUBLED_S)
    beat = last_beat(rig)
    assert (beat.status, beat.problem) == (AtvStatus.STOPPED, "")
    assert calls(rig) == (DENIED, True)
    assert command(rig, CommandKind.ACKNOWLEDGE).done
    rig.run(rig.now_s + 1.0)
    assert calls(rig) == (DENIED, False)
    assert command(rig, CommandKind.RESUME).done


def test_its_task_waits_for_that_person_who_may_promise_to_come() -> None:
    rig = denied()
    assert last_beat(rig).help is not None
    rig = parked(traffic=TRAFFIC)
    answer(rig)
    rig.on_message("M8", award())
    assert last_beat(rig).help is None


def test_its_next_life_calls_for_the_same_reason() -> None:
    rig = next_life(denied(), traffic=TRAFFIC)
    rig.run(DOUBLED_S)
    assert calls(rig) == (DENIED, True)
    assert command(rig, CommandKind.ACKNOWLEDGE).done


def test_one_that_has_stopped_itself_gives_its_watch_back_as_one_in_error() -> None:
    rig = parked()
    secondary(rig)
    agent = rig.agent
    assert isinstance(agent, Atv)
    agent.note_denied(rig.now_s)
    assert [said.reason for said in sent(rig.wake(), Resigned)] == [Reason.PROBLEM]


def test_one_that_is_alone_without_right_of_way_stands_stopped_and_calls_as_long_as_it_runs() -> None:
    rig = alone()
    rig.run(rig.now_s + 3.0 * DOUBLED_S)
    beat = last_beat(rig)
    assert (beat.status, beat.problem) == (AtvStatus.STOPPED, ALONE)
    assert calls(rig) == (ALONE, True)
    assert says(rig, "M8-2") == ALONE
    answer = command(rig, CommandKind.ACKNOWLEDGE)
    assert (answer.reason, answer.detail) == (CommandRefusal.FAULTY, ALONE)


def test_one_that_is_alone_is_stopped_once_and_again_when_it_may_drive() -> None:
    rig = alone()
    rig.report(ProblemRaised(reason="a wheel is stuck"))
    ask_holds(rig)
    assert last_beat(rig).problem == "a wheel is stuck"
    assert instructed(rig.all, Hold) == [Hold()]
    rig.report(ProblemCleared())
    assert command(rig, CommandKind.ACKNOWLEDGE).done
    assert command(rig, CommandKind.RESUME).done
    rig.held = False
    ask_holds(rig)
    rig.wake()
    assert instructed(rig.all, Hold) == [Hold(), Hold()]
    assert calls(rig) == (ALONE, True)


def test_its_next_life_that_has_right_of_way_calls_until_a_person_lets_it_go() -> None:
    rig = next_life(alone(), traffic=TRAFFIC, held=False)
    assert instructed(rig.all, Hold) == [Hold()]
    rig.held = True
    rig.run(DOUBLED_S)
    assert last_beat(rig).status is AtvStatus.STOPPED
    assert calls(rig) == (ALONE, True)
    assert says(rig, "M8-2") == ALONE
    assert command(rig, CommandKind.ACKNOWLEDGE).done
    assert command(rig, CommandKind.RESUME).done
    rig.run(rig.now_s + 1.0)
    assert calls(rig) == (ALONE, False)


def test_it_says_why_it_does_not_bid_until_it_is_resumed() -> None:
    rig = doubled()
    rig.run(rig.now_s + 3.0 * DOUBLED_S)
    assert says(rig, "M8-2") == DOUBLED
    assert command(rig, CommandKind.ACKNOWLEDGE).done
    assert says(rig, "M8-3") == DOUBLED, "nobody has stopped it"
    assert command(rig, CommandKind.RESUME).done
    rig.held = False
    command(rig, CommandKind.STOP)
    assert says(rig, "M8-4") == "stopped by an operator"


def test_its_next_life_says_so_too() -> None:
    rig = next_life(doubled())
    assert says(rig, "M8-2") == DOUBLED


def test_a_note_that_names_no_cause_is_of_the_only_one_that_there_was() -> None:
    rig = VehicleRig(incarnation=2)
    rig.held = True
    rig.memory = {WHOLE: AtvMemory(stopped_itself=True)}
    rig.start()
    rig.run(DOUBLED_S)
    assert calls(rig) == (DOUBLED, True)
    assert says(rig, "M8-2") == DOUBLED


def test_a_cause_of_before_a_resume_that_only_the_body_has_heard_is_forgotten() -> None:
    before = doubled()
    rig = VehicleRig(incarnation=2)
    note = committed(before.all)[WHOLE]
    assert isinstance(note, AtvMemory)
    rig.memory = {WHOLE: replace(note, stopped_itself=False)}
    rig.start()
    command(rig, CommandKind.STOP)
    assert says(rig, "M8-2") == "stopped by an operator"
