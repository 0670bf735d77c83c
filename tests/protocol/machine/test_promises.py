"""A machine moves the promises of its goals when the goals before them change, and not for anything else."""

from __future__ import annotations

import pytest
from effects import committed, facts, sent
from m7 import FULL, NO_HOUSINGS, m7
from rigs import MachineRig
from seals import granted
from spoken import production

from dray.body import Broken, Repaired
from dray.messages import (
    Accepted,
    Confirmed,
    GoalRevised,
    HolderChanged,
    MachineCommand,
    MachineCommandKind,
    Reason,
    Withdrawn,
)
from dray.messages.fact import PromiseMoved

CYCLE_S = 50.0

GOAL_S = 24 * CYCLE_S


def busy() -> MachineRig:
    """M7 with one goal of 24 pumps, due in an hour; promised in 1,200 s."""
    return m7(FULL, goal=24)


def moved(rig: MachineRig) -> list[PromiseMoved]:
    return facts(rig.all, PromiseMoved)


def urgent(rig: MachineRig, goal: str, quantity: int = 6, deadline_s: float = 600.0) -> list[PromiseMoved]:
    """A more urgent goal comes; which promises it has moved."""
    work = production(quantity=quantity, order=f"O-{goal}")
    return facts(rig.take_goal(goal, work, deadline_s), PromiseMoved)


def test_a_more_urgent_goal_moves_the_promise_of_the_one_behind_it() -> None:
    rig = busy()
    assert moved(rig) == []
    assert urgent(rig, "G2") == [PromiseMoved("G1", GOAL_S + 6 * CYCLE_S, 1)]


def test_a_later_goal_moves_no_promise_and_its_own_is_the_one_that_it_was_given_with() -> None:
    rig = busy()
    assert urgent(rig, "G2", deadline_s=7200.0) == []


def test_all_goals_that_came_before_it_are_counted_also_those_that_moved_too_little() -> None:
    rig = busy()
    assert urgent(rig, "G2", quantity=1) == []
    assert urgent(rig, "G3") == [PromiseMoved("G1", GOAL_S + 7 * CYCLE_S, 2)]
    # The same award again is no other goal.
    rig.take_goal("G3", production(quantity=6, order="O-G3"), 600.0)
    assert len(moved(rig)) == 1
    assert urgent(rig, "G4") == [PromiseMoved("G1", GOAL_S + 13 * CYCLE_S, 3)]


def test_a_promise_that_is_far_away_moves_by_a_twentieth_of_its_time_at_least() -> None:
    rig = m7(FULL, goal=240)
    assert urgent(rig, "G2", quantity=12) == []
    assert [each.goal for each in urgent(rig, "G3", quantity=24)] == ["G1"]


def test_nothing_is_moved_by_time_or_pieces() -> None:
    rig = busy()
    urgent(rig, "G2")
    rig.run(900.0)
    rig.cycles(3)
    rig.run(1800.0)
    assert len(moved(rig)) == 1


def test_a_goal_that_is_made_moves_nothing_when_it_ends() -> None:
    rig = busy()
    urgent(rig, "G2", quantity=2)
    rig.run(900.0)
    rig.cycles(3)
    before = len(moved(rig))
    rig.on_message("STRATEGIST", Withdrawn("G2", 1, Reason.NOT_NEEDED))
    assert len(moved(rig)) == before


def test_a_promise_moves_back_when_a_goal_before_it_is_withdrawn() -> None:
    rig = busy()
    urgent(rig, "G2")
    rig.now_s = 10.0
    effects = rig.on_message("STRATEGIST", Withdrawn("G2", 1, Reason.NOT_NEEDED))
    assert facts(effects, PromiseMoved) == [PromiseMoved("G1", 10.0 + GOAL_S, 1)]


