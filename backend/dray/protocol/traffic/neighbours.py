"""What the leader of reservation tables knows of vehicles, from their heartbeats and requests: who is silent, who moves. Never a right to anything."""

from __future__ import annotations

from collections.abc import Mapping

import msgspec
from msgspec import UNSET

from dray.messages import AtvHeartbeat, AtvStatus
from dray.messages.floor.traffic import NO_RANK, ROUTE_MAX, PlaceRequested, Rank
from dray.protocol.liveness.suspicion import IDLE_INTERVAL_S, WORKING_INTERVAL_S, bound_s, interval_s


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


class Beat(msgspec.Struct, frozen=True, gc=False):
    """Where a vehicle was by its own heartbeat, which is the same for all that hear it."""

    at_s: float
    """When it was heard."""
    node: str
    every_s: float
    """How often it beats."""


class Neighbours:
    """The newest word of each vehicle that a replica listens to."""

    def __init__(self) -> None:
        self._beats: dict[str, Beat] = {}
        """Vehicle -> its newest heartbeat, also of one that is listened to no more."""
        self._expected_s: dict[str, float] = {}
        """Vehicle -> since when it is listened to."""
        self._seen: dict[str, Seen] = {}
        self._brief: dict[str, Seen] = {}
        """Vehicles that have told nothing of traffic yet."""
        self._away: dict[str, Seen] = {}
        """Vehicles that people have carried away, as they were heard last: what they have said until then counts no more."""

    def on_heartbeat(self, atv: str, seen: Seen) -> None:
        """A heartbeat has come."""
        self._seen[atv] = seen
        self._beats[atv] = Beat(seen.at_s, seen.route[0], seen.every_s)

    def on_vehicle(self, heartbeat: AtvHeartbeat, now_s: float) -> bool:
        """A vehicle's heartbeat. One that tells nothing of traffic is shortened for the radio, or drives without right of way.

        Returns:
            Whether it tells something new, beside that it is there.
        """
        floor, before = heartbeat.floor, self._seen.get(heartbeat.atv)
        said = (heartbeat.incarnation, heartbeat.seq)
        away = self._away.get(heartbeat.atv)
        if away is not None:
            if said <= away.said:
                return False
            del self._away[heartbeat.atv]
        every_s = interval_s(heartbeat)
        self._beats[heartbeat.atv] = Beat(now_s, heartbeat.node, every_s)
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
            return True
        self._seen[heartbeat.atv] = seen
        return before is None or _is_news(before, seen)

    def on_request(self, atv: str, request: PlaceRequested, now_s: float) -> None:
        """A vehicle has said what it holds and wants in one district: so it is there, and stands, or does not."""
        before = self._seen.get(atv) or self._brief.get(atv) or Seen(at_s=now_s, every_s=IDLE_INTERVAL_S)
        self._seen[atv] = msgspec.structs.replace(
            before,
            at_s=now_s,
            stands=request.stands,
            docked=request.docked,
            rank=request.rank,
            route=request.avoid[:ROUTE_MAX] if request.avoid and not request.chain else before.route,
        )

    def expect(self, atv: str, now_s: float) -> None:
        """It is listened to from now on."""
        self._expected_s.setdefault(atv, now_s)

    def expected_since_s(self, atv: str) -> float | None:
        """Since when it is listened to; None where it is not."""
        return self._expected_s.get(atv)

    def forget(self, atv: str) -> None:
        """It is listened to no more."""
        self._expected_s.pop(atv, None)
        self._seen.pop(atv, None)
        self._brief.pop(atv, None)

    def beat_of(self, atv: str) -> Beat | None:
        """Where a vehicle was by its newest heartbeat; None where none was heard since it was carried away."""
        return self._beats.get(atv)

    def carry_away(self, atv: str, said: tuple[int, int]) -> None:
        """It was carried away: what it has said up to this heartbeat, by its life and number, counts no more."""
        self._beats.pop(atv, None)
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
            since_s = self._expected_s.get(atv, now_s)
            return atv in self._away or now_s - since_s > bound_s(IDLE_INTERVAL_S)
        return seen.stuck or now_s - seen.at_s > bound_s(seen.every_s)


def _is_news(before: Seen, seen: Seen) -> bool:
    """Whether others' prices or refuges change with it."""
    return (
        seen.stands is not before.stands
        or seen.docked is not before.docked
        or seen.stuck is not before.stuck
        or seen.rank != before.rank
        or seen.route != before.route
    )
