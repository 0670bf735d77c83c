"""One direction of a road between two crossings, and the ways over crossings, with their types of vehicles and limits."""

from __future__ import annotations

import msgspec

from dray.plant.model import Lane, LaneType, Node


class Road(msgspec.Struct):
    """One direction of a road between two crossings."""

    start: str
    end: str
    speed_limit_mps: float
    offset_m: float
    """Distance to the right of the middle; 0 for a one-way road."""
    stops: tuple[Node, ...] = ()
    """One or two, in the order of driving."""
    types: tuple[LaneType, ...] = ()

    def lane(self, start: str, end: str) -> Lane:
        """A piece of it."""
        return Lane(start, end, self.speed_limit_mps, types=self.types)


def over_crossing(entered: Road, before: str, left: Road, after: str) -> Lane | None:
    """The way over a crossing, for types of vehicles that may drive on both roads; None where there is no such type."""
    limit_mps = min(entered.speed_limit_mps, left.speed_limit_mps)
    types = entered.types or left.types
    if entered.types and left.types:
        other = {each.type: each.speed_limit_mps for each in left.types}
        types = tuple(
            LaneType(each.type, min(filter(None, (each.speed_limit_mps, other[each.type])), default=None))
            for each in entered.types
            if each.type in other
        )
        if not types:
            return None
    return Lane(before, after, limit_mps, types=types)
