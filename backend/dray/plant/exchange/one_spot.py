"""Merges nodes on one spot that a turning edge joins: a plant has no headings, and such places are never both free."""

from __future__ import annotations

from math import hypot

from dray.plant.exchange.notes import Notes
from dray.plant.exchange.track_layout import TrackEdge, TrackLayout, TrackNode
from dray.plant.file.reasons import Reason

SPOT_M = 0.05
"""Nodes nearer to each other are one place; a shorter lane is a fault of a plant."""


def merge_spots(layout: TrackLayout, notes: Notes) -> None:
    """Merge nodes on one spot where edges lead from one to the other.

    Their edges become turns at the node, which the layout's `kept` lists as `turns`. The node that comes first in the
    file keeps the others as `same_spot`.
    """
    nodes = {node.original: node for node in layout.nodes}
    first = {name: name for name in nodes}

    def find(name: str) -> str:
        while first[name] != name:
            first[name] = name = first[first[name]]
        return name

    order = {name: index for index, name in enumerate(nodes)}
    for edge in layout.edges:
        # The groups' first nodes are compared, so that a chain of short edges does not join its ends.
        one, other = find(edge.start), find(edge.end)
        if one != other and _one_spot(nodes[one], nodes[other]):
            kept, gone = sorted((one, other), key=order.__getitem__)
            first[gone] = kept
    if all(find(name) == name for name in nodes):
        return
    kept_nodes = []
    for node in layout.nodes:
        into = nodes[find(node.original)]
        if into is node:
            kept_nodes.append(node)
        else:
            _take_in(into, node)
            text = Reason("note_nodes_lie_on_spot_they", one=into.name, other=node.name)
            notes.add(node.place, text)
    edges = []
    for edge in layout.edges:
        before = edge.start, edge.end
        edge.start, edge.end = find(edge.start), find(edge.end)
        if edge.start == edge.end and before[0] != before[1]:
            layout.kept.setdefault("turns", []).append(_turn(edge, before, nodes))
        else:
            edges.append(edge)
    layout.nodes, layout.edges = kept_nodes, edges
    for station in layout.stations:
        station.nodes = list(dict.fromkeys(find(node) for node in station.nodes))
    for vehicle in layout.vehicles:
        vehicle.node = None if vehicle.node is None else find(vehicle.node)


def _one_spot(one: TrackNode, other: TrackNode) -> bool:
    return one.level == other.level and hypot(one.x_m - other.x_m, one.y_m - other.y_m) < SPOT_M


def _take_in(into: TrackNode, node: TrackNode) -> None:
    into.parks, into.charges = into.parks or node.parks, into.charges or node.charges
    # A node that names no types is for all.
    into.types = list(dict.fromkeys((*into.types, *node.types))) if into.types and node.types else []
    sizes = [size for size in (into.max_m, node.max_m) if size is not None]
    into.max_m = (min(size[0] for size in sizes), min(size[1] for size in sizes)) if sizes else None
    same = {"original": node.name, "kept": node.kept}
    into.kept = {**into.kept, "same_spot": [*into.kept.get("same_spot", ()), same]}


def _turn(edge: TrackEdge, ends: tuple[str, str], nodes: dict[str, TrackNode]) -> dict[str, object]:
    start, end = (nodes[name].name for name in ends)
    return {"original": edge.original, "start": start, "end": end, "kept": edge.kept}
