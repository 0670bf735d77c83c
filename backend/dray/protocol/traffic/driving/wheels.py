"""Instructions for the body, made from the places that are held; and how early the next places are needed."""

from __future__ import annotations

from collections.abc import Callable
from math import sqrt

from dray.body import Drive, ReleaseWay
from dray.plant.restrictions import Restrictions
from dray.protocol.traffic.driving.reserved_way import ReservedWay

REACTION_S = 0.3
"""Time from a grant to the wheels, and from the wheels to the next request."""

AHEAD_M = 1.0
"""Distance by which places are requested earlier than necessary."""

SOON_S = 0.6
"""Round trip up to which the vehicle's speed is nearly unchanged when the answer comes; on longer ones it has accelerated."""

LEAST_LOOK_S = 0.1
"""Shortest time between two looks at the vehicle's position: less than half a metre at top speed."""

ORDERS_KEPT = 4
"""Newest ways whose reports by the body are understood; no link delays a report longer."""

LEAST_GAP_M = 0.15
"""Shortest distance after which a gap is looked at again; usually half the gap, since it shrinks while the vehicle accelerates."""


class Wheels:
    """The instructions to the body of one vehicle.

    Args:
        top_mps, acceleration_mps2: of the vehicle.
        next_order: numbers ways.
        restrictions: returns the lanes that people have made slow, as far as the vehicle knows.
    """

    def __init__(
        self,
        top_mps: float,
        acceleration_mps2: float,
        next_order: Callable[[], int],
        restrictions: Callable[[], Restrictions],
    ) -> None:
        self._top_mps = top_mps
        self._rate_mps2 = acceleration_mps2
        self._next_order = next_order
        self._restrictions = restrictions
        self._order = 0
        self._driven: tuple[str, ...] = ()
        """The way that the body knows."""
        self.is_finishing = False
        """Whether the body was told to end its way where it stands, and has not reported that yet."""
        self._first: dict[int, int] = {}
        """Order -> the number of its first node, as the reserved way counts nodes; newest orders only."""

    def drive(self, way: ReservedWay, speed_mps: float) -> Drive | ReleaseWay:
        """Drive the base: release more of the way that the body knows, or give another one from the next node on."""
        base, ahead = way.base, way.ahead
        done = len(self._driven) - len(ahead)
        # Compare the number, too: a way that passes a node twice may look like its own end at the first pass.
        if self._is_next(way.passed + 1, done) and self._driven[done:] == ahead:
            return ReleaseWay(order=self._order, released=done + len(base))
        stood = speed_mps == 0.0 and way.past_m <= 0.0
        self._driven = (way.node, *ahead) if stood else ahead
        self._number(way.passed + (0 if stood else 1))
        return Drive(
            order=self._order,
            nodes=self._driven,
            released=len(base) + (1 if stood else 0),
            limits_mps=self._restrictions().limits_on(self._driven),
        )

    def _is_next(self, number: int, index: int) -> bool:
        """Whether node `number` of the reserved way is node `index` of the way that the body knows."""
        return index >= 0 and bool(self._driven) and self._first[self._order] + index == number

    def finish(self, way: ReservedWay) -> Drive:
        """Let the body's way end where the vehicle stands."""
        self._driven = (way.node,)
        self._number(way.passed)
        self.is_finishing = True
        return Drive(order=self._order, nodes=self._driven, released=1)

    def has_more(self, way: ReservedWay) -> bool:
        """Whether the way that the body knows leads on from where it stands."""
        return bool(self._driven) and self._first[self._order] + len(self._driven) - 1 > way.passed

    def forget(self) -> None:
        """The body has lost its way."""
        self._driven, self.is_finishing = (), False

    def number_of(self, order: int, index: int) -> int | None:
        """The number of a reached node, as the reserved way counts them; None for a way that is too old."""
        if order == self._order:
            self.is_finishing = False
        first = self._first.get(order)
        return None if first is None else first + index

    def knows(self, order: int) -> bool:
        """Whether this order is one of the newest."""
        return order in self._first

    def _number(self, first: int) -> None:
        self._order, self.is_finishing = self._next_order(), False
        self._first[self._order] = first
        if len(self._first) > ORDERS_KEPT:
            del self._first[next(iter(self._first))]

    def needs_m(self, speed_mps: float, round_s: float) -> float:
        """Distance to the base's end at which the next place is requested: the braking distance and that driven until the answer."""
        if round_s > SOON_S:
            speed_mps = min(self._top_mps, speed_mps + self._rate_mps2 * (round_s - SOON_S))
        brake_m = speed_mps * speed_mps / (2.0 * self._rate_mps2)
        return brake_m + speed_mps * (round_s + REACTION_S) + AHEAD_M

    def look_in_s(self, way: ReservedWay, speed_mps: float, round_s: float) -> float | None:
        """Shortest time (s) until the vehicle is clear of a place, or needs the next one; None when no look is needed."""
        if way.stands:
            return None
        gaps_m = []
        clear_m = way.next_clear_m()
        if clear_m is not None:
            gaps_m.append(clear_m)
        if way.base_end != way.goal:
            gap_m = way.base_left_m - self.needs_m(speed_mps, round_s)
            if gap_m > 0.0:
                gaps_m.append(max(gap_m / 2.0, LEAST_GAP_M))
        if not gaps_m:
            return None
        gap_m = max(min(gaps_m), 0.0)
        soonest_s = (
            sqrt(speed_mps * speed_mps + 2.0 * self._rate_mps2 * gap_m) - speed_mps
        ) / self._rate_mps2
        return max(soonest_s, gap_m / self._top_mps, LEAST_LOOK_S)
