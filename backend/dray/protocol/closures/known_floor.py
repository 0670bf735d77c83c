"""A plant as one agent knows it: the plant file, and what people have closed, made slow or one-way since.

Every agent has its own, for each hears of a closure at a moment of its own. Whoever asks it for ways is given those that are open by
what the agent knows then; nobody else in the protocol need know of closures to price a transport or to drive.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from dray.messages import Closure, ClosureKind, Closures, closed_words
from dray.plant import Plant, Routes
from dray.plant.restrictions import OPEN, Ends, Restrictions, lanes_across, nodes_in
from dray.protocol.runtime.events import NEVER_S

KNOWN = "a list of closures that is no newer than the one that is known"
NOT_SIGNED = "a list of closures that nobody has signed whom this agent trusts"


class KnownFloor(Plant):
    """The plant of one agent.

    Args:
        plant: as it stands in its file; indexes and ways are shared with it.

    Attributes:
        restrictions: of the floor at present.
        said: the newest list that the agent has heard; None for none.
        ends_s: when the next closure ends by itself (plant clock).
    """

    def __init__(self, plant: Plant) -> None:
        self.__dict__.update(plant.__dict__)
        self.restrictions = OPEN
        self.said: Closures | None = None
        self.ends_s = NEVER_S
        self._current: dict[str, Routes] = {}

    def routes(self, vehicle_type: str, restrictions: Restrictions | None = None) -> Routes:
        """See `Plant.routes`; by default the ways that are open as far as this agent knows."""
        if restrictions is not None:
            return super().routes(vehicle_type, restrictions)
        routes = self._current.get(vehicle_type)
        if routes is None:
            routes = self._current[vehicle_type] = super().routes(vehicle_type, self.restrictions)
        return routes

    def objection(self, said: Closures, trusts: Callable[[bytes, bytes], bool] | None) -> str:
        """Why a list changes nothing; empty for one that is to be taken.

        Args:
            said: the list.
            trusts: called with words and a signature: whether it is that of somebody who is trusted; None where only a gateway's word is asked for.
        """
        if self.said is not None and said.number <= self.said.number:
            return KNOWN
        if trusts is not None and not trusts(closed_words(said.number, said.closures), said.signature):
            return NOT_SIGNED
        return ""

    def take(self, said: Closures, now_s: float) -> bool:
        """Go by a list from now on; True when the restrictions are others now."""
        self.said = said
        return self.look(now_s)

    def look(self, now_s: float) -> bool:
        """See what has ended by itself; True when the restrictions are others now."""
        lasting = (
            [] if self.said is None else [each for each in self.said.closures if not _is_over(each, now_s)]
        )
        self.ends_s = min((each.until_s for each in lasting if each.until_s is not None), default=NEVER_S)
        restrictions = restrictions_of(self, lasting)
        if restrictions == self.restrictions:
            return False
        self.restrictions = restrictions
        self._current.clear()
        return True


def restrictions_of(plant: Plant, closures: Iterable[Closure]) -> Restrictions:
    """What some closures do to the lanes of a plant; what the plant does not have is left out."""
    nodes: set[str] = set()
    lanes: set[Ends] = set()
    limits_mps: dict[Ends, float] = {}
    for each in closures:
        if each.kind is ClosureKind.CLOSED:
            closed_nodes, closed_lanes = _closed_by(plant, each)
            nodes |= closed_nodes
            lanes |= closed_lanes
        elif each.kind is ClosureKind.ONE_WAY:
            if plant.roads.lane(each.start, each.end) is not None:
                lanes.add((each.end, each.start))
        elif each.speed_mps is not None:
            for ends in _concerned(plant, each):
                limits_mps[ends] = min(each.speed_mps, limits_mps.get(ends, each.speed_mps))
    known = {ends for ends in lanes if plant.roads.lane(*ends) is not None}
    return Restrictions(frozenset(nodes), frozenset(known), tuple(sorted(limits_mps.items())))


def _closed_by(plant: Plant, closure: Closure) -> tuple[set[str], set[Ends]]:
    """The nodes and the lanes that a closure of the kind CLOSED closes."""
    if closure.area:
        area = plant.areas.get(closure.area)
        if area is None:
            return set(), set()
        across = lanes_across(area, plant.nodes, plant.roads)
        return set(nodes_in(area, plant.nodes.values())), {(lane.start, lane.end) for lane in across}
    if closure.node:
        crossing = plant.crossings.get(closure.node)
        if crossing is None:
            return {closure.node} & plant.nodes.keys(), set()
        # Who is in it leaves it by the other lanes.
        return set(crossing.inner), {ends for ends in crossing.lanes if ends[0] not in crossing.inner}
    return set(), {(closure.start, closure.end), (closure.end, closure.start)}


def _concerned(plant: Plant, closure: Closure) -> list[Ends]:
    """The lanes that a closure of the kind SLOW makes slow."""
    if closure.area:
        area = plant.areas.get(closure.area)
        if area is None:
            return []
        within = nodes_in(area, plant.nodes.values())
        across = {(lane.start, lane.end) for lane in lanes_across(area, plant.nodes, plant.roads)}
        return [
            ends
            for lane in plant.lanes
            if (ends := (lane.start, lane.end)) in across or lane.start in within or lane.end in within
        ]
    if closure.node:
        crossing = plant.crossings.get(closure.node)
        if crossing is not None:
            return list(crossing.lanes)
        around = (*plant.roads.leaving.get(closure.node, ()), *plant.roads.entering.get(closure.node, ()))
        return [(lane.start, lane.end) for lane in around]
    both = ((closure.start, closure.end), (closure.end, closure.start))
    return [ends for ends in both if plant.roads.lane(*ends) is not None]


def _is_over(closure: Closure, now_s: float) -> bool:
    return closure.until_s is not None and now_s >= closure.until_s
