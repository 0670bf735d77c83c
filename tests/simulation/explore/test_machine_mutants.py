"""The search finds machines that keep what they have handed over, or work out of service; see `test_mutants`."""

from __future__ import annotations

import pytest
from mutants import Find, Mutant

from dray.messages import Award, Release, TaskAnnounced, Withdrawn
from dray.protocol.machine.cycle import Cycle
from dray.protocol.machine.goal_bidding import GoalBidder
from dray.protocol.machine.machine import Machine
from dray.protocol.machine.production import Goal, GoalBook
from dray_sim.explore.run import draw


def with_machines_that_bid_out_of_service(patch: pytest.MonkeyPatch) -> None:
    """A machine says that it is out of service, and takes goals as ever."""
    unfit = Machine._unfit

    def fit(self: Machine, asked: TaskAnnounced | Award) -> str:
        why = unfit(self, asked)
        return "" if why == "out of service" else why

    patch.setattr(Machine, "_unfit", fit)


def with_machines_that_work_out_of_service(patch: pytest.MonkeyPatch) -> None:
    """A machine offers its goals, and goes on with them all the same."""
    patch.setattr(GoalBook, "at_work", lambda self: self.confirmed())


def with_goals_that_are_handed_over_and_kept(patch: pytest.MonkeyPatch) -> None:
    """A machine makes all of a goal that its strategist has given to another, before it lets go of it."""
    on_over = GoalBidder.on_over

    def keep(self: GoalBidder, message: Release | Withdrawn) -> Goal | None:
        goal = self._goals.get(message.task)
        if isinstance(message, Withdrawn) and goal is not None and goal.to_make > 0:
            goal.given_back_s = None
            return None
        return on_over(self, message)

    patch.setattr(GoalBidder, "on_over", keep)


def with_machines_that_never_rest(patch: pytest.MonkeyPatch) -> None:
    """A machine goes on, whatever its working time is."""
    patch.setattr(Cycle, "look", lambda _self, _now_s: None)


@pytest.mark.campaign
def test_the_search_finds_a_machine_that_never_rests(find: Find) -> None:
    find(with_machines_that_never_rest, lambda seed: draw(seed, "rests"), 1, "invariant 25")


@pytest.mark.campaign
@pytest.mark.parametrize(
    ("mutant", "first", "finding"),
    [
        pytest.param(with_machines_that_bid_out_of_service, 1, "invariant 16", id="bids-out-of-service"),
        pytest.param(with_machines_that_work_out_of_service, 1, "invariant 16", id="works-out-of-service"),
        pytest.param(with_goals_that_are_handed_over_and_kept, 76, "invariant 22", id="handed-over-and-kept"),
    ],
)
def test_the_search_finds_a_mutant_of_machines(mutant: Mutant, first: int, finding: str, find: Find) -> None:
    find(mutant, lambda seed: draw(seed, "machines"), first, finding)
