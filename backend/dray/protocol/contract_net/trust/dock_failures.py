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

from dataclasses import dataclass, field
from enum import Enum
from typing import NamedTuple

from dray.messages import Reason
from dray.protocol.runtime.bounded_map import BoundedMap

DOCKS_KEPT = 256
"""Maximum remembered loads at docks: more than one coordinator has transports open. A forgotten one begins anew."""

ALONE = 3
"""Failures in a row by one carrier alone after which a person looks."""


class Failure(NamedTuple):
    """A carrier that stood at a dock in vain."""

    carrier: str
    task: str


class Fault(Enum):
    """Who is at fault, as far as is known."""

    CARRIER = "carrier"
    """The carrier is charged."""
    EITHER = "either"
    """The carrier is charged, and a person is to look."""
    PLACE = "place"
    """Nobody is charged. If carriers have stalled there, a person is to look."""


@dataclass(slots=True)
class _Dock:
    """What is known of one item at one place."""

    last: dict[Reason, Failure] = field(default_factory=dict)
    """The last failure for each reason."""
    stalled: Failure | None = None
    """The last failure by stalling; None once a person is to look because of it."""
    in_a_row: int = 0
    """How many such ones there were."""
    accusers: tuple[str, ...] = ()
    """The carriers for which a person is to look."""


class DockFailures:
    """What one coordinator's carriers have failed to load or to unload, by place and item."""

    def __init__(self) -> None:
        self._docks: BoundedMap[tuple[str, str], _Dock] = BoundedMap(DOCKS_KEPT)

    def accusers(self, place: str, item: str) -> tuple[str, ...]:
        """The carriers that have failed at a place where a person is to look; empty for none, as far as is known.

        With one alone the place may not be at fault.
        """
        dock = self._docks.get((place, item))
        return dock.accusers if dock is not None else ()

    def note(
        self, place: str, item: str, reason: Reason, failure: Failure, *, believed: bool
    ) -> tuple[Fault, Failure | None]:
        """A carrier has failed to load or to unload an item: it has stalled, or was kept waiting.

        Args:
            place: where it stood.
            item: the item.
            reason: `STALLED` or `DOCK_HELD`.
            failure: the carrier, and its task.
            believed: whether its word counts beside another carrier's.

        Returns:
            Who is at fault; and the failure of another carrier before it, by which the place is at fault, if any.
        """
        has_stalled = reason is Reason.STALLED
        if has_stalled and self._accuses_another(failure.carrier, place):
            return Fault.CARRIER, None
        dock = self._docks.pop((place, item), None) or _Dock()
        self._docks[place, item] = dock
        fault = Fault.CARRIER
        if has_stalled:
            dock.in_a_row = dock.in_a_row + 1 if dock.stalled == failure else 1
            dock.stalled = failure
            if dock.in_a_row >= ALONE:
                fault, dock.stalled, dock.accusers = Fault.EITHER, None, (failure.carrier,)
        if not believed:
            return fault, None
        before = dock.last.pop(reason, None)
        if before is None or before.carrier == failure.carrier:
            dock.last[reason] = failure
            return fault, None
        if has_stalled:  # Otherwise nobody is asked to look.
            dock.accusers = before.carrier, failure.carrier
        return Fault.PLACE, before

    def forget(self, place: str, item: str) -> None:
        """Such a load has moved at the dock, or a person has looked."""
        self._docks.pop((place, item), None)

    def _accuses_another(self, carrier: str, place: str) -> bool:
        """Whether a carrier has accused another place, of which nothing is known since."""
        return any(carrier in dock.accusers and where != place for (where, _), dock in self._docks.items())
