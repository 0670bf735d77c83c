"""Docks at which one carrier after another stands in vain: then the place is at fault, and no vehicle.

    first failure     held against the carrier, as any other: it may be its fault
    second failure    by another carrier, of the same load at the same dock, with no load moved there in between:
                      the place is at fault. Neither failure counts against its vehicle, and a person is asked to
                      look (`transports.held`)

One carrier alone, however often it fails, says nothing of a place: it may lie, or be broken. A restarted coordinator
begins without prejudice, as in `reliability`.
"""

from __future__ import annotations

from typing import NamedTuple

from dray.protocol.runtime.bounded_map import BoundedMap

DOCKS_KEPT = 256
"""Maximum remembered loads at docks: more than one coordinator has transports open. A forgotten one begins anew."""


class Failure(NamedTuple):
    """A carrier that stood at a dock in vain."""

    carrier: str
    task: str


class DockFailures:
    """What one coordinator's carriers have failed to load or to unload, by place and item."""

    def __init__(self) -> None:
        self._last: BoundedMap[tuple[str, str], Failure] = BoundedMap(DOCKS_KEPT)

    def note(self, place: str, item: str, failure: Failure) -> Failure | None:
        """A carrier has failed. Returns the failure of another one before it: the place is at fault; None if there is none."""
        before = self._last.pop((place, item), None)
        if before is None or before.carrier == failure.carrier:
            self._last[place, item] = failure
            return None
        return before

    def forget(self, place: str, item: str) -> None:
        """Such a load has moved at the dock, or a person has looked there."""
        self._last.pop((place, item), None)
