"""Least lane time to one node, from any distance that is asked for.

A vehicle asks about near nodes. In a plant of 13,000 nodes a search that ends at the start of the question visits
some hundred of them. Its results are kept, and the next question goes on from there.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from heapq import heappop, heappush
from math import inf
from typing import Any, Generic, TypeVar

N = TypeVar("N", bound=Any)
"""Type of the nodes' names: any type with an order."""

Neighbours = Callable[[N], Iterable[tuple[N, float]]]
"""The nodes from which lanes lead to one (or to which they lead from there), and their times in seconds."""


class LaneTimes(Generic[N]):
    """Least lane times between one node and all others.

    Args:
        node: the one.
        neighbours: of each.
    """

    __slots__ = ("_frontier", "_neighbours", "_order", "_settled_s")

    def __init__(self, node: N, neighbours: Neighbours[N]) -> None:
        self._neighbours = neighbours
        self._settled_s: dict[N, float] = {}
        self._order: list[N] = []
        """Settled nodes, nearest first."""
        self._frontier: list[tuple[float, N]] = [(0.0, node)]

    def __call__(self, node: N) -> float:
        """Seconds; infinite where no way leads."""
        found_s = self._settled_s.get(node)
        if found_s is not None:
            return found_s
        while self._settle_one():
            if self._order[-1] == node:
                return self._settled_s[node]
        return inf

    def nearest_first(self) -> Iterator[tuple[N, float]]:
        """All nodes that lanes lead to, and their times. Others may ask for times meanwhile."""
        number = 0
        while number < len(self._order) or self._settle_one():
            node = self._order[number]
            yield node, self._settled_s[node]
            number += 1

    def _settle_one(self) -> bool:
        """Find the nearest node that is not settled; False where there is none."""
        settled_s, frontier = self._settled_s, self._frontier
        while frontier:
            least_s, node = heappop(frontier)
            if node in settled_s:
                continue
            settled_s[node] = least_s
            self._order.append(node)
            for other, lane_s in self._neighbours(node):
                if other not in settled_s:
                    heappush(frontier, (least_s + lane_s, other))
            return True
        return False
