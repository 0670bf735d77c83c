"""Invariant 6, the other way round: nobody loses a contract without a reason.

Where a carrier is replaced or a goal is taken from its machine, a fault must have touched one of
those who are concerned not long before. So a failure that spreads to others is seen.
"""

from __future__ import annotations

from dray.messages import AtvStatus, Event, Message
from dray.messages.fact import AtvStatusChanged, CarrierChanged, GoalLost
from dray.protocol.strategist import STRATEGIST
from dray_sim.broken import InvariantBroken
from dray_sim.faults import (
    Crashed,
    Fault,
    LoadShifted,
    MachineBroken,
    PoweredOff,
    VehicleBroken,
)

LATER_S = 300.0
"""What a fault has begun is over by then: suspicions, waits for help, and what people do about it."""

EVERYBODY = ""


class Blame:
    """Knows which faults there were, and asks for one when somebody loses a contract."""

    def __init__(self) -> None:
        self._active: dict[str, int] = {}
        self._touched_s: dict[str, float] = {}
        """Until when an agent was in trouble last; `EVERYBODY` stands for the network."""
        self._stands: dict[str, None] = {}
        """Vehicles that are stopped or in error, whoever did that to them."""

    def begin(self, fault: Fault) -> None:
        """A fault has begun."""
        agent = _agent(fault)
        self._active[agent] = self._active.get(agent, 0) + 1

    def end(self, fault: Fault, at_s: float) -> None:
        """A fault has ended."""
        agent = _agent(fault)
        self._active[agent] -= 1
        self._touched_s[agent] = at_s

    def hear(self, at_s: float, sender: str, _address: str, message: Message) -> None:
        """Look for what lost contracts are due to.

        Raises:
            InvariantBroken: nothing was wrong with anybody.
        """
        if type(message) is not Event:
            return
        fact = message.fact
        if type(fact) is AtvStatusChanged:
            if fact.status in (AtvStatus.STOPPED, AtvStatus.ERROR):
                self._stands[sender] = None
            elif self._stands.pop(sender, "") is None:
                self._touched_s[sender] = at_s
        elif type(fact) is CarrierChanged:
            if not self._any_in_trouble((sender, fact.replaced, fact.carrier), at_s):
                seen = f"{fact.replaced} lost {fact.task} ({fact.reason}), and nothing was wrong with it"
                raise InvariantBroken(6, at_s, seen)
        elif type(fact) is GoalLost:
            if not self._any_in_trouble((fact.machine, STRATEGIST), at_s):
                seen = f"{fact.machine} lost {fact.goal}, and nothing was wrong with it"
                raise InvariantBroken(6, at_s, seen)

    def _any_in_trouble(self, agents: tuple[str, ...], at_s: float) -> bool:
        return any(
            self._active.get(agent, 0) > 0
            or agent in self._stands
            or at_s - self._touched_s.get(agent, float("-inf")) < LATER_S
            for agent in (EVERYBODY, *agents)
        )


def _agent(fault: Fault) -> str:
    """Whom a fault touches; a fault of the network may touch anybody."""
    if isinstance(fault, PoweredOff | Crashed):
        return fault.agent
    if isinstance(fault, MachineBroken):
        return fault.machine
    return fault.atv if isinstance(fault, VehicleBroken | LoadShifted) else EVERYBODY
