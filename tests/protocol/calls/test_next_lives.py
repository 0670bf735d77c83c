"""A problem that may pass by itself gets its time once: an agent that is started again and again calls all the same."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from effects import committed, published
from rigs import MachineRig, VehicleRig

from dray.body import Broken, ProblemCleared, ProblemRaised, Repaired
from dray.messages import HelpCall, Problem, ProblemKind
from dray.protocol.people.patience import PASSES_AT_FIRST_S

JAM = Problem(kind=ProblemKind.JAM, passes=True)
LOST = Problem(kind=ProblemKind.LOST_POSITION, passes=True)

Rig = MachineRig | VehicleRig
Life = Callable[[int], Rig]
"""An agent of a life, not started yet."""

LIVES = (lambda life: VehicleRig(incarnation=life), lambda life: MachineRig(incarnation=life))

agents = pytest.mark.parametrize("of", LIVES, ids=["vehicle", "machine"])


def stands(rig: Rig, problem: Problem) -> None:
    """Its body has a problem."""
    rig.about = problem
    if isinstance(rig, VehicleRig):
        rig.problem = "it stands"
    else:
        rig.broken = "it stands"


def begins(rig: Rig, problem: Problem) -> None:
    """Its body has a problem from now on, and says so."""
    stands(rig, problem)
    kind = ProblemRaised if isinstance(rig, VehicleRig) else Broken
    rig.report(kind("it stands", problem))


def next_life(of: Life, before: Rig, life: int, problem: Problem) -> Rig:
    rig = of(life)
    rig.memory, rig.now_s = committed(before.all), before.now_s
    stands(rig, problem)
    rig.start()
    return rig


def calls(rig: Rig) -> list[HelpCall]:
    return published(rig.all, HelpCall)


@agents
def test_a_next_life_waits_only_for_what_is_left(of: Life) -> None:
    rig = of(1)
    rig.start()
    begins(rig, JAM)
    rig.run(rig.now_s + 0.5 * PASSES_AT_FIRST_S)
    rig = next_life(of, rig, 2, JAM)
    rig.run(rig.now_s + 0.4 * PASSES_AT_FIRST_S)
    assert not calls(rig)
    rig.run(rig.now_s + 0.2 * PASSES_AT_FIRST_S)
    assert calls(rig)


@agents
def test_a_problem_that_began_between_two_lives_counts_from_the_second_one(of: Life) -> None:
    rig = of(1)
    stands(rig, JAM)
    rig.start()
    for life in (2, 3):
        rig.run(rig.now_s + 0.4 * PASSES_AT_FIRST_S)
        assert not calls(rig)
        rig = next_life(of, rig, life, JAM)
    rig.run(rig.now_s + 0.3 * PASSES_AT_FIRST_S)
    assert calls(rig)


@agents
@pytest.mark.parametrize(
    ("is_over", "then"),
    [(False, LOST), (True, JAM)],
    ids=["another problem", "the same one, after it was over"],
)
def test_a_new_problem_of_the_next_life_gets_a_time_of_its_own(
    of: Life, is_over: bool, then: Problem
) -> None:
    rig = of(1)
    rig.start()
    begins(rig, JAM)
    rig.run(rig.now_s + 0.9 * PASSES_AT_FIRST_S)
    if is_over:
        rig.report(ProblemCleared() if isinstance(rig, VehicleRig) else Repaired())
    rig = next_life(of, rig, 2, then)
    rig.run(rig.now_s + 0.9 * PASSES_AT_FIRST_S)
    assert not calls(rig)
