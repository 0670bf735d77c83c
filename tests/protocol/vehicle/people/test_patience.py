"""How long a task waits for its carrier's problem: by its kind, its deadline and what others have seen (paper, case 4)."""

from __future__ import annotations

from math import inf

import pytest
from defaults import PLANT
from effects import facts, listening, published, sent
from rigs import VehicleRig
from seals import granted
from spoken import award
from watches import GOODS, beat, carrying, claims, guard, newest

from dray.body import ProblemCleared, ProblemRaised
from dray.messages import (
    AtvStatus,
    CommandAnswered,
    CommandKind,
    CommandRefusal,
    DockOpened,
    HelpWanted,
    Problem,
    ProblemEnded,
    ProblemKind,
    VehicleCommand,
)
from dray.messages.fact import HelpAsked
from dray.protocol.people.patience import (
    HALF_LIFE_S,
    LONGEST_S,
    PATIENCE_MAX_S,
    PATIENCE_MIN_S,
    Experience,
    room_s,
)

DRIVE = Problem(kind=ProblemKind.DRIVE)
LOAD = Problem(kind=ProblemKind.LOAD)


def ended(problem: Problem, lasted_s: float, atv: str = "ATV2") -> ProblemEnded:
    return ProblemEnded(agent=atv, problem=problem, lasted_s=lasted_s)


def raised(rig: VehicleRig, problem: Problem, reason: str = "it stands") -> float:
    """How long its task waits then (s)."""
    rig.report(ProblemRaised(reason=reason, problem=problem))
    wanted = newest(rig).help
    assert wanted is not None
    return wanted.until_s - rig.now_s


def test_a_dead_drive_is_handed_over_at_once_and_a_person_is_asked_all_the_same() -> None:
    rig = carrying()
    assert raised(rig, DRIVE) == 0.0
    assert newest(rig).about_problem == DRIVE
    [asked] = facts(rig.all, HelpAsked)
    assert (asked.task, asked.problem) == ("M8-1", DRIVE)


def test_a_secondary_takes_over_at_once_from_one_that_does_not_wait() -> None:
    rig = guard()
    beat(rig, 2, status=AtvStatus.ERROR, problem="no drive", help=HelpWanted(until_s=rig.now_s))
    rig.run(rig.now_s)
    assert len(claims(rig)) == 1


@pytest.mark.parametrize(
    ("problem", "waits"),
    [
        (Problem(), True),
        (LOAD, True),
        (Problem(kind=ProblemKind.WAY_BLOCKED), True),
        (Problem(kind=ProblemKind.BATTERY), False),
        (Problem(kind=ProblemKind.DRIVE, passes=True), True),
        (Problem(kind=ProblemKind.SENSOR, passes=False, needs_person=False), False),
    ],
)
def test_what_a_body_knows_decides_whether_its_task_waits(problem: Problem, waits: bool) -> None:
    assert raised(carrying(), problem) == (PATIENCE_MAX_S if waits else 0.0)


def test_where_such_problems_last_longer_than_the_deadline_allows_nobody_waits() -> None:
    rig = VehicleRig()
    rig.start()
    rig.on_message("M8", award(deadline_s=rig.now_s + 90.0))
    rig.run(80.0)
    assert raised(rig, LOAD) == 0.0


def test_goods_on_board_wait_for_their_carrier_whatever_is_wrong_with_it() -> None:
    rig = carrying_goods()
    assert raised(rig, DRIVE) > 0.0
    answer = told(rig, CommandKind.HAND_OVER)
    assert answer.reason is CommandRefusal.LOAD_ABOARD


def test_a_person_who_promises_to_come_counts_above_the_kind() -> None:
    rig = carrying()
    assert raised(rig, DRIVE) == 0.0
    assert told(rig, CommandKind.PROMISE, wait_s=120.0).done
    assert newest(rig).help == HelpWanted(until_s=rig.now_s + 120.0, promised_by="operator north")
    # What its body finds out meanwhile changes nothing of that.
    assert raised(rig, Problem(kind=ProblemKind.BATTERY)) == 120.0


def test_a_person_who_says_that_it_cannot_be_mended_there_lets_the_task_go() -> None:
    rig = carrying()
    assert told(rig, CommandKind.HAND_OVER).reason is CommandRefusal.NOT_WAITING
    assert raised(rig, LOAD) == PATIENCE_MAX_S
    assert told(rig, CommandKind.PROMISE, wait_s=300.0).done
    assert told(rig, CommandKind.HAND_OVER).done
    assert newest(rig).help == HelpWanted(until_s=rig.now_s)


def test_a_vehicle_tells_all_how_long_its_problem_has_lasted() -> None:
    rig = carrying()
    assert f"{PLANT.id}/problem/*" in listening(rig.all)
    rig.report(ProblemRaised(reason="a box", problem=LOAD))
    rig.run(40.0)
    rig.report(ProblemCleared())
    assert published(rig.all, ProblemEnded) == [ended(LOAD, 40.0, "ATV1")]
    rig.report(ProblemRaised(reason="something"))
    rig.report(ProblemCleared())
    assert len(published(rig.all, ProblemEnded)) == 1, "of words alone nobody learns"


def test_what_others_have_seen_changes_what_is_waited_for() -> None:
    rig = carrying()
    for atv in ("ATV2", "ATV3"):
        rig.on_message(atv, ended(LOAD, 900.0, atv))
    assert raised(rig, LOAD) == 0.0


def test_one_that_lies_moves_nothing_that_others_have_seen() -> None:
    experience = Experience()
    for number in range(3):
        experience.note(ended(LOAD, 60.0), f"ATV{number}", 0.0)
    for _ in range(100):
        experience.note(ended(LOAD, LONGEST_S), "liar", 0.0)
    assert experience.usual_s(LOAD, 0.0) <= 90.0


def test_drives_that_are_mended_quickly_are_waited_for_and_that_is_forgotten() -> None:
    experience = Experience()
    assert experience.usual_s(DRIVE, 0.0) == LONGEST_S
    for number in range(3):
        experience.note(ended(DRIVE, 40.0), f"ATV{number}", 0.0)
    assert experience.usual_s(DRIVE, 0.0) == 40.0
    assert experience.usual_s(Problem(kind=ProblemKind.DRIVE, passes=True), 0.0) < PATIENCE_MIN_S + 1.0
    assert experience.usual_s(DRIVE, 4.0 * HALF_LIFE_S) == LONGEST_S


def test_there_is_as_much_room_as_the_deadline_or_a_takeover_would_take() -> None:
    assert room_s(-50.0, 0.0) == PATIENCE_MIN_S
    assert room_s(100.0, 0.0) == 100.0
    assert room_s(-50.0, 80.0) == 80.0
    assert room_s(0.0, inf) == PATIENCE_MAX_S


def carrying_goods() -> VehicleRig:
    """ATV1 with finished goods on board."""
    rig = VehicleRig()
    rig.start()
    rig.on_message("M8", award(work=GOODS, deadline_s=3600.0))
    rig.arrive()
    rig.on_message("M8", DockOpened(task="M8-1", epoch=1, station="M8"))
    rig.picked()
    assert rig.load[0] == GOODS.item
    return rig


def told(rig: VehicleRig, kind: CommandKind, wait_s: float | None = None) -> CommandAnswered:
    command = VehicleCommand(command=f"C{len(rig.all)}", kind=kind, wait_s=wait_s, issued_by="operator north")
    [answer] = sent(rig.on_message("operator-north", granted("ATV1", command)), CommandAnswered)
    return answer
