"""What is known of other vehicles' traffic from their heartbeats: hints for prices and refuges, and never a right to anything."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from itertools import pairwise

import msgspec
from msgspec import UNSET

from dray.messages import AtvHeartbeat, AtvStatus
from dray.messages.traffic import NO_RANK, ROUTE_MAX, Rank
from dray.protocol.liveness.suspicion import WORKING_INTERVAL_S, bound_s, interval_s

SILENT_S = bound_s(WORKING_INTERVAL_S)
"""A keeper of books beats once a second: who was not heard for so long is counted as silent."""

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
    every_s: float = WORKING_INTERVAL_S
    """How often it beats."""
    stuck: bool = False
    """It stands until a person has seen to it."""


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

    def on_vehicle(self, heartbeat: AtvHeartbeat, now_s: float) -> None:
        """A vehicle's heartbeat. One that tells nothing of traffic is shortened for the radio, or drives without right of way."""
        floor, before = heartbeat.floor, self._seen.get(heartbeat.atv)
        every_s = interval_s(heartbeat)
        stuck = heartbeat.status in (AtvStatus.ERROR, AtvStatus.STOPPED)
        if floor is not UNSET:
            seen = Seen(
                at_s=now_s,
                holds=floor.holds,
                stands=floor.stands,
                docked=floor.docked,
                rank=floor.rank,
                route=(heartbeat.node, *heartbeat.way)[:ROUTE_MAX],
                every_s=every_s,
                stuck=stuck,
            )
        elif before is not None:
            seen = msgspec.structs.replace(before, at_s=now_s, every_s=every_s, stuck=stuck)
        else:
            return
        self.on_heartbeat(heartbeat.atv, seen)

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
        """Whether nobody knows when a vehicle moves again: it was not heard for a while, or stands until a person has seen to it."""
        seen = self._seen.get(atv)
        return seen is not None and (seen.stuck or now_s - seen.at_s > bound_s(seen.every_s))

    def _forget_holds(self, atv: str, seen: Seen) -> None:
        for place in seen.holds:
            if self.holders.get(place) == atv:
                del self.holders[place]
