"""A vehicle's knowledge of the traffic around it, as prices of places: replicas' reports of other vehicles, and its own recent waits.

Prices are hints only: a wrong one leads to a longer way.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from itertools import pairwise

from dray.messages.floor.traffic import Blocked, OnFloor, PlaceGranted, Rank
from dray.plant.restrictions import OPEN, Ends, Restrictions
from dray.protocol.traffic.surroundings import Surroundings

OBSTRUCTED_S = 300.0
"""Price of a lane with an obstacle: as for a silent vehicle, any other way is taken."""

STANDS_S, DOCKED_S, SILENT_S = 3.0, 12.0, 300.0
"""Prices of a place whose holder stands, is docked, or is silent."""

WAIT_HALF_S = 30.0
"""Half-life of the vehicle's own waits."""

TELL_S = {Blocked.WAIT: STANDS_S, Blocked.DOCKED: DOCKED_S, Blocked.SILENT: SILENT_S}
"""Added to the price of a place that, by an answer of the table, is blocked like this."""

TOLD_COUNTS_S = 20.0
"""Time for which such an answer counts in prices."""


class Prices:
    """The prices that are added to lane times at one moment.

    Args:
        others: the other known vehicles.
        waits_s: place -> the vehicle's own recent waits there, from `Waits`.
        told_s: place -> price from an answer of its table.
        restrictions: what people have closed.
        obstructed: lanes with an obstacle.
    """

    def __init__(
        self,
        others: Mapping[str, OnFloor],
        *,
        waits_s: Mapping[str, float] | None = None,
        told_s: Mapping[str, float] | None = None,
        restrictions: Restrictions = OPEN,
        obstructed: frozenset[Ends] = frozenset(),
    ) -> None:
        self.admits = restrictions.admits if restrictions.nodes or restrictions.lanes else None
        """Returns whether a lane, by its ends, may be entered; None when nothing is closed."""
        self.obstructed = obstructed
        self._announced: Counter[tuple[str, str]] = Counter()
        """Lane, by its ends -> number of others that will drive it soon."""
        self.place_s: dict[str, float] = {}
        for seen in others.values():
            self._announced.update(pairwise(seen.route))
            if seen.silent:
                price_s = SILENT_S
            elif seen.docked:
                price_s = DOCKED_S
            elif seen.stands:
                price_s = STANDS_S
            else:
                continue
            for place in seen.holds:
                self.place_s[place] = max(self.place_s.get(place, 0.0), price_s)
        for more_s in (waits_s, told_s):
            for place, price_s in (more_s or {}).items():
                self.place_s[place] = self.place_s.get(place, 0.0) + price_s

    def oncoming(self, start: str, end: str) -> int:
        """Number of others that will drive a lane the other way."""
        return self._announced[end, start]


class Waits:
    """A vehicle's recent waits by place; each counts half after `WAIT_HALF_S`."""

    def __init__(self) -> None:
        self._waited: dict[str, tuple[float, float]] = {}

    def add(self, place: str, waited_s: float, now_s: float) -> None:
        """Add a wait for a place."""
        self._waited[place] = (self._of(place, now_s) + waited_s, now_s)

    def all(self, now_s: float) -> dict[str, float]:
        """Place -> seconds of waiting that still count."""
        waits_s = {place: self._of(place, now_s) for place in self._waited}
        for place, wait_s in waits_s.items():
            if wait_s < 0.5:
                del self._waited[place]
        return waits_s

    def _of(self, place: str, now_s: float) -> float:
        waited_s, at_s = self._waited.get(place, (0.0, now_s))
        left: float = 0.5 ** ((now_s - at_s) / WAIT_HALF_S)
        return waited_s * left


class Outlook:
    """One vehicle's knowledge of traffic.

    Args:
        surroundings: the reports of other vehicles.
        restrictions: returns what people have closed, as far as the vehicle knows.
        obstructed: returns the lanes with an obstacle, likewise.
    """

    def __init__(
        self,
        surroundings: Surroundings,
        restrictions: Callable[[], Restrictions],
        obstructed: Callable[[], frozenset[Ends]],
    ) -> None:
        self._restrictions, self._obstructed = restrictions, obstructed
        self._surroundings = surroundings
        self._waits = Waits()
        self._told: dict[str, tuple[float, float]] = {}
        """Place -> its price from an answer of its table, and until when that counts."""

    def note(self, granted: PlaceGranted, now_s: float) -> None:
        """Note the place that a table's answer names as blocked."""
        price_s = TELL_S.get(granted.blocked)
        if granted.at and price_s is not None:
            self._told[granted.at] = (price_s, now_s + TOLD_COUNTS_S)

    def waited(self, place: str, waited_s: float, now_s: float) -> None:
        """Note that the vehicle has waited for a place."""
        self._waits.add(place, waited_s, now_s)

    def prices(self, now_s: float) -> Prices:
        """The present prices."""
        self._told = {place: told for place, told in self._told.items() if told[1] > now_s}
        told_s = {place: price_s for place, (price_s, _) in self._told.items()}
        return Prices(
            self._surroundings.others(now_s),
            waits_s=self._waits.all(now_s),
            told_s=told_s,
            restrictions=self._restrictions(),
            obstructed=self._obstructed(),
        )

    def holders(self, chain: tuple[str, ...], rank: Rank, now_s: float) -> tuple[set[str], set[str]]:
        """Places that a vehicle which makes room for `chain` with this rank cannot get, and those whose holders would make room."""
        forbidden: set[str] = set()
        taken: set[str] = set()
        for other, seen in self._surroundings.others(now_s).items():
            fixed = other in chain or seen.docked or seen.silent or (seen.stands and seen.rank < rank)
            (forbidden if fixed else taken).update(seen.holds)
        for place, (price_s, until_s) in self._told.items():
            if price_s >= DOCKED_S and until_s > now_s:
                forbidden.add(place)
        return forbidden, taken
