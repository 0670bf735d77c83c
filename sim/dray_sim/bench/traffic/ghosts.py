"""Ghosts: vehicles that pass through one another.

They give the most that a fleet could carry, which no floor can reach.
"""

from __future__ import annotations

from dray.body import Drive
from dray.plant import Plant
from dray_sim.bench.traffic.carrier import Carrier


class Ghost:
    """Drives the whole way at once, through all others."""

    def __init__(self, carrier: Carrier, plant: Plant) -> None:
        self._carrier = carrier
        self._routes = plant.routes(carrier.kind.id)
        self._order = 0
        self._goal = carrier.travel.node

    def go(self, node: str, *, idle: bool) -> None:
        self._goal = node
        here = self._carrier.travel.node
        if here == node and self._carrier.travel.way is None:
            self._carrier.arrive()
            return
        start = self._carrier.travel.next_node(self._carrier._clock.now_s)  # noqa: SLF001
        nodes = self._routes.way(start, node).nodes
        self._order += 1
        self._carrier.instruct(Drive(order=self._order, nodes=nodes, released=len(nodes)))

    def dock(self) -> None:
        """Do nothing."""

    def rest(self) -> None:
        """Do nothing."""

    def passed(self, node: str) -> None:
        if node == self._goal and self._carrier.travel.way is None:
            self._carrier.arrive()
