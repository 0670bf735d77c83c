"""Facts of a table's replicas about vehicles that people have carried away."""

from __future__ import annotations

from dray.messages.base import Count, Id
from dray.messages.fact.base import Fact
from dray.messages.floor.traffic import Places
from dray.messages.kinds import DOCKS
from dray.messages.reason import RemovalRefusal


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


class RemovalRefused(Fact, told_by=DOCKS, frozen=True):
    """A replica that keeps places for the vehicle does not believe the report. Recorded once for each report and reason.

    In the first minute every report is refused, because the vehicle may still be sending; that is recorded only if it lasts. A report
    without a trusted signature is recorded at most once a minute for each vehicle.
    """

    atv: Id
    number: Count
    reason: RemovalRefusal
