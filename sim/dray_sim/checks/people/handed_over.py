"""Invariant 22: a machine makes no piece that it has handed over, or that was taken from it.

Like those of `dray_sim.checks.invariants`, this check hears the strategist and the machines, and takes no part.
"""

from __future__ import annotations

from dray.messages import Event, Message
from dray.messages.fact import GoalLost, PieceMade
from dray_sim.checks.broken import InvariantBroken
from dray_sim.checks.fault_attribution import FaultAttribution

HEARD_WITHIN_S = 60.0
"""Time in which a machine hears that a goal is another's: its strategist answers each of its heartbeats. The piece in
work comes out first."""

LOST_KEPT = 1000
"""Number of lost goals that are remembered: kept pieces are made at once, or not at all."""


class HandedOver:
    """No machine makes a piece of a goal that has gone to another machine.

    Args:
        attribution: tells whether the machine may not have heard of it.
    """

    hears = (Event,)

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
