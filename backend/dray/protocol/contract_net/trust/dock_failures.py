"""Docks at which one carrier after another stands in vain: then the place is at fault, and no vehicle.

    first failure     held against the carrier, as any other: it may be its fault
    second failure    by another carrier, of the same load at the same dock, with no load moved there in between:
                      the place is at fault, and neither failure counts against its vehicle
    third in a row    by one carrier alone, of one task, which nobody else has taken in between: the place or the vehicle
                      is at fault. Its failures count against it, and a person is asked to look all the same

A carrier has failed if it stalls, and then a person is asked to look (`transports.held`); or if it gives back what a
storage has promised, because the dock is held. Such a place knows by itself that its dock is not ready (`dock_door`).
The two do not count together: a dock may be held because others stand there.

One carrier alone, however often it fails, says nothing of a place: it may lie, or be broken. But one that has dropped a
task gets it again only while nobody else takes it: that task waits anyway. Two may lie together. So a carrier for which
a person is to look at a place accuses no other one until such a load has moved there or the person has looked: what it
fails to do at others counts against it. A restarted coordinator begins without prejudice, as in `reliability`.
"""

from __future__ import annotations

from typing import NamedTuple

from dray.messages import Reason
from dray.protocol.runtime.bounded_map import BoundedMap

DOCKS_KEPT = 256
"""Maximum remembered loads at docks: more than one coordinator has transports open. A forgotten one begins anew."""

ALONE = 3
"""Failures in a row by one carrier alone after which a person looks."""

REASONS = (Reason.STALLED, Reason.DOCK_HELD)
"""Reasons for which a carrier stands in vain."""


class Failure(NamedTuple):
    """A carrier that stood at a dock in vain."""

    carrier: str
    task: str


class DockFailures:
    """What one coordinator's carriers have failed to load or to unload, by place and item."""

    def __init__(self) -> None:
        self._last: BoundedMap[tuple[str, str, Reason], Failure] = BoundedMap(DOCKS_KEPT)
        """The last failure, by place, item and reason (`REASONS`)."""
        self._accusers: BoundedMap[tuple[str, str], tuple[str, ...]] = BoundedMap(DOCKS_KEPT)
        """By place and item: the carriers for which a person looks there."""
        self._alone: BoundedMap[tuple[str, str], tuple[Failure, int]] = BoundedMap(DOCKS_KEPT)
        """By place and item: the last failure to load or to unload, and how many such ones there were in a row."""

    def accusers(self, place: str, item: str) -> tuple[str, ...]:
        """The carriers that have failed at a place where a person is to look; empty for none, as far as is known.

        With one alone the place may not be at fault.
        """
        return self._accusers.get((place, item), ())

    def accuses_another(self, carrier: str, place: str) -> bool:
        """Whether a carrier has accused another place, of which nothing is known since."""
        return any(carrier in pair and where != place for (where, _), pair in self._accusers.items())

    def note(self, place: str, item: str, reason: Reason, failure: Failure) -> Failure | None:
        """A carrier has failed to load or to unload an item.

        Returns:
            The failure of another carrier before it, by which the place is at fault. None if there is none.
        """
        key = place, item, reason
        before = self._last.pop(key, None)
        if before is None or before.carrier == failure.carrier:
            self._last[key] = failure
            return None
        if reason is Reason.STALLED:  # Otherwise nobody is asked to look.
            self._accusers[place, item] = before.carrier, failure.carrier
        return before

    def is_alone(self, place: str, item: str, failure: Failure) -> bool:
        """A carrier has stalled. Returns whether a person is to look, because it alone has done so time after time."""
        key = place, item
        last, count = self._alone.pop(key, (failure, 0))
        count = count + 1 if last == failure else 1
        if count < ALONE:
            self._alone[key] = failure, count
            return False
        self._accusers[key] = (failure.carrier,)
        return True

    def forget(self, place: str, item: str) -> None:
        """Such a load has moved at the dock, or a person has looked."""
        for reason in REASONS:
            self._last.pop((place, item, reason), None)
        self._accusers.pop((place, item), None)
        self._alone.pop((place, item), None)
