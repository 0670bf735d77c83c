"""In a run nobody holds on to what was given up."""

from __future__ import annotations

import pytest
from check_kit import PLANT, TASK, event, opened

from dray.body import Hold, Unhold
from dray.messages import Phase, Reason, Role
from dray.messages.fact import (
    AwardAnswered,
    AwardGiven,
    ContractEnded,
    ContractTaken,
    Fact,
    PhaseEntered,
    PieceMade,
)
from dray_sim.checks.broken import InvariantBroken
from dray_sim.checks.fault_attribution import FaultAttribution
from dray_sim.checks.stale_contracts import HEED_S, StaleContracts
from dray_sim.clock.loop import VirtualClock
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.faults import LinkTrouble

TAKEN = ContractTaken(task=TASK, epoch=1, role=Role.PRIMARY, coordinator="M8")
SILENT = AwardAnswered(task=TASK, epoch=1, role=Role.PRIMARY, bidder="ATV2", answer="silent")


class Bound:
    """ATV2 has taken a task of M8, which heard nothing of it and gave up."""

    def __init__(self) -> None:
        self.factory = SimFactory(PLANT, VirtualClock(), seed=1)
        self.attribution = FaultAttribution()
        self.stale = StaleContracts(self.factory, self.attribution)
        for agent, fact in (("M8", opened()), ("ATV2", TAKEN), ("M8", SILENT)):
            self.say(0.0, agent, fact)

    def say(self, at_s: float, agent: str, fact: Fact) -> None:
        self.stale.on_message(at_s, agent, "*", event(agent, fact))

    def wait(self) -> None:
        for second in range(1, int(HEED_S) + 10):
            self.say(float(second), "M1", PieceMade(goal="G", product="pump-p3", made=1))


def test_whoever_holds_on_to_an_award_that_was_given_up_is_noticed() -> None:
    with pytest.raises(InvariantBroken, match=r"invariant 3 .* ATV2 believes to carry M8-1"):
        Bound().wait()


def test_whoever_lets_go_is_free() -> None:
    bound = Bound()
    ended = ContractEnded(task=TASK, epoch=1, role=Role.PRIMARY, reason=Reason.RELEASED)
    bound.say(1.0, "ATV2", ended)
    bound.wait()


def test_whoever_was_asked_again_may_keep_it() -> None:
    bound = Bound()
    given = AwardGiven(task=TASK, epoch=1, role=Role.PRIMARY, bidder="ATV2", rank=1)
    bound.say(1.0, "M8", given)
    bound.wait()


def test_a_release_may_have_been_lost() -> None:
    bound = Bound()
    bound.attribution.begin("F1", LinkTrouble(receiver="ATV2", loss_frac=0.1), 0.5)
    bound.wait()


def test_a_pick_that_is_held_half_way_ends_when_the_vehicle_goes_on() -> None:
    bound = Bound()
    bound.say(0.0, "ATV2", PhaseEntered(task=TASK, epoch=1, phase=Phase.LOADING))
    vehicle = bound.factory.vehicles["ATV2"]
    vehicle.instruct(Hold())
    bound.wait()
    vehicle.instruct(Unhold())
    bound.wait()
    with pytest.raises(InvariantBroken, match=r"invariant 3 .* ATV2 believes to carry M8-1"):
        bound.say(2.0 * HEED_S + 20.0, "M1", PieceMade(goal="G", product="pump-p3", made=1))


def test_the_dead_are_bound_by_nothing() -> None:
    bound = Bound()
    bound.factory.crash("ATV2")
    bound.wait()
