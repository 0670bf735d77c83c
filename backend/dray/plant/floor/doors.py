"""Doors on lanes: the driven lanes through each door, and the area of its leaf.

A door stands in the middle of its lane. A vehicle waits at the lane's first node, where it can still turn round, and
enters the lane only when the door stands open. On a two-lane road, those nodes are the stop points before and after
the door, from which no lane leads back. While a vehicle is on the lane the door stays open.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from msgspec.structs import replace

from dray.plant.floor.rectangles import Rectangle
from dray.plant.layout import MARGIN_M, Layout, name_after, name_before
from dray.plant.model import Door, Lane, Node, PlantFile, VehicleType
from dray.plant.roads import DirectedLane

Ends = tuple[str, str]
"""A lane in one direction, by its nodes."""

LEAF_M = 0.2
"""Thickness of a door."""


def doors_on(file: PlantFile, layout: Layout) -> dict[Ends, Door]:
    """The doors of a file by the driven lanes through them, in each direction; doors without such a lane are left out."""
    lanes = lanes_between(file)
    driven = {(lane.start, lane.end): lane.both_ways for lane in layout.lanes}
    found: dict[Ends, Door] = {}
    for door in file.doors:
        for named in door.lanes:
            lane = lanes.get((named.start, named.end))
            if lane is not None:
                found.update(dict.fromkeys(driven_through(lane, driven), door))
    return found


def lanes_between(file: PlantFile) -> dict[Ends, Lane]:
    """The lanes of a file by their nodes, in whichever direction; of two one-way lanes, each in its own."""
    lanes = {(lane.end, lane.start): lane for lane in file.lanes}
    lanes.update({(lane.start, lane.end): lane for lane in file.lanes})
    return lanes


def driven_through(lane: Lane, driven: Mapping[Ends, bool]) -> Iterator[Ends]:
    """The driven lanes in place of a lane of the file, in each direction; none where a door cannot stand on it.

    Args:
        lane: of the file.
        driven: the lanes of the layout by their ends, and whether they are two-way.
    """
    ends = lane.start, lane.end
    if lane.shape:
        return
    if ends in driven:
        yield ends
        if driven[ends]:
            yield lane.end, lane.start
        return
    for start, end in (ends, (lane.end, lane.start)):
        between = name_after(start, end), name_before(start, end)
        if between in driven:
            yield between


def doors_along(doors: Iterable[Door], lanes: Iterable[Lane]) -> tuple[Door, ...]:
    """The doors that stand on some of the lanes, as they stand on these alone."""
    known = {ends for lane in lanes for ends in ((lane.start, lane.end), (lane.end, lane.start))}
    kept = ((door, tuple(on for on in door.lanes if (on.start, on.end) in known)) for door in doors)
    return tuple(replace(door, lanes=on) for door, on in kept if on)


def leaf_of(lane: DirectedLane, nodes: Mapping[str, Node], types: Mapping[str, VehicleType]) -> Rectangle:
    """The area of the shut door on a lane: as wide as the widest vehicle, with a margin on either side."""
    start, end = nodes[lane.start], nodes[lane.end]
    width_m = max((kind.width_m for kind in types.values()), default=0.0) + 2.0 * MARGIN_M
    middle = (start.x_m + end.x_m) / 2.0, (start.y_m + end.y_m) / 2.0
    return Rectangle(*middle, lane.heading_rad, LEAF_M, width_m)
