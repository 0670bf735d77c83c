"""Curved lanes as they are driven: a chain of short straight lanes over the corners of the shape.

    a --- b         a lane from a to b with two corners:  a -> a.to-b.1 -> a.to-b.2 -> b

No vehicle stops between its ends. The whole lane is one `Crossing` of the layout, with the name that a straight one's
stop point would have. So a vehicle enters it only when it may drive to its end. Its length is that of the chain.
"""

from __future__ import annotations

from itertools import pairwise
from math import hypot

from msgspec.structs import replace

from dray.plant.floor.sizes import fitted
from dray.plant.layout import Crossing, Layout, lay_out, name_after, short_name
from dray.plant.model import Lane, Node, PlantFile, Point


def floor_of(file: PlantFile) -> Layout:
    """The floor of a plant file as it is driven: lanes for the types that fit, two lanes beside one another, and shapes as chains.

    Its ids and references must be right.
    """
    layout = lay_out(fitted(file))
    if not any(lane.shape for lane in layout.lanes):
        return layout
    return _chained(layout)


def joined_floor(file: PlantFile) -> Layout | None:
    """The floor of a plant file; None where a lane does not join two of its nodes, which is a fault of its own."""
    nodes = {node.id for node in file.nodes}
    if all(lane.start in nodes and lane.end in nodes and lane.start != lane.end for lane in file.lanes):
        return floor_of(file)
    return None


def corner_name(lane: Lane, number: int) -> str:
    """The node at a corner of a lane, counted from 1."""
    return short_name(f"{lane.start}.to-{lane.end}.{number}")


def corner_names(file: PlantFile) -> frozenset[str]:
    """All nodes that the shapes of a file make, and the names of their lanes."""
    return frozenset(
        name
        for lane in file.lanes
        if lane.shape
        for name in (
            name_after(lane.start, lane.end),
            *(corner_name(lane, number) for number in range(1, len(lane.shape) + 1)),
        )
    )


def corners_of(lane: Lane, start: Node, end: Node) -> list[Point]:
    """All points of a lane, its ends included."""
    return [Point(start.x_m, start.y_m), *lane.shape, Point(end.x_m, end.y_m)]


def chain_m(points: list[Point]) -> float:
    """The length of the straight pieces between some points (m)."""
    return sum(hypot(after.x_m - before.x_m, after.y_m - before.y_m) for before, after in pairwise(points))


def _chained(layout: Layout) -> Layout:
    nodes, lanes = list(layout.nodes), list[Lane]()
    crossings, inner, crossed = dict(layout.crossings), dict(layout.inner), dict(layout.crossed)
    chains: dict[tuple[str, str], tuple[str, ...]] = {}
    for lane in layout.lanes:
        if not lane.shape:
            lanes.append(lane)
            continue
        corners = [
            Node(corner_name(lane, number), spot.x_m, spot.y_m) for number, spot in enumerate(lane.shape, 1)
        ]
        names = [lane.start, *(corner.id for corner in corners), lane.end]
        chain = [replace(lane, start=a, end=b, shape=()) for a, b in pairwise(names)]
        nodes += corners
        lanes += chain
        chains[lane.start, lane.end] = tuple(names[1:-1])
        if lane.both_ways:
            chains[lane.end, lane.start] = tuple(names[-2:0:-1])
        ends = _ends(chain)
        within = crossed.get((lane.start, lane.end))
        if within is None:
            # The lane becomes a crossing.
            name = name_after(lane.start, lane.end)
            middle = corners[len(corners) // 2]
            crossings[name] = Crossing(
                name,
                (),
                middle.x_m,
                middle.y_m,
                entries=_outer(lane, inner, forward=True),
                exits=_outer(lane, inner, forward=False),
                lanes=ends,
                inner=tuple(corner.id for corner in corners),
            )
        else:
            # The lane joins an existing crossing.
            name = within
            gone = {(lane.start, lane.end), (lane.end, lane.start)}
            of = crossings[name]
            crossings[name] = replace(
                of,
                lanes=(*(one for one in of.lanes if one not in gone), *ends),
                inner=(*of.inner, *(corner.id for corner in corners)),
            )
            for one in gone:
                crossed.pop(one, None)
        inner.update((corner.id, name) for corner in corners)
        crossed.update((one, name) for one in ends)
    return Layout(tuple(nodes), tuple(lanes), crossings, inner, crossed, chains)


def _ends(chain: list[Lane]) -> tuple[tuple[str, str], ...]:
    """The ends of every lane in each direction."""
    forward = [(lane.start, lane.end) for lane in chain]
    return (*forward, *((end, start) for start, end in forward)) if chain[0].both_ways else tuple(forward)


def _outer(lane: Lane, inner: dict[str, str], *, forward: bool) -> tuple[str, ...]:
    """Nodes where vehicles stand before they enter it, or after they leave it, if they may stand there."""
    ends = (lane.start, lane.end) if forward else (lane.end, lane.start)
    return tuple(end for end in ends[: 2 if lane.both_ways else 1] if end not in inner)
