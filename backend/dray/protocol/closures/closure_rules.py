"""The effect of closures on a plant's lanes: pure, the same for vehicles, machines and displays."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from dray.messages import Closure, ClosureKind
from dray.plant import Lane, Plant, Roads
from dray.plant.restrictions import Ends, Extent, Restrictions

NOTHING = Extent(frozenset(), frozenset())
"""The extent of an area that the plant does not have."""


def restrictions_of(plant: Plant, closures: Iterable[Closure]) -> Restrictions:
    """The effect of some closures on a plant's lanes; unknown places are ignored."""
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
                lanes.add(plant.way_back(each.start, each.end))
        elif each.speed_mps is not None:
            for ends in _concerned(plant, each):
                limits_mps[ends] = min(each.speed_mps, limits_mps.get(ends, each.speed_mps))
    known = {ends for ends in lanes if plant.roads.lane(*ends) is not None}
    return Restrictions(frozenset(nodes), frozenset(known), tuple(sorted(limits_mps.items())))


def _closed_by(plant: Plant, closure: Closure) -> tuple[set[str], set[Ends]]:
    """The nodes and the lanes that a closure of the kind CLOSED closes."""
    extent = _extent_of(plant, closure)
    if extent is not None:
        return set(extent.nodes), set(extent.across)
    if closure.node:
        crossing = plant.crossings.get(closure.node)
        if crossing is None:
            return {closure.node} & plant.nodes.keys(), set()
        # A vehicle inside leaves by the other lanes.
        return set(crossing.inner), {ends for ends in crossing.lanes if ends[0] not in crossing.inner}
    return set(), {(closure.start, closure.end), plant.way_back(closure.start, closure.end)}


def _concerned(plant: Plant, closure: Closure) -> list[Ends]:
    """The lanes that a closure of the kind SLOW slows down."""
    extent = _extent_of(plant, closure)
    if extent is not None:
        return [
            ends
            for lane in plant.lanes
            if (ends := (lane.start, lane.end)) in extent.across or not extent.nodes.isdisjoint(ends)
        ]
    if closure.node:
        crossing = plant.crossings.get(closure.node)
        if crossing is not None:
            return list(crossing.lanes)
        around = (*plant.roads.leaving.get(closure.node, ()), *plant.roads.entering.get(closure.node, ()))
        return [(lane.start, lane.end) for lane in around]
    both = ((closure.start, closure.end), plant.way_back(closure.start, closure.end))
    return [ends for ends in both if plant.roads.lane(*ends) is not None]


def _extent_of(plant: Plant, closure: Closure) -> Extent | None:
    """The contents of a closure's area or outline; None if it has neither."""
    if closure.outline:
        return plant.extent_within(closure.outline)
    if closure.area:
        return plant.extent_of(closure.area) if closure.area in plant.areas else NOTHING
    return None


def lanes_of(plant: Plant, closure: Closure) -> list[Ends]:
    """The lanes that one closure closes or slows down, each direction by itself, in the order of the plant."""
    alone = restrictions_of(plant, [closure])
    slow = dict(alone.limits_mps)
    return [
        ends
        for lane in plant.lanes
        if (ends := (lane.start, lane.end)) in slow or not alone.admits(*ends) or lane.end in alone.nodes
    ]


def cut_off(plant: Plant, restrictions: Restrictions) -> tuple[str, ...]:
    """Places outside the largest connected part of the open lanes."""
    nodes = {place: plant.node_of(place) for place in plant.places}
    reached = _largest_part(plant, restrictions)
    return tuple(place for place, node in nodes.items() if node not in reached)


def shut_in(plant: Plant, restrictions: Restrictions, nodes: Mapping[str, str]) -> tuple[str, ...]:
    """Vehicles without a way to the largest connected part.

    Args:
        plant: its lanes.
        restrictions: the present restrictions.
        nodes: by vehicle: its node.
    """
    lanes = [
        Lane(lane.start, lane.end)
        for lanes in restrictions.open_lanes(plant.roads).values()
        for lane in lanes
    ]
    part = _largest_part(plant, restrictions)
    leads_there = Roads(plant.nodes.values(), lanes).reaching(next(iter(part))) if part else frozenset()
    return tuple(
        vehicle for vehicle, node in nodes.items() if node in plant.nodes and node not in leads_there
    )


def _largest_part(plant: Plant, restrictions: Restrictions) -> frozenset[str]:
    """The open nodes that are all connected; of several parts the one with the most docks."""
    lanes = [
        Lane(lane.start, lane.end)
        for lanes in restrictions.open_lanes(plant.roads).values()
        for lane in lanes
        if lane.start not in restrictions.nodes
    ]
    docks = {plant.node_of(place) for place in plant.places} - restrictions.nodes
    parts = Roads(plant.nodes.values(), lanes).parts()
    return max(parts, key=lambda part: len(part & docks)) - restrictions.nodes
