"""What is known of other vehicles' traffic from their heartbeats: hints for prices and refuges, and never a right to anything."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from itertools import pairwise

import msgspec

from dray.messages.traffic import NO_RANK, Rank
from dray.protocol.liveness.suspicion import bound_s

SILENT_S = bound_s(1.0)
"""Who beats once a second and was not heard for so long is counted as silent: others go round it."""

NEAR_NODES = 12
"""So far ahead a vehicle's way counts as announced traffic: what it does later may change."""


class Seen(msgspec.Struct, frozen=True, gc=False):
    """What one vehicle has said of itself last."""

    at_s: float
    """When it was heard."""
    holds: tuple[str, ...] = ()
    stands: bool = True
    docked: bool = False
    """It stays where it stands until its work is done there."""
    rank: Rank = NO_RANK
    route: tuple[str, ...] = ()
    """The nodes ahead of it; the first one is where it is."""


class Neighbours:
    """The newest word of each vehicle.

    Attributes:
        holders: place -> who has said last that it holds it.
        announced: lane, by its ends -> how many vehicles mean to drive it soon.
    """

    def __init__(self) -> None:
        self._seen: dict[str, Seen] = {}
        self.holders: dict[str, str] = {}
        self.announced: Counter[tuple[str, str]] = Counter()

    def on_heartbeat(self, atv: str, seen: Seen) -> None:
        """A heartbeat has come."""
        before = self._seen.get(atv)
        if before is not None:
            if seen.holds != before.holds:
                self._forget_holds(atv, before)
            if seen.route != before.route:
                self.announced.subtract(pairwise(before.route[:NEAR_NODES]))
                self.announced.update(pairwise(seen.route[:NEAR_NODES]))
        else:
            self.announced.update(pairwise(seen.route[:NEAR_NODES]))
        for place in seen.holds:
            self.holders[place] = atv
        self._seen[atv] = seen

    def forget(self, atv: str) -> None:
        """Somebody has carried it away."""
        seen = self._seen.pop(atv, None)
        if seen is not None:
            self._forget_holds(atv, seen)
            self.announced.subtract(pairwise(seen.route[:NEAR_NODES]))

    def of(self, atv: str) -> Seen | None:
        """What a vehicle has said last."""
        return self._seen.get(atv)

    @property
    def all(self) -> Mapping[str, Seen]:
        """The newest word of each."""
        return self._seen

    def is_silent(self, atv: str, now_s: float) -> bool:
        """Whether a vehicle that has spoken was not heard for a while."""
        seen = self._seen.get(atv)
        return seen is not None and now_s - seen.at_s > SILENT_S

    def _forget_holds(self, atv: str, seen: Seen) -> None:
        for place in seen.holds:
            if self.holders.get(place) == atv:
                del self.holders[place]
