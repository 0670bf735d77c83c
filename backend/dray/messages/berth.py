"""Berths: chargers and parking places, shared by vehicles with nobody in the middle.

A vehicle claims a berth before it drives there and repeats the claim as a lease. When two want the
same one, the emptier battery keeps it, then the smaller id: both sides reach the same verdict alone.
"""

from __future__ import annotations

from dray.messages.base import Message


class BerthClaimed(Message):
    """I am standing in this berth or driving to it. Published to all vehicles."""

    berth: str
    atv: str
    battery_frac: float
    """At the time of the first claim: it does not change while the claim stands."""
    standing: bool
    """True once it has arrived: an occupant is never driven out."""
    until_s: float
    """The lease: forgotten then, unless repeated (plant clock)."""


class BerthFreed(Message):
    """I have left this berth, or given up my claim."""

    berth: str
    atv: str
