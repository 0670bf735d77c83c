"""Invariant 6, the other way round: nobody loses a contract without a reason.

Where a carrier is replaced or a goal is taken from its machine, a fault must have touched one of
those who are concerned not long before. So a failure that spreads to others is seen. That a vehicle was asked
to leave is no such fault: it gives its task back itself, or finishes it, and nobody need miss it.
"""

from __future__ import annotations

from fnmatch import fnmatchcase
from typing import NamedTuple

from dray.messages import AtvStatus, Event, Message
from dray.messages.fact import AtvStatusChanged, CarrierChanged, GoalLost
from dray.protocol.leaving import LEAVES
from dray.protocol.strategist import STRATEGIST
from dray_sim.broken import InvariantBroken
from dray_sim.faults import (
    Crashed,
    Fault,
    LinkTrouble,
    LoadShifted,
    MachineBroken,
    PoweredOff,
    RadioCut,
    SentAway,
    VehicleBroken,
    WlanCut,
)

LATER_S = 300.0
"""What a fault has begun is over by then: suspicions, waits for help, and what people do about it."""

HELD_UP_S = 5.0
"""A message that is overtaken, or doubled, comes so much later at most."""

EVERYBODY = ""


class _Spell(NamedTuple):
    """A fault, and when it was there."""

    fault: Fault
    begun_s: float
    ended_s: float
    """Infinity while it is there."""


class Blame:
    """Knows which faults there were, and asks for one when somebody loses a contract."""

    def __init__(self) -> None:
        self._spells: dict[str, _Spell] = {}
        """By id of the fault. A trial has some dozens."""
        self._touched_s: dict[str, float] = {}
        """Until when an agent was in trouble last, or away (`_away`); `EVERYBODY` stands for the network."""
        self._stands: dict[str, None] = {}
        """Vehicles that are stopped or in error, whoever did that to them."""

    def begin(self, name: str, fault: Fault, at_s: float) -> None:
        """A fault has begun."""
        self._spells[name] = _Spell(fault, at_s, float("inf"))
        self._touched_s[_touched(fault)] = float("inf")

    def end(self, name: str, at_s: float) -> None:
        """A fault has ended."""
        fault = self._spells[name].fault
        self._spells[name] = self._spells[name]._replace(ended_s=at_s)
        touched = _touched(fault)
        still = any(_touched(each.fault) == touched and each.ended_s > at_s for each in self._spells.values())
        self._touched_s[touched] = float("inf") if still else at_s

    def may_have_lost(self, sender: str, receiver: str, since_s: float) -> bool:
        """Whether what one agent said to another since then may not have arrived."""
        return any(
            spell.ended_s >= since_s and _can_lose(spell.fault, sender, receiver)
            for spell in self._spells.values()
        )

    def delay_s(self, since_s: float) -> float:
        """How much longer than usual a message since then may have been under way."""
        troubles = [spell.fault for spell in self._spells.values() if spell.ended_s >= since_s]
        return sum(
            fault.latency_s
            + fault.jitter_s
            + (HELD_UP_S if fault.reorder_frac or fault.duplicate_frac else 0.0)
            for fault in troubles
            if isinstance(fault, LinkTrouble)
        )

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
            concerned: tuple[str, ...] = (sender, _away(sender), fact.replaced, fact.carrier)
            if fact.reason == LEAVES:
                concerned = (_away(fact.replaced),)
            if not self._any_in_trouble(concerned, at_s):
                seen = f"{fact.replaced} lost {fact.task} ({fact.reason}), and nothing was wrong with it"
                raise InvariantBroken(6, at_s, seen)
        elif type(fact) is GoalLost:
            concerned = (fact.machine, _away(fact.machine), STRATEGIST, _away(STRATEGIST))
            if not self._any_in_trouble(concerned, at_s):
                seen = f"{fact.machine} lost {fact.goal}, and nothing was wrong with it"
                raise InvariantBroken(6, at_s, seen)

    def _any_in_trouble(self, agents: tuple[str, ...], at_s: float) -> bool:
        return any(
            agent in self._stands or at_s - self._touched_s.get(agent, float("-inf")) < LATER_S
            for agent in (EVERYBODY, *agents)
        )


def _away(agent: str) -> str:
    """What stands for an agent's being away in order: that is trouble to those only who rely on its answers."""
    return f"{agent} away"


def _touched(fault: Fault) -> str:
    return _away(fault.agent) if isinstance(fault, SentAway) else _agent(fault)


def _agent(fault: Fault) -> str:
    """Whom a fault is about; `EVERYBODY` for one that may touch anybody."""
    if isinstance(fault, PoweredOff | Crashed | SentAway | WlanCut | RadioCut):
        return fault.agent
    if isinstance(fault, MachineBroken):
        return fault.machine
    return fault.atv if isinstance(fault, VehicleBroken | LoadShifted) else EVERYBODY


def _can_lose(fault: Fault, sender: str, receiver: str) -> bool:
    if isinstance(fault, LinkTrouble):
        ends = fnmatchcase(sender, fault.sender) and fnmatchcase(receiver, fault.receiver)
        return fault.loss_frac > 0.0 and ends
    if isinstance(fault, RadioCut):
        return False
    return _agent(fault) in (EVERYBODY, sender, receiver)
