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
    said: tuple[int, int] = (0, 0)
    """Its life, and the number of the heartbeat."""


class Neighbours:
    """The newest word of each vehicle.

    Attributes:
        holders: place -> who has said last that it holds it.
        announced: lane, by its ends -> how many vehicles mean to drive it soon.
    """

    def __init__(self) -> None:
        self._seen: dict[str, Seen] = {}
        self._brief: dict[str, Seen] = {}
        """Vehicles that have told nothing of traffic yet."""
        self._away: dict[str, Seen] = {}
        """Vehicles that people have carried away, as they were heard last: what they have said until then counts no more."""
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
        said = (heartbeat.incarnation, heartbeat.seq)
        away = self._away.get(heartbeat.atv)
        if away is not None:
            if said <= away.said:
                return
            del self._away[heartbeat.atv]
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
                said=said,
            )
        elif before is not None:
            seen = msgspec.structs.replace(before, at_s=now_s, every_s=every_s, stuck=stuck, said=said)
        else:
            self._brief[heartbeat.atv] = Seen(at_s=now_s, route=(heartbeat.node,), every_s=every_s, said=said)
            return
        self.on_heartbeat(heartbeat.atv, seen)

    def carry_away(self, atv: str, said: tuple[int, int]) -> None:
        """It was carried away: what it has said up to this heartbeat, by its life and number, counts no more."""
        seen = self._seen.get(atv)
        brief = self._brief.get(atv)
        if brief is not None and brief.said <= said:
            del self._brief[atv]
        if seen is None:
            before = self._away.get(atv)
            if before is None or before.said < said:
                route = before.route if before is not None else ()
                self._away[atv] = Seen(at_s=float("-inf"), said=said, route=route)
        elif seen.said <= said:
            del self._seen[atv]
            self._forget_holds(atv, seen)
            self.announced.subtract(pairwise(seen.route[:NEAR_NODES]))
            self._away[atv] = msgspec.structs.replace(seen, said=said)

    def last(self, atv: str) -> Seen | None:
        """What a vehicle has said last, also of one that was carried away since, or has told nothing of traffic."""
        return self._seen.get(atv) or self._brief.get(atv) or self._away.get(atv)

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
        if seen is None:
            return atv in self._away
        return seen.stuck or now_s - seen.at_s > bound_s(seen.every_s)

    def _forget_holds(self, atv: str, seen: Seen) -> None:
        for place in seen.holds:
            if self.holders.get(place) == atv:
                del self.holders[place]
