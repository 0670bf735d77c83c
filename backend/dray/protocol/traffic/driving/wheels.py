"""From places that are held to instructions for the body, and how early the next ones are needed."""

from __future__ import annotations

from collections.abc import Callable
from math import sqrt

from dray.body import Drive, ReleaseWay
from dray.plant.restrictions import Restrictions
from dray.protocol.traffic.driving.reserved_way import ReservedWay

REACTION_S = 0.3
"""From a grant to the wheels, and back from the wheels to the request."""

AHEAD_M = 1.0
"""Asked for earlier than it must be."""

SOON_S = 0.6
"""Within this an answer finds the vehicle at the speed at which it has asked, or nearly; later it has got faster meanwhile."""

LEAST_LOOK_S = 0.1
"""Between two looks at where the vehicle is: less than half a metre at the highest speed."""

ORDERS_KEPT = 4
"""Reports of older ways than that are late beyond any reason."""

LEAST_GAP_M = 0.15
"""A gap that shrinks while the vehicle gets faster is looked at again after half of it, and not after less than this."""


class Wheels:
    """What the body of one vehicle is told.

    Args:
        top_mps, acceleration_mps2: of the vehicle.
        next_order: numbers ways.
        restrictions: which lanes people have made slow, as far as the vehicle knows now.
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
        """The way as the body knows it."""
        self.is_finishing = False
        """The body was told to end its way where it stands, and has not said that it has."""
        self._first: dict[int, int] = {}
        """Order -> the number of its first node, as the reserved way counts nodes; the newest orders only."""

    def drive(self, way: ReservedWay, speed_mps: float) -> Drive | ReleaseWay:
        """Drive the base: more of the way that the body knows, or another one from the next node on."""
        base, ahead = way.base, way.ahead
        done = len(self._driven) - len(ahead)
        # By number, too: a way that passes a node twice is like its own end at the first time.
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
        """Whether a node of the reserved way, by its number, is the one with an index in the way that the body knows."""
        return index >= 0 and bool(self._driven) and self._first[self._order] + index == number

    def finish(self, way: ReservedWay) -> Drive:
        """End the way that the body knows where it stands."""
        self._driven = (way.node,)
        self._number(way.passed)
        self.is_finishing = True
        return Drive(order=self._order, nodes=self._driven, released=1)

    def has_more(self, way: ReservedWay) -> bool:
        """Whether the body knows of more to drive than where it stands."""
        return bool(self._driven) and self._first[self._order] + len(self._driven) - 1 > way.passed

    def forget(self) -> None:
        """The body has lost its way."""
        self._driven, self.is_finishing = (), False

    def number_of(self, order: int, index: int) -> int | None:
        """The number of a node that the body has reached, as the reserved way counts them; None for a way of old."""
        if order == self._order:
            self.is_finishing = False
        first = self._first.get(order)
        return None if first is None else first + index

    def knows(self, order: int) -> bool:
        """Whether a way of this number was given lately."""
        return order in self._first

    def _number(self, first: int) -> None:
        self._order, self.is_finishing = self._next_order(), False
        self._first[self._order] = first
        if len(self._first) > ORDERS_KEPT:
            del self._first[next(iter(self._first))]

    def needs_m(self, speed_mps: float, round_s: float) -> float:
        """How near the end of the base may be before the next place is asked for: braking, and the way until an answer comes."""
        if round_s > SOON_S:
            speed_mps = min(self._top_mps, speed_mps + self._rate_mps2 * (round_s - SOON_S))
        brake_m = speed_mps * speed_mps / (2.0 * self._rate_mps2)
        return brake_m + speed_mps * (round_s + REACTION_S) + AHEAD_M

    def look_in_s(self, way: ReservedWay, speed_mps: float, round_s: float) -> float | None:
        """When the vehicle may be clear of a place at the earliest, or need the next one; None when it need not be looked at."""
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