def test_a_goal_that_becomes_less_urgent_lets_others_pass_it() -> None:
    rig = busy()
    urgent(rig, "G2", deadline_s=4000.0)
    effects = rig.on_message("STRATEGIST", GoalRevised("G1", 1, 24, 5000.0))
    assert facts(effects, PromiseMoved) == [
        PromiseMoved("G2", 6 * CYCLE_S, 0),
        PromiseMoved("G1", GOAL_S + 6 * CYCLE_S, 1),
    ]


def test_an_award_that_is_not_confirmed_moves_nothing() -> None:
    rig = busy()
    rig.award_goal("G2", production(quantity=6, order="O2"), 600.0)
    assert moved(rig) == []
    [told] = facts(rig.confirm_goal("G2"), PromiseMoved)
    assert told.goal == "G1"


def test_a_breakdown_moves_no_promise_by_itself_until_its_goals_are_taken_up_again() -> None:
    rig = busy()
    rig.report(Broken(reason="oil"))
    rig.run(rig.now_s + 100.0)
    assert moved(rig) == []
    rig.run(rig.now_s + 2000.0)
    assert moved(rig) == []
    rig.report(Repaired())
    assert [(each.goal, each.came_before) for each in moved(rig)] == [("G1", 0)]


def test_the_next_life_keeps_the_promises_and_what_came_before() -> None:
    rig = busy()
    urgent(rig, "G2")
    next_life = MachineRig("M7", rig.stock, incarnation=2)
    next_life.memory, next_life.now_s = committed(rig.all), rig.now_s
    next_life.start()
    assert moved(next_life) == []
    [again] = [each for each in sent(next_life.all, Accepted) if each.task == "G1"]
    assert again.finish_s == GOAL_S + 6 * CYCLE_S
    assert [(each.goal, each.came_before) for each in urgent(next_life, "G3")] == [("G1", 2)]


@pytest.mark.parametrize("stock", [FULL, NO_HOUSINGS])
def test_a_confirmation_or_another_holder_moves_nothing(stock: dict[str, int]) -> None:
    rig = m7(stock, goal=24)
    rig.on_message("STRATEGIST", Confirmed(task="G1", epoch=1, arrived=0))
    rig.on_message("STRATEGIST2", HolderChanged("O1", 2))
    assert moved(rig) == []


# --- a speed that a person sets ---------------------------------------------------------------------


def set_speed(rig: MachineRig, speed_frac: float) -> list[PromiseMoved]:
    """A person sets the machine's speed; which promises that has moved."""
    command = MachineCommand(
        command=f"C{len(rig.all)}",
        kind=MachineCommandKind.SET_SPEED,
        speed_frac=speed_frac,
        issued_by="Maria",
    )
    return facts(rig.on_message("gateway", granted("M7", command)), PromiseMoved)


def test_a_speed_that_a_person_sets_moves_the_promises_of_all_its_goals_and_back() -> None:
    rig = busy()
    urgent(rig, "G2")
    assert set_speed(rig, 0.5) == [
        PromiseMoved("G2", 2.0 * 6 * CYCLE_S, 0),
        PromiseMoved("G1", 2.0 * (GOAL_S + 6 * CYCLE_S), 1),
    ]
    assert set_speed(rig, 0.5) == []
    assert [each.finish_s for each in set_speed(rig, 1.0)] == [6 * CYCLE_S, GOAL_S + 6 * CYCLE_S]


def test_a_speed_that_is_set_a_little_lower_moves_no_promise() -> None:
    assert set_speed(busy(), 0.97) == []


def test_the_next_life_knows_that_the_speed_was_set_before() -> None:
    rig = busy()
    assert set_speed(rig, 0.5)
    rig.now_s = 400.0
    next_life = MachineRig("M7", rig.stock, incarnation=2)
    next_life.memory, next_life.now_s = committed(rig.all), rig.now_s
    next_life.start()
    assert urgent(next_life, "G2", quantity=1, deadline_s=7200.0) == []
    assert moved(next_life) == []
