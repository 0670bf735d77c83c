"""Invariants 6 and 7: a check that could not be broken would prove nothing."""

from __future__ import annotations

import pytest
from check_kit import heartbeat

from dray.messages import (
    AtvStatus,
    Event,
    Message,
    Phase,
    Reason,
    Role,
    Transport,
)
from dray.messages.fact import (
    AtvStatusChanged,
    AwardAnswered,
    CarrierChanged,
    ContractEnded,
    ContractTaken,
    Fact,
    PhaseEntered,
    TaskClosed,
    TaskOpened,
    TookOver,
)
from dray.plant import default_plant
from dray_sim.checks.broken import InvariantBroken
from dray_sim.checks.isolation import ReplacedInTime, SpeaksOn
from dray_sim.clock.loop import VirtualClock
from dray_sim.factory.sim_factory import SimFactory

TASK = "M8-1"


class Watched:
    """A factory that does not run, and the two checks."""

    def __init__(self) -> None:
        self.factory = SimFactory(default_plant(), VirtualClock(), seed=1)
        self.now_s = 0.0
        self._checks = (SpeaksOn(self.factory), ReplacedInTime(self.factory))

    def say(self, sender: str, said: Fact | Message) -> None:
        message = said
        if isinstance(said, Fact):
            message = Event(agent=sender, incarnation=1, number=1, at_s=self.now_s, fact=said)
        assert isinstance(message, Message)
        for check in self._checks:
            check.on_message(self.now_s, sender, "*", message)

    def wait(self, seconds: int) -> None:
        """Let time pass; M1 is heard all the while."""
        for _ in range(seconds):
            self.now_s += 1.0
            self.say("M1", ended("M1-9"))

    def contract(self, goal: str = "") -> None:
        """ATV3 carries a task of M8, and ATV1 watches it."""
        work = Transport(
            item="shaft", quantity=40, sources=("S3",), destination="M8", ability="tote", goal=goal
        )
        opened = TaskOpened(
            task=TASK,
            epoch=1,
            role=Role.PRIMARY,
            round=1,
            work=work,
            radius_m=25.0,
            deadline_s=100.0,
            bids_until_s=1.0,
        )
        self.say("M8", opened)
        answered = AwardAnswered(task=TASK, epoch=1, role=Role.PRIMARY, bidder="ATV3", answer="accepted")
        self.say("M8", answered)
        self.say("ATV1", ContractTaken(task=TASK, epoch=1, role=Role.SECONDARY, coordinator="M8"))


def ended(task: str) -> ContractEnded:
    return ContractEnded(task=task, epoch=1, role=Role.SECONDARY, reason=Reason.RELEASED)


@pytest.fixture
def watched() -> Watched:
    return Watched()


def test_whoever_runs_and_is_silent_is_noticed(watched: Watched) -> None:
    watched.say("ATV1", heartbeat("ATV1"))
    watched.wait(6)
    with pytest.raises(InvariantBroken, match=r"invariant 6 .* ATV1 runs and has said nothing"):
        watched.wait(1)


def test_whoever_is_dead_may_be_silent(watched: Watched) -> None:
    watched.say("ATV1", heartbeat("ATV1"))
    watched.factory.crash("ATV1")
    watched.wait(60)


def test_a_dead_primary_that_nobody_replaces_is_noticed(watched: Watched) -> None:
    watched.contract()
    watched.factory.crash("ATV3")
    watched.wait(int(ReplacedInTime.BOUND_S))
    with pytest.raises(InvariantBroken, match=r"invariant 7 .* ATV3 is dead .* ATV1"):
        watched.wait(2)


def test_a_takeover_in_time_is_right(watched: Watched) -> None:
    watched.contract()
    watched.factory.crash("ATV3")
    watched.wait(4)
    took_over = TookOver(task=TASK, epoch=2, primary="ATV3", silent_s=3.5, reason=Reason.SILENT)
    watched.say("ATV1", took_over)
    watched.wait(60)


def test_so_is_a_new_auction(watched: Watched) -> None:
    watched.contract()
    watched.factory.crash("ATV3")
    watched.wait(4)
    watched.say("M8", CarrierChanged(task=TASK, epoch=2, replaced="ATV3", carrier="", reason=Reason.SILENT))
    watched.wait(60)


def test_a_second_primary_that_dies_is_noticed_too(watched: Watched) -> None:
    watched.contract()
    taken = CarrierChanged(task=TASK, epoch=2, replaced="ATV3", carrier="ATV2", reason=Reason.SILENT)
    watched.say("M8", taken)
    watched.say("ATV1", ContractTaken(task=TASK, epoch=2, role=Role.SECONDARY, coordinator="M8"))
    watched.factory.crash("ATV2")
    with pytest.raises(InvariantBroken, match="ATV2 is dead"):
        watched.wait(30)


def test_a_secondary_of_an_earlier_epoch_watches_somebody_else(watched: Watched) -> None:
    watched.contract()
    watched.say("ATV2", TookOver(task=TASK, epoch=2, primary="ATV3", silent_s=3.5, reason=Reason.SILENT))
    watched.factory.crash("ATV2")
    watched.wait(60)


@pytest.mark.parametrize("status", [AtvStatus.STOPPED, AtvStatus.ERROR])
def test_a_secondary_that_cannot_drive_is_not_asked_for_it(watched: Watched, status: AtvStatus) -> None:
    watched.contract()
    watched.say("ATV1", AtvStatusChanged(status=status))
    watched.factory.crash("ATV3")
    watched.wait(60)
    watched.say("ATV1", AtvStatusChanged(status=AtvStatus.IDLE))
    with pytest.raises(InvariantBroken, match="invariant 7"):
        watched.wait(30)


def test_a_watch_that_was_given_back_binds_nobody(watched: Watched) -> None:
    watched.contract()
    watched.say("ATV1", ended(TASK))
    watched.factory.crash("ATV3")
    watched.wait(60)


def test_neither_does_one_whose_holder_died_too(watched: Watched) -> None:
    watched.contract()
    watched.factory.crash("ATV3")
    watched.factory.crash("ATV1")
    watched.wait(60)


def test_goods_on_board_are_waited_for(watched: Watched) -> None:
    watched.contract(goal="G1")
    watched.say("ATV3", PhaseEntered(task=TASK, epoch=1, phase=Phase.CARRYING))
    watched.factory.crash("ATV3")
    watched.wait(60)


def test_material_on_board_is_fetched_again(watched: Watched) -> None:
    watched.contract()
    watched.say("ATV3", PhaseEntered(task=TASK, epoch=1, phase=Phase.CARRYING))
    watched.factory.crash("ATV3")
    with pytest.raises(InvariantBroken, match="invariant 7"):
        watched.wait(30)


def test_a_task_that_has_ended_needs_nobody(watched: Watched) -> None:
    watched.contract()
    watched.factory.crash("ATV3")
    watched.say("M8", TaskClosed(task=TASK, epoch=1, outcome="withdrawn", carrier="ATV3"))
    watched.wait(60)
