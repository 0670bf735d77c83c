"""A table leader's knowledge of vehicles, from heartbeats and requests: which are silent or moving. It grants no rights."""

from __future__ import annotations

from collections.abc import Mapping

import msgspec
from msgspec import UNSET

from dray.messages import AtvHeartbeat, AtvStatus
from dray.messages.floor.traffic import NO_RANK, ROUTE_MAX, PlaceRequested, Rank
from dray.protocol.liveness.suspicion import (
    IDLE_INTERVAL_S,
    LATENESS_MAX_S,
    WORKING_INTERVAL_S,
    bound_s,
    interval_s,
)


class Seen(msgspec.Struct, frozen=True, gc=False):
    """A vehicle's newest report of itself."""

    at_s: float
    """When the report came."""
    holds: tuple[str, ...] = ()
    stands: bool = True
    docked: bool = False
    """Whether it stays where it stands until its work there is done."""
    rank: Rank = NO_RANK
    route: tuple[str, ...] = ()
    """Its node, and the nodes ahead of it."""
    every_s: float = WORKING_INTERVAL_S
    """Heartbeat interval."""
    stuck: bool = False
    """Whether it cannot move until a person helps."""
    said: tuple[int, int] = (0, 0)
    """Its life and the number of its heartbeat: the highest that were heard since it was carried away last."""


class Beat(msgspec.Struct, frozen=True, gc=False):
    """A vehicle's position by its own heartbeat, which is the same for all receivers."""

    at_s: float
    """When the heartbeat came."""
    node: str
    every_s: float
    """Heartbeat interval."""


class Neighbours:
    """The newest report of each vehicle that a replica listens to."""

    def __init__(self) -> None:
        self._beats: dict[str, Beat] = {}
        """Vehicle -> its newest heartbeat, also after `forget`."""
        self._expected_s: dict[str, float] = {}
        """Vehicle -> since when it is listened to."""
        self._seen: dict[str, Seen] = {}
        self._brief: dict[str, Seen] = {}
        """Vehicles whose heartbeats had no traffic fields yet."""
        self._away: dict[str, Seen] = {}
        """Last reports of vehicles that people have carried away. These and older ones count only as a sign of life (`at_s`), unless they
        go on for longer than a message is late: then a thief of the vehicle's certificate has spoken of the far future in its name."""
        self._again_s: dict[str, float] = {}
        """Vehicle of `_away` -> when the first such report came since it was carried away."""

    def on_heartbeat(self, atv: str, seen: Seen) -> None:
        """Note a heartbeat."""
        self._seen[atv] = seen
        self._beats[atv] = Beat(seen.at_s, seen.route[0], seen.every_s)

    def on_vehicle(self, heartbeat: AtvHeartbeat, now_s: float) -> bool:
        """Note a vehicle's heartbeat. Without traffic fields it was shortened for radio, or the vehicle has no right of way.

        Returns:
            Whether it contains news beside its time.
        """
        floor, before = heartbeat.floor, self._seen.get(heartbeat.atv)
        said = (heartbeat.incarnation, heartbeat.seq)
        away = self._away.get(heartbeat.atv)
        if away is not None:
            if said <= away.said and now_s - self._again_s.setdefault(heartbeat.atv, now_s) <= LATENESS_MAX_S:
                # Perhaps a late message. Otherwise the vehicle may be on the floor: no further report is accepted soon.
                self._away[heartbeat.atv] = msgspec.structs.replace(
                    away, at_s=now_s, every_s=interval_s(heartbeat)
                )
                return False
            del self._away[heartbeat.atv]
            self._again_s.pop(heartbeat.atv, None)
        known = before or self._brief.get(heartbeat.atv)
        if known is not None:
            # A late heartbeat, or a thief's, takes nothing back: a report that a later one has refuted stays refuted.
            said = max(said, known.said)
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
        """Note from a request that the vehicle lives, and whether it stands or is docked."""
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
        """Note that the vehicle is listened to from now on."""
        self._expected_s.setdefault(atv, now_s)

    def expected_since_s(self, atv: str) -> float | None:
        """Since when the vehicle is listened to; None when it is not."""
        return self._expected_s.get(atv)

    def forget(self, atv: str) -> None:
        """Forget a vehicle that is listened to no more."""
        self._expected_s.pop(atv, None)
        self._seen.pop(atv, None)
        self._brief.pop(atv, None)
        self._again_s.pop(atv, None)

    def beat_of(self, atv: str) -> Beat | None:
        """A vehicle's newest heartbeat; None when none has come since it was carried away."""
        return self._beats.get(atv)

    def carry_away(self, atv: str, said: tuple[int, int]) -> None:
        """Note a removal: the vehicle's reports up to this heartbeat, by life and number, do not count any more."""
        self._beats.pop(atv, None)
        self._again_s.pop(atv, None)
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
        """A vehicle's newest report, also when it was carried away since, or has sent no traffic fields."""
        return self._seen.get(atv) or self._brief.get(atv) or self._away.get(atv)

    def of(self, atv: str) -> Seen | None:
        """A vehicle's newest report; None when it has sent no traffic fields, or was carried away since."""
        return self._seen.get(atv)

    @property
    def all(self) -> Mapping[str, Seen]:
        """The newest report of each vehicle."""
        return self._seen

    def is_silent(self, atv: str, now_s: float) -> bool:
        """Whether it is unknown when a vehicle moves again: its heartbeats have stopped, or it waits for a person's help."""
        seen = self._seen.get(atv)
        if seen is None:
            since_s = self._expected_s.get(atv, now_s)
            return atv in self._away or now_s - since_s > bound_s(IDLE_INTERVAL_S)
        return seen.stuck or now_s - seen.at_s > bound_s(seen.every_s)


def _is_news(before: Seen, seen: Seen) -> bool:
    """Whether a report changes the prices or refuges of other vehicles."""
    return (
        seen.stands is not before.stands
        or seen.docked is not before.docked
        or seen.stuck is not before.stuck
        or seen.rank != before.rank
        or seen.route != before.route
    )
