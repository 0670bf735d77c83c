"""A vehicle that has stopped because another one used its name calls people until one has seen to it."""

from __future__ import annotations

from atv1 import command, last_beat, parked
from effects import committed, instructed, published
from rigs import VehicleRig

from dray.body import Hold, ProblemCleared, ProblemRaised
from dray.messages import AtvStatus, CallState, CommandKind, CommandRefusal, HelpCall
from dray.protocol.vehicle.atv import Atv
from dray.protocol.vehicle.people.problem_handling import DOUBLED, DOUBLED_S


def doubled() -> VehicleRig:
    """ATV1, which has just been answered what it has not said."""
    rig = parked()
    agent = rig.agent
    assert isinstance(agent, Atv)
    agent.problems.note_doubled(rig.now_s)
    rig.held = True
    rig.wake()
    return rig


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
    before = doubled()
    rig = VehicleRig(incarnation=2)
    rig.held = True
    rig.memory = committed(before.all)
    rig.start()
    rig.run(DOUBLED_S)
    assert calls(rig) == (DOUBLED, True)
    assert command(rig, CommandKind.ACKNOWLEDGE).done


def test_its_next_life_stands_also_where_its_body_has_not_heard_of_it() -> None:
    before = doubled()
    rig = VehicleRig(incarnation=2)
    rig.memory = committed(before.all)
    rig.start()
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
