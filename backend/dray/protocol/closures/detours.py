"""Ways round obstacles; without one, the way up to the obstacle, and a wait."""

from __future__ import annotations

from collections.abc import Container, Iterable
from itertools import pairwise

from msgspec.structs import replace

from dray.errors import NoWay
from dray.plant import Routes
from dray.plant.restrictions import Ends
from dray.plant.routes import Way

CLEARS_IN_S = 60.0
"""Extra cost of a way through an obstacle (s): about the time for a person to remove it."""


class Detours(Routes):
    """Ways of one type of vehicle, with obstacles on some lanes.

    Args:
        round_them: ways with these lanes closed.
        through: ways with all lanes that people have not closed.
        lanes: the lanes with obstacles.
    """

    __slots__ = ("_lanes", "_round", "_through")

    def __init__(self, round_them: Routes, through: Routes, lanes: frozenset[Ends]) -> None:
        self.restrictions = through.restrictions
        self._round, self._through, self._lanes = round_them, through, lanes

    def leads_round(self, start_node: str, goal_node: str) -> bool:
        """See `Routes.leads_round`."""
        return self._round.leads(start_node, goal_node)

    def way(self, start_node: str, goal_node: str) -> Way:
        """See `Routes.way`."""
        try:
            return self._round.way(start_node, goal_node)
        except NoWay:
            way = self._through.way(start_node, goal_node)
            met = sum(ends in self._lanes for ends in pairwise(way.nodes))
            return replace(way, duration_s=way.duration_s + CLEARS_IN_S * met)

    def duration_s(self, start_node: str, goal_node: str) -> float:
        """See `Routes.duration_s`."""
        return self.way(start_node, goal_node).duration_s

    def length_m(self, start_node: str, goal_node: str) -> float:
        """See `Routes.length_m`."""
        return self.way(start_node, goal_node).length_m

    def farthest_s(self, goal_node: str) -> float:
        """See `Routes.farthest_s`."""
        return self._through.farthest_s(goal_node)

    def nearest(self, start_node: str, places: Iterable[str]) -> tuple[str, Way]:
        """See `Routes.nearest`."""
        places = tuple(places)
        try:
            return self._round.nearest(start_node, places)
        except NoWay:
            return self._through.nearest(start_node, places)

    def way_out(self, start_node: str, stops: Container[str]) -> Way:
        """See `Routes.way_out`."""
        return self._through.way_out(start_node, stops)
