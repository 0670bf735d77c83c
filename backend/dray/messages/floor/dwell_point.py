"""Dwell points: chargers and parking places, which vehicles share without a central agent.

A vehicle claims a dwell point on that dwell point's own key, waits a moment for an objection, and drives there. A vehicle that
holds or wants the same dwell point listens on that key and objects with its own claim. Both sides then reach the same verdict
alone: the vehicle that stands there keeps it, else the one with the emptier battery, else the one with the smaller id. So the
cost of finding a place does not grow with the fleet.

A vehicle at a charger that has enough leaves it to one that needs it more: it says nothing, and drives away.
"""

from __future__ import annotations

from dray.messages.base import Fraction, Id, Message
from dray.messages.kinds import VEHICLES


class DwellPointClaimed(Message, said_by=VEHICLES, signed="atv", frozen=True):
    """I stand in this dwell point, or want to."""

    dwell_point: Id
    atv: Id
    battery_frac: Fraction
    """Battery level at the first claim; it stays the same while the claim stands. Once the vehicle drives to a charger, it is reduced by
    15 %, so that only a much emptier vehicle turns it round."""
    standing: bool
    """Whether it has arrived; then it keeps the dwell point until it leaves."""
