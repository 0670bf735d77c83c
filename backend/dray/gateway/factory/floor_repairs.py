"""Repairs for warnings about the floor: move one node so far that vehicles have room.

They are tried like repairs of errors: the floor stays without errors, the warning is gone, and nothing else
becomes too narrow.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from itertools import islice, product
from math import hypot, pi

from msgspec.structs import replace

from dray.gateway.factory.repairs import MAX_REPAIRS, MovedAlong, RepairView, Spot
from dray.plant import Plant, PlantFile
from dray.plant.file.check_floor import floor_faults
from dray.plant.floor.clearance import CLEARANCE_M
from dray.plant.floor.rectangles import Rectangle, driven, gap_m, standing
from dray.plant.layout import Size, name_after, name_before
from dray.plant.model import Node
from dray.plant.planning.advice import Advice
from dray.plant.planning.advice_floor import floor_advice
from dray.plant.planning.room import Subject

STEP_M = 0.1
"""Increment by which a node is moved until there is room; people draw on this grid."""

FLOOR_TRIED = 10
"""Maximum changes tried per warning: two nodes, a few directions, room to stand and room to turn."""

MOST_M = 5.0
"""Maximum shift of a node: farther off is another place, not a repair."""

APART_M = (1.0, 2.0, 3.5)
"""Distances tried in turn to move the nodes of two crossings apart."""

LEAN = 0.5
"""Maximum cosine of the angle to a direction for a road that leads across it: at least 60 degrees."""

MENDED = frozenset({"near", "narrow", "crossing"})
"""Kinds of warnings that moving a node may solve."""

Move = tuple[Node, float, float]
"""A node, and the direction to move it in (a unit vector)."""


class FloorRepairs:
    """Repairs for the warnings of one plant file.

    Args:
        plant: a plant without errors.
    """

    def __init__(self, plant: Plant) -> None:
        self._plant, self._sought = plant, 0
        self._size = Size.of(plant.vehicle_types.values())
        self._written = {node.id: index for index, node in enumerate(plant.file.nodes)}
        self._narrow: frozenset[tuple[str, Subject]] | None = None

    def of(self, warning: Advice) -> RepairView | None:
        """A repair of a warning's first subject; None when nothing tried helps."""
        if warning.kind not in MENDED or not warning.about or self._sought == MAX_REPAIRS:
            return None
        self._sought += 1
        subject = warning.about[0]
        if self._narrow is None:
            self._narrow = _narrow(self._plant)
        for repair, file in islice(self._proposals(warning.kind, subject), FLOOR_TRIED):
            if any(floor_faults(file)):
                continue
            after = _narrow(Plant(file))
            if _told(warning.kind, subject) not in after and after < self._narrow:
                return repair
        return None

    def _proposals(self, kind: str, subject: Subject) -> Iterator[tuple[RepairView, PlantFile]]:
        """Changes that may help, the smallest first."""
        if kind == "crossing" or not self._written.keys() & set(subject[: 2 if kind == "near" else 1]):
            yield from self._apart(subject if kind == "crossing" else self._drawn(subject))
            return
        moves = self._from_one_another(subject) if kind == "near" else self._off_a_lane(subject)
        found = [(by_m, node, x, y) for (node, x, y), by_m in moves if by_m is not None]
        for by_m, node, x, y in sorted(found, key=lambda each: each[0]):
            yield self._moved(node, x * by_m, y * by_m)

    # --- how far ------------------------------------------------------------------------------------

    def _from_one_another(self, subject: Subject) -> Iterator[tuple[Move, float | None]]:
        """Move either of two places away from the other."""
        for one, other in (subject, subject[::-1]):
            if one in self._written:
                here, there = self._plant.nodes[one], self._plant.nodes[other]
                stands = self._stands(there)
                for x, y in self._directions(here, here.x_m - there.x_m, here.y_m - there.y_m):
                    yield (here, x, y), self._room_m(here, x, y, stands)
                    turns = (Rectangle(there.x_m, there.y_m, 0.0, 0.0, 0.0),)
                    yield (here, x, y), self._turning_room_m(here, x, y, turns, 2.0)

    def _off_a_lane(self, subject: Subject) -> Iterator[tuple[Move, float | None]]:
        """Move a place away from a lane that passes it."""
        node, *ends = subject
        if node in self._written:
            here = self._plant.nodes[node]
            start, end = (self._plant.nodes[each] for each in ends)
            swept = driven(start, end, self._size.length_m, self._size.width_m)
            along_x, along_y = end.x_m - start.x_m, end.y_m - start.y_m
            left = along_x * (here.y_m - start.y_m) - along_y * (here.x_m - start.x_m) >= 0.0
            away = (-along_y, along_x) if left else (along_y, -along_x)
            for x, y in self._directions(here, *away):
                yield (here, x, y), self._room_m(here, x, y, (swept,))
                yield (here, x, y), self._turning_room_m(here, x, y, (swept,), 1.0)

    def _apart(self, subject: Subject) -> Iterator[tuple[RepairView, PlantFile]]:
        """Move one crossing's node, and all nodes across from it, away from the other crossing."""
        nodes = self._plant.file.nodes
        points = [nodes[self._written[each]] for each in subject if each in self._written]
        if len(points) != 2:
            return
        for by_m, (here, there) in product(APART_M, (points, points[::-1])):
            x, y = here.x_m - there.x_m, here.y_m - there.y_m
            away_m = hypot(x, y)
            if away_m > 0.0:
                across = self._across(here, x / away_m, y / away_m)
                if there.id not in across:
                    yield self._moved(here, x / away_m * by_m, y / away_m * by_m, across - {here.id})

    def _across(self, here: Node, x: float, y: float) -> set[str]:
        """A node, and all nodes joined to it by roads across a direction (a unit vector)."""
        nodes = {node.id: node for node in self._plant.file.nodes}
        beside: dict[str, list[str]] = {}
        for lane in self._plant.file.lanes:
            start, end = nodes[lane.start], nodes[lane.end]
            along_m = (end.x_m - start.x_m) * x + (end.y_m - start.y_m) * y
            if abs(along_m) < LEAN * hypot(end.x_m - start.x_m, end.y_m - start.y_m):
                beside.setdefault(lane.start, []).append(lane.end)
                beside.setdefault(lane.end, []).append(lane.start)
        found, coming = {here.id}, [here.id]
        while coming:
            for other in beside.get(coming.pop(), ()):
                if other not in found:
                    found.add(other)
                    coming.append(other)
        return found

    def _drawn(self, subject: Subject) -> Subject:
        """The nearest pair of file nodes to which two stop points of two-lane roads belong."""
        roads: dict[str, Subject] = {}
        for lane in self._plant.file.lanes:
            for start, end in ((lane.start, lane.end), (lane.end, lane.start)):
                roads[name_after(start, end)] = roads[name_before(start, end)] = (start, end)
        pairs = product(*(roads.get(each, (each,)) for each in subject[:2]))
        nodes = {node.id: node for node in self._plant.file.nodes}
        known = [pair for pair in pairs if pair[0] != pair[1] and nodes.keys() >= set(pair)]

        def away_m(pair: Subject) -> float:
            one, other = nodes[pair[0]], nodes[pair[1]]
            return hypot(one.x_m - other.x_m, one.y_m - other.y_m)

        return min(known, key=away_m, default=())

    def _directions(self, here: Node, x: float, y: float) -> Iterator[tuple[float, float]]:
        """Straight away from the obstacle, and along the node's lanes, whose direction then stays."""
        lanes = (*self._plant.roads.leaving[here.id], *self._plant.roads.entering[here.id])
        ends = [self._plant.nodes[end] for lane in lanes for end in (lane.start, lane.end) if end != here.id]
        ways = [(end.x_m - here.x_m, end.y_m - here.y_m) for end in ends]
        known = set()
        for way_x, way_y in ((x, y), *ways, *((-way_x, -way_y) for way_x, way_y in ways)):
            length_m = hypot(way_x, way_y)
            if length_m > 1e-6:
                unit = round(way_x / length_m, 6), round(way_y / length_m, 6)
                if unit not in known:
                    known.add(unit)
                    yield unit

    def _room_m(self, node: Node, x: float, y: float, taken: tuple[Rectangle, ...]) -> float | None:
        """Metres to move a place until a vehicle there clears these rectangles; None if too far."""
        for step in range(1, int(MOST_M / STEP_M) + 1):
            by_m = step * STEP_M
            there = Node(node.id, node.x_m + x * by_m, node.y_m + y * by_m)
            if all(gap_m(stand, other) >= CLEARANCE_M for stand in self._stands(there) for other in taken):
                return by_m
        return None

    def _turning_room_m(
        self, node: Node, x: float, y: float, taken: tuple[Rectangle, ...], circles: float
    ) -> float | None:
        """Metres to move a place until a turning vehicle clears these, by so many turning circles.

        None if too far.
        """
        needed_m = circles * self._size.turning_radius_m + CLEARANCE_M
        for step in range(1, int(MOST_M / STEP_M) + 1):
            by_m = step * STEP_M
            x_m, y_m = node.x_m + x * by_m, node.y_m + y * by_m
            if all(
                hypot(x_m - other.x_m, y_m - other.y_m) >= needed_m
                if not other.length_m
                else gap_m(Rectangle(x_m, y_m, other.heading_rad, 0.0, 0.0), other) >= needed_m
                for other in taken
            ):
                return by_m
        return None

    def _stands(self, node: Node) -> tuple[Rectangle, ...]:
        """A vehicle standing at a node, in every direction of arrival or departure."""
        roads, size = self._plant.roads, self._size
        lanes = (*roads.entering[node.id], *roads.leaving[node.id])
        headings = {round(lane.heading_rad % pi, 6) for lane in lanes}
        return tuple(standing(node, heading, size.length_m, size.width_m) for heading in sorted(headings))

    # --- the change ---------------------------------------------------------------------------------

    def _moved(
        self, node: Node, x_m: float, y_m: float, others: Collection[str] = ()
    ) -> tuple[RepairView, PlantFile]:
        nodes = list(self._plant.file.nodes)
        shifts = []
        for name in (node.id, *sorted(others)):
            index = self._written[name]
            to = Node(name, round(nodes[index].x_m + x_m, 2), round(nodes[index].y_m + y_m, 2))
            nodes[index] = to
            shifts.append(MovedAlong(index, {"x_m": to.x_m, "y_m": to.y_m}))
        to = nodes[self._written[node.id]]
        view = RepairView(
            kind="shift",
            section="nodes",
            index=shifts[0].index,
            entry=shifts[0].entry,
            name=node.id,
            distance_m=round(hypot(to.x_m - node.x_m, to.y_m - node.y_m), 2),
            measure=(Spot(node.x_m, node.y_m), Spot(to.x_m, to.y_m)),
            also=tuple(shifts[1:]),
        )
        return view, replace(self._plant.file, nodes=tuple(nodes))


def _narrow(plant: Plant) -> frozenset[tuple[str, Subject]]:
    """Everything that is too narrow on a floor."""
    return frozenset(_told(kind, subject) for kind, _, _, about in floor_advice(plant) for subject in about)


def _told(kind: str, subject: Subject) -> tuple[str, Subject]:
    """A finding's subject without the lane, since a moved place may be in the way of another lane."""
    return kind, subject[:1] if kind == "narrow" else subject
