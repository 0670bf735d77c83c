"""The reserved way of a vehicle: the places behind it that it has not cleared yet, the granted ones, and those it wants next."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import pairwise

from dray.plant.restrictions import Ends
from dray.protocol.traffic.places import STILL_M, Places

NOT_ON_THIS_WAY = 2**31
"""Index for a place that is held, but not needed for this way."""

SHORTEN_AT = 64
"""Maximum nodes kept behind the vehicle."""


class ReservedWay:
    """Nodes of a way with the places that they need. The base, once granted, is always driven and never taken back.

    Args:
        places: the places that each lane needs.
        node: where the vehicle stands, or the last node that it has passed.
        next_node: the end of the lane that it is on; empty when it stands.

    Attributes:
        held: the places that the vehicle holds -> the index of the last node that they are needed for.
    """

    def __init__(self, places: Places, node: str, next_node: str = "") -> None:
        self._places = places
        self._nodes = [node]
        self._at_m = [0.0]
        self._passed = 0
        self._base = 0
        self._forgotten = 0
        """Number of passed nodes that are not kept any more."""
        self._past_m = 0.0
        self.held: dict[str, int] = {places.place_of(node): 0}
        if next_node and next_node != node:
            self.turn_to((node, next_node))
            self._base = 1
            self.held.update(dict.fromkeys(places.needs(node, next_node), 1))

    def again(self, node: str, next_node: str) -> ReservedWay:
        """A way that begins at the vehicle's present position; node numbers continue, and held places are kept (`keep`)."""
        way = ReservedWay(self._places, node, next_node)
        way._forgotten = self.passed
        way.keep(self.held)
        return way

    def keep(self, places: Iterable[str]) -> None:
        """Hold places beyond the way: the body may still drive there on an earlier way."""
        for place in places:
            self.held.setdefault(place, NOT_ON_THIS_WAY)

    def let_go(self) -> bool:
        """Give back the places beyond the way, since the body drives this way now; True when there were any."""
        gone = [place for place, index in self.held.items() if index >= NOT_ON_THIS_WAY]
        for place in gone:
            del self.held[place]
        return bool(gone)

    # --- where it is -----------------------------------------------------------------------------

    @property
    def node(self) -> str:
        """The last node that was passed."""
        return self._nodes[self._passed]

    @property
    def base_end(self) -> str:
        """The last node of the base: where the vehicle will stand if nothing more is granted."""
        return self._nodes[self._base]

    @property
    def goal(self) -> str:
        """The last node of the whole way."""
        return self._nodes[-1]

    @property
    def stands(self) -> bool:
        """Whether the base is driven to its end."""
        return self._passed >= self._base

    @property
    def base(self) -> tuple[str, ...]:
        """The nodes ahead that it may drive to."""
        return tuple(self._nodes[self._passed + 1 : self._base + 1])

    @property
    def ahead(self) -> tuple[str, ...]:
        """All nodes ahead."""
        return tuple(self._nodes[self._passed + 1 :])

    @property
    def beyond(self) -> tuple[str, ...]:
        """The nodes after its base."""
        return tuple(self._nodes[self._base + 1 :])

    def lanes_to(self) -> dict[str, Ends]:
        """Place -> the first lane after the base that needs it, in the order of the way."""
        lanes: dict[str, Ends] = {}
        for lane in pairwise((self.base_end, *self.beyond)):
            for place in self._places.needs(*lane):
                lanes.setdefault(place, lane)
        return lanes

    @property
    def base_left_m(self) -> float:
        """Distance from the vehicle to the end of its base."""
        return max(self._at_m[self._base] - self._at_m[self._passed] - self._past_m, 0.0)

    @property
    def past_m(self) -> float:
        """How far the vehicle is past its last node."""
        return self._past_m

    @property
    def passed(self) -> int:
        """The number of `node`, which is the count of nodes passed so far; the next node has the next number."""
        return self._forgotten + self._passed

    # --- what happens ----------------------------------------------------------------------------

    def turn_to(self, nodes: Sequence[str]) -> None:
        """Replace everything after the base; `nodes[0]` is its end."""
        del self._nodes[self._base + 1 :], self._at_m[self._base + 1 :]
        for node in nodes[1:]:
            self._at_m.append(self._at_m[-1] + self._places.length_m(self._nodes[-1], node))
            self._nodes.append(node)

    def groups(self, within_m: float) -> list[tuple[str, ...]]:
        """The places of the groups after the base that begin within this distance, as far as they lie in one district."""
        wanted: list[tuple[str, ...]] = []
        end, district = self._base, ""
        here_m = self._at_m[self._passed] + self._past_m
        while end + 1 < len(self._nodes) and self._at_m[end] - here_m < within_m:
            last = self._places.group_end(self._nodes, end + 1)
            group = self._needed(end, last)
            if self._places.district_of[group[0]] != (district or self._places.district_of[group[0]]):
                break
            district = self._places.district_of[group[0]]
            wanted.append(group)
            end = last
        return wanted

    def take(self, granted: Iterable[str]) -> bool:
        """Extend the base by every next group that is granted or held in full; True when it has grown."""
        got = {*granted, *self.held}
        before = self._base
        while self._base + 1 < len(self._nodes):
            last = self._places.group_end(self._nodes, self._base + 1)
            if not got.issuperset(self._needed(self._base, last)):
                break
            for index in range(self._base + 1, last + 1):
                for place in self._places.needs(self._nodes[index - 1], self._nodes[index]):
                    self.held[place] = index
            self._base = last
        return self._base > before

    def take_next(self) -> None:
        """Extend the base by the next node alone, even if its group has more."""
        here, self._base = self._nodes[self._base], self._base + 1
        for place in self._places.needs(here, self._nodes[self._base]):
            self.held[place] = self._base

    def pass_next(self) -> None:
        """The vehicle has reached the next node of the base."""
        self._passed += 1
        self._past_m = 0.0
        if self._passed > SHORTEN_AT:
            self._shorten()

    def move(self, past_m: float) -> None:
        """Set how far the vehicle is past its last node."""
        self._past_m = past_m

    def give_back(self) -> bool:
        """Give back the places that the vehicle has cleared; True when there were any."""
        gone = [place for place, index in self.held.items() if self._clear_in_m(place, index) <= STILL_M]
        for place in gone:
            del self.held[place]
        return bool(gone)

    def next_clear_m(self) -> float | None:
        """Distance to drive until the vehicle is clear of a place; None when it clears none on its base."""
        gaps_m = [
            gap_m
            for place, index in self.held.items()
            if index <= self._passed and (gap_m := self._clear_in_m(place, index)) < float("inf")
        ]
        return min(gaps_m, default=None)

    # --- how it is done --------------------------------------------------------------------------

    def _needed(self, start: int, last: int) -> tuple[str, ...]:
        """All places of the lanes between two nodes, in order."""
        needs = self._places.needs
        lanes = zip(self._nodes[start:last], self._nodes[start + 1 : last + 1], strict=True)
        return tuple(dict.fromkeys(place for here, there in lanes for place in needs(here, there)))

    def _clear_in_m(self, place: str, index: int) -> float:
        """Distance to drive until the vehicle is clear of a place; infinite for places ahead, or when the base ends before that."""
        if index > self._passed:
            return float("inf")
        here_m = self._at_m[self._passed] + self._past_m
        node = self._nodes[index]
        if place != node:  # A crossing is clear at the next node where a vehicle may stop, docks included.
            return self._at_m[index] - here_m if self._places.may_stop(node) else float("inf")
        if index >= self._base:
            return float("inf")
        return self._at_m[index] + self._places.clear_m(node, self._nodes[index + 1]) - here_m

    def _shorten(self) -> None:
        """Forget nodes that are passed and clear."""
        first = min((self._passed, *self.held.values()))
        del self._nodes[:first], self._at_m[:first]
        self._forgotten += first
        self._passed -= first
        self._base -= first
        self.held = {
            place: index if index >= NOT_ON_THIS_WAY else index - first for place, index in self.held.items()
        }
