"""Facts of a table's leader about vehicles that people have carried away."""

from __future__ import annotations

from dray.messages.base import Count, Id
from dray.messages.fact.base import Fact
from dray.messages.floor.traffic import Places
from dray.messages.kinds import DOCKS


class PlacesFreed(Fact, told_by=DOCKS, frozen=True):
    """A vehicle was carried away: the places that it held here are free."""

    atv: Id
    number: Count
    """Number of the removal (`dray.messages.floor.removal`)."""
    by: Id
    """The person who has reported it."""
    places: Places


class PlaceKept(Fact, told_by=DOCKS, frozen=True):
    """A vehicle is being put back: the place is reserved for it, and no other vehicle drives into it."""

    atv: Id
    number: Count
    place: Id
