"""What whoever keeps a reservation table tells of vehicles that people have carried away."""

from __future__ import annotations

from dray.messages.base import Count, Id
from dray.messages.fact.base import Fact
from dray.messages.floor.traffic import Places
from dray.messages.kinds import DOCKS


class PlacesFreed(Fact, told_by=DOCKS, frozen=True):
    """A vehicle was carried away: what it held here is free."""

    atv: Id
    number: Count
    """Of the removal (`dray.messages.floor.removal`)."""
    by: Id
    """The person who has said so."""
    places: Places


class PlaceKept(Fact, told_by=DOCKS, frozen=True):
    """A vehicle is being put back: the place is its own, and nobody drives into it."""

    atv: Id
    number: Count
    place: Id
