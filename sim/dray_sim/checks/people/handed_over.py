"""Invariant 22: what a machine has handed over it does not make, nor what it was taken from it.

A check like those of `dray_sim.checks.invariants`: it hears what the strategist and the machines say, and takes no part.
"""

from __future__ import annotations

from dray.messages import Event, Message
from dray.messages.fact import GoalLost, PieceMade
from dray_sim.checks.broken import InvariantBroken
from dray_sim.checks.fault_attribution import FaultAttribution

HEARD_WITHIN_S = 60.0
"""Its strategist tells a machine at each of its heartbeats that a goal is another's; the piece in work comes out first."""

LOST_KEPT = 1000
"""Goals that are remembered: what is kept is made at once, or not at all."""


class HandedOver:
    """No machine makes a piece of a goal that is another's by now.

    Args:
        attribution: whether the machine may not have heard of it.
    """

    def __init__(self, attribution: FaultAttribution) -> None:
        self._attribution = attribution
        self._lost: dict[str, float] = {}
        """Goals that were given to others, and when."""

    def on_message(self, at_s: float, sender: str, _address: str, message: Message) -> None:
        """Note one utterance."""
        if type(message) is not Event:
            return
        fact = message.fact
        if type(fact) is GoalLost:
            self._lost[fact.goal] = at_s
            if len(self._lost) > LOST_KEPT:
                del self._lost[next(iter(self._lost))]
        elif type(fact) is PieceMade and fact.goal in self._lost:
            since_s = self._lost[fact.goal]
            givers, attribution = self._attribution.strategists, self._attribution
            if at_s < since_s + HEARD_WITHIN_S or attribution.in_trouble(at_s, sender, *givers):
                return
            if any(attribution.may_have_lost(giver, sender, since_s) for giver in givers):
                return
            seen = f"{sender} has made a piece of {fact.goal}, which is another's since {since_s:.1f} s"
            raise InvariantBroken(22, at_s, seen)
