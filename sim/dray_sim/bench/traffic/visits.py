"""The central planner's reservations: places for a time, and the hops of a plan.

A hop leads from a node where a vehicle may stop to the next one: one lane, or all lanes through a crossing of two-lane roads.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from math import inf

from dray.plant import Plant
from dray.protocol.traffic.places import Places

LONGEST_HOP = 8
"""Lanes: no crossing has more in a row."""


@dataclass(slots=True, eq=False)
class Visit:
    """A place, held by a vehicle for a time.

    Attributes:
        done: the vehicle has held it and is through.
        nodes: those that are driven to get there, itself included.
        crossed: the crossings that are held on the way there.
    """

    place: str
    atv: str
    from_s: float
    until_s: float
    done: bool = False
    nodes: tuple[str, ...] = ()
    crossed: list[Visit] = field(default_factory=list)

    @property
    def group(self) -> tuple[Visit, ...]:
        """All that is taken at once."""
        return (*self.crossed, self)


class Hops:
    """Hops from each node where a vehicle may stop to the next such nodes.

    Args:
        plant: the lanes.
        places: that the lanes need.
    """

    def __init__(self, plant: Plant, places: Places) -> None:
        self._plant, self._places = plant, places
        self._known: dict[str, tuple[tuple[str, ...], ...]] = {}

    def leaving(self, node: str) -> tuple[tuple[str, ...], ...]:
        """The hops that begin at a node, by the nodes on each; only the shortest one to each end."""
        known = self._known.get(node)
        if known is None:
            best: dict[str, tuple[float, tuple[str, ...]]] = {}
            self._follow((node,), 0.0, best)
            known = self._known[node] = tuple(nodes for _, nodes in best.values())
        return known

    def crossed(self, start: str, nodes: Iterable[str]) -> tuple[str, ...]:
        """The crossings that a hop needs."""
        found: dict[str, None] = {}
        for node in nodes:
            found.update(dict.fromkeys(place for place in self._places.needs(start, node) if place != node))
            start = node
        return tuple(found)

    def _follow(
        self, path: tuple[str, ...], so_far_m: float, best: dict[str, tuple[float, tuple[str, ...]]]
    ) -> None:
        for lane in self._plant.roads.leaving[path[-1]]:
            if lane.end in path or len(path) > LONGEST_HOP:
                continue
            there, length_m = (*path, lane.end), so_far_m + lane.length_m
            if not self._places.may_stop(lane.end):
                self._follow(there, length_m, best)
            elif lane.end not in best or length_m < best[lane.end][0]:
                best[lane.end] = length_m, there[1:]


class Step:
    """One hop of a plan."""

    __slots__ = ("arrive_s", "before", "end", "leave_s", "nodes", "start", "until_s")

    def __init__(
        self,
        start: str,
        nodes: tuple[str, ...],
        leave_s: float,
        arrive_s: float,
        until_s: float,
        before: Step | None,
    ) -> None:
        self.start, self.nodes, self.end, self.before = start, nodes, nodes[-1], before
        self.leave_s, self.arrive_s, self.until_s = leave_s, arrive_s, until_s


def first_free_s(spans: list[tuple[float, float]], from_s: float, lasts_s: float) -> float:
    """The first moment from which something is free for so long; infinite when there is none."""
    return next(
        (max(from_s, begin_s) for begin_s, end_s in spans if max(from_s, begin_s) + lasts_s <= end_s),
        inf,
    )


def free_spans(visits: list[Visit]) -> list[tuple[float, float]]:
    """The times between visits."""
    spans: list[tuple[float, float]] = []
    from_s = -inf
    for visit in sorted(visits, key=lambda one: one.from_s):
        if visit.from_s > from_s:
            spans.append((from_s, visit.from_s))
        from_s = max(from_s, visit.until_s)
    spans.append((from_s, inf))
    return spans
