"""The transport of Figure 3 again, on links that lose, repeat and delay one message of it.

One message after the other, of all that are said, is lost or comes a second time later. Whatever it is, the
material arrives once, and in the end nobody is bound. Heartbeats are left alone: each is followed by another.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from makings import making

from dray.messages import (
    AtvHeartbeat,
    Award,
    Confirmed,
    DwellPointClaimed,
    MachineHeartbeat,
    Message,
    Role,
)
from dray.messages.fact import ContractEnded, ContractTaken, TaskClosed
from dray.plant import load_plant
from dray.protocol.machine.machine import Machine
from dray.protocol.runtime.events import Event, Received
from dray.protocol.vehicle.atv import Atv

sys.path.insert(0, str(Path(__file__).parent))
from stage import ScriptedVehicle, ScriptedWorkcell, Stage

UNTIL_S = 400.0
"""Enough for a second attempt from anywhere, and for what is asked again."""

MESSAGES = 16
"""At least as many as the transport takes on a good link."""

LOST = -1.0

LEFT_ALONE = (AtvHeartbeat, MachineHeartbeat, DwellPointClaimed)

STOCK = {"housing": 72, "shaft": 0, "bearing": 120, "impeller": 90, "seal-kit": 120}


class BadStage(Stage):
    """Does something to some of the messages.

    Args:
        faults: by the number of the message, counted from 0 over all that is heard except heartbeats and
            claims of dwell points: how much later it comes a second time, or `LOST`.
    """

    def __init__(self, faults: Mapping[int, float]) -> None:
        self.heard = 0
        self.victims: list[Message] = []
        self.shafts = ScriptedWorkcell(dict(STOCK))
        self._faults = faults
        super().__init__(load_plant("single-track"))

    def _later(self, at_s: float, agent: str, event: Event) -> None:
        if isinstance(event, Received) and not isinstance(event.message, LEFT_ALONE):
            again_s = self._faults.get(self.heard)
            self.heard += 1
            if again_s is not None:
                self.victims.append(event.message)
                if again_s == LOST:
                    return
                super()._later(at_s + again_s, agent, event)
        super()._later(at_s, agent, event)


def play(faults: Mapping[int, float]) -> BadStage:
    """Three vehicles, and M8 that needs shafts once."""
    stage = BadStage(faults)
    for atv, node in (("ATV1", "p4"), ("ATV2", "p3"), ("ATV3", "p1")):
        vehicle = ScriptedVehicle(stage, atv, "light", node, battery_frac=0.9)
        stage.add(Atv(atv, stage.plant, vehicle_type="light"), vehicle)
    stage.add(Machine("M8", stage.plant), stage.shafts)
    goal = making("gear-unit-g2", 24, "O1", plant=stage.plant)
    award = Award(task="G8", epoch=1, role=Role.PRIMARY, work=goal, deadline_s=3600.0)
    stage.say("STRAT", "M8", award, at_s=10.0)
    stage.say("STRAT", "M8", Confirmed(task="G8", epoch=1), at_s=10.02)
    stage.run(until_s=UNTIL_S)
    return stage


def check(stage: BadStage) -> None:
    """The load is there once, the task has ended, and nobody is bound by it."""
    closed = [fact for _, fact in stage.facts if isinstance(fact, TaskClosed)]
    assert [(fact.task, fact.outcome) for fact in closed] == [("M8-1", "delivered")], stage.victims
    assert stage.shafts.stock["shaft"] == 40, stage.victims
    taken = [agent for agent, fact in stage.facts if isinstance(fact, ContractTaken) and agent != "M8"]
    ended = [agent for agent, fact in stage.facts if isinstance(fact, ContractEnded)]
    assert sorted(taken) == sorted(ended), stage.victims


def test_on_a_good_link_every_message_is_among_those_that_are_tried() -> None:
    stage = play({})
    assert 10 < stage.heard <= MESSAGES
    check(stage)


@pytest.mark.parametrize("again_s", [LOST, 0.005, 0.5, 3.0, 30.0])
@pytest.mark.parametrize("number", range(MESSAGES))
def test_whichever_message_is_lost_or_doubled_the_load_arrives_once_and_nobody_stays_bound(
    number: int, again_s: float
) -> None:
    check(play({number: again_s}))


@pytest.mark.campaign
@settings(deadline=None, derandomize=True, max_examples=300)
@given(
    st.dictionaries(st.integers(0, 2 * MESSAGES), st.sampled_from([LOST, LOST, 0.005, 0.5, 3.0]), max_size=10)
)
def test_on_a_link_that_loses_and_doubles_much_it_is_the_same(faults: dict[int, float]) -> None:
    check(play(faults))
