"""Dwell points: chargers and parking places, shared by vehicles with nobody in the middle.

A vehicle says which dwell point it wants on that dwell point's own key, waits a moment for an objection, and
drives there. Whoever holds or wants the same dwell point listens on that key and objects with its own
claim. Both sides then reach the same verdict alone: who stands there keeps it, else the emptier
battery, else the smaller id. So the cost of finding a place does not grow with the fleet.

Who stands at a charger and has enough leaves it to somebody who needs it more: it says nothing, and drives away.
"""

from __future__ import annotations

from dray.messages.base import Fraction, Id, Message
from dray.messages.kinds import VEHICLES


class DwellPointClaimed(Message, said_by=VEHICLES, signed="atv", frozen=True):
    """I stand in this dwell point, or want to."""

    dwell_point: Id
    atv: Id
    battery_frac: Fraction
    """At the time of the first claim, and less by 15 % once it drives to a charger, so that only somebody who is emptier by what a charge
    is worth turns it round; else it does not change while the claim stands."""
    standing: bool
    """True once it has arrived: it goes when it wants to."""
