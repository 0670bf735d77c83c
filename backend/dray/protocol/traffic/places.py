"""The floor as places that are held by one vehicle at a time. Every agent derives the same places from the plant alone.

A place is a node, or a crossing of two-lane roads (`Crossing`). A vehicle enters a lane only when it holds all its places; the lane
ends in the last one. On single track that is the node at its end: two vehicles never meet on a lane, and a follower enters only
when the one ahead has left. Places that must be granted together belong to one *district*; one machine at a time leads its table.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import combinations, pairwise
from math import hypot, pi
from zlib import crc32

import msgspec

from dray.plant import DirectedLane, Plant
from dray.plant.floor.clearance import clear_m
from dray.plant.layout import MARGIN_M
from dray.protocol.traffic.dead_ends import dead_ends

REPLICAS = 3
"""Replicas of a district's table: if one fails or is cut off, two still form a majority."""

NEAR_M = 8.0
"""Distance below which districts are neighbours, so that vehicles in one hear of those in the other. In a warehouse with narrow
aisles 50 vehicles carry 7 % less when only lanes make neighbours (`dray bench traffic --plant kiva-50`)."""

STILL_M = 0.01
"""Distance to a place within which a vehicle counts as there."""

AHEAD_S = 10.0
"""Driving time, at top speed, for which a vehicle requests places at most: braking, and waiting for an answer on a slow link."""


class Footprint(msgspec.Struct, frozen=True):
    """The floor that the largest vehicle covers (m), by default that of a MiR250."""

    length_m: float = 0.8
    width_m: float = 0.58

    @classmethod
    def of(cls, plant: Plant) -> Footprint:
        """The footprint of a plant's largest vehicles."""
        kinds = plant.vehicle_types.values()
        return cls(max(kind.length_m for kind in kinds), max(kind.width_m for kind in kinds))

    @property
    def turning_radius_m(self) -> float:
        """Radius of the circle that it sweeps when it turns on the spot."""
        return hypot(self.length_m, self.width_m) / 2.0

    @property
    def spacing_m(self) -> float:
        """Distance from a node on which a vehicle turns to the middle of a vehicle that has left it."""
        return self.length_m / 2.0 + self.turning_radius_m + MARGIN_M

    def clear_m(self, angle_rad: float) -> float:
        """Distance along a lane until a vehicle is clear of those on another lane of its node, at this angle."""
        return clear_m(self.length_m, self.width_m, angle_rad)


class Crossing(msgspec.Struct, frozen=True):
    """A part of the floor that one vehicle crosses at a time, and where none stops."""

    id: str
    x_m: float
    y_m: float
    lanes: frozenset[tuple[str, str]]
    """Lanes that lead into it, through it or out of it, by their ends."""
    nodes: frozenset[str] = frozenset()
    """Nodes that lie in it: they are held with it, and no vehicle stops there."""


class Places:
    """The places of a plant, the replicas that grant them, and when a vehicle is clear of them.

    Args:
        plant: nodes, lanes and machines.
        footprint: of the largest vehicle.
        crossings: of two-lane roads; by default those of the plant.
        replicas: the agents that keep tables; by default the machines, and with fewer than `REPLICAS` the stations, too.

    Attributes:
        all: every place, in the order of the plant file.
        at_m: place -> its position.
        dock_entries: dock node -> the node before it, where no vehicle waits for the dock.
        dead_ends: node of a dead end -> the next node on the way out, where no vehicle waits to go farther in.
        district_of: place -> district. A district's name is that of the machine nearest to its first place, and a checksum of its
            places, replicas and lanes. With another plant file it is another district, so that no two tables grant one place.
        replicas_of: district -> its replicas, in the order of their turns.
    """

    def __init__(
        self,
        plant: Plant,
        footprint: Footprint | None = None,
        *,
        crossings: Sequence[Crossing] | None = None,
        replicas: Sequence[str] | None = None,
    ) -> None:
        self._roads = plant.roads
        self._footprint = footprint or Footprint.of(plant)
        if crossings is None:
            crossings = [
                Crossing(one.id, one.x_m, one.y_m, frozenset(one.lanes), frozenset(one.inner))
                for one in plant.crossings.values()
            ]
        self.dock_entries = _dock_entries(plant)
        self.docks = frozenset(plant.node_of(place) for place in plant.places)
        inner = {node: crossing.id for crossing in crossings for node in crossing.nodes}
        self._inner = frozenset(inner)
        crossed = {lane: crossing.id for crossing in crossings for lane in crossing.lanes}
        self._needs: dict[tuple[str, str], tuple[str, ...]] = {}
        for lane in plant.roads.lanes:
            ends = (lane.start, lane.end)
            places = (crossed.get(ends, ""), inner.get(lane.end, lane.end))
            self._needs[ends] = tuple(dict.fromkeys(place for place in places if place))
        self._inner_of = inner
        self._clear_m = {
            (lane.start, lane.end): self._leaves_m(lane, crosses=(lane.start, lane.end) in crossed)
            for lane in plant.roads.lanes
        }
        spots = {node.id: (node.x_m, node.y_m) for node in plant.nodes.values() if node.id not in inner}
        spots |= {crossing.id: (crossing.x_m, crossing.y_m) for crossing in crossings}
        self.all: tuple[str, ...] = tuple(spots)
        self.at_m: Mapping[str, tuple[float, float]] = spots
        self._fastest_mps = max(kind.max_speed_mps for kind in plant.vehicle_types.values())
        self._longest_m = max((lane.length_m for lane in plant.roads.lanes), default=0.0)
        # A vehicle that stands before the fork must be granted the last place of the dead end.
        self.dead_ends: Mapping[str, str] = dead_ends(
            plant, self.dock_entries, crossed, self.reach_m(0.0) - self._longest_m
        )
        chosen = tuple(replicas) if replicas is not None else _replicas(plant)
        at_m = {replica: plant.position_of(replica) for replica in chosen}
        nearest = self._divide(spots, at_m)
        replicas_of = {
            first: _nearest(at_m[first], at_m)[:REPLICAS] for first in dict.fromkeys(nearest.values())
        }
        names = self._names(nearest, replicas_of, spots)
        self.district_of: Mapping[str, str] = {place: names[first] for place, first in nearest.items()}
        self.replicas_of: Mapping[str, tuple[str, ...]] = {
            names[first]: replicas for first, replicas in replicas_of.items()
        }
        self._around = self._side_by_side(spots)

    def around(self, district: str) -> tuple[str, ...]:
        """A district and its neighbours: those that are joined to it by lanes, or near (`NEAR_M`)."""
        return self._around[district]

    def reach_m(self, since_s: float) -> float:
        """Largest straight distance of a vehicle's places from its position reported `since_s` ago."""
        return 2.0 * self._longest_m + self._fastest_mps * (AHEAD_S + since_s)

    def places_in(self, district: str) -> frozenset[str]:
        """All places of a district."""
        return frozenset(place for place, name in self.district_of.items() if name == district)

    def entries(self, place: str) -> tuple[tuple[str, str], ...]:
        """The lanes that lead into a place from outside, by their ends."""
        return tuple(
            ends
            for ends, places in self._needs.items()
            if place in places and self.place_of(ends[0]) != place
        )

    # --- lanes and nodes -------------------------------------------------------------------------

    def place_of(self, node: str) -> str:
        """The place that a node is, or lies in."""
        return self._inner_of.get(node, node)

    def needs(self, start: str, end: str) -> tuple[str, ...]:
        """The places that must be held to drive from one node to the next."""
        return self._needs[start, end]

    def may_stop(self, node: str) -> bool:
        """Whether a vehicle may stand there: the node lies in no crossing."""
        return node not in self._inner

    def length_m(self, start: str, end: str) -> float:
        """The length of the lane from one node to the next.

        Raises:
            KeyError: there is none.
        """
        lane = self._roads.lane(start, end)
        if lane is None:
            raise KeyError((start, end))
        return lane.length_m

    def clear_m(self, start: str, end: str) -> float:
        """How far past a node, on the lane to another one, a vehicle is clear of it."""
        return self._clear_m[start, end]

    def group_end(self, nodes: Sequence[str], first: int) -> int:
        """The index where the group that begins at index `first` of a way ends: the next node where a vehicle may stop and wait.

        A dock is taken with its entry, so that no vehicle waits in an entry; a crossing with the stop point behind it. A dead end is taken
        with its fork, as far as the way leads in, so that no vehicle waits in the only way out of another one.
        """
        last = len(nodes) - 1
        end = first
        while end < last:
            node, onward = nodes[end], nodes[end + 1]
            leads_in = node in (self.dock_entries.get(onward), self.dead_ends.get(onward))
            if self.may_stop(node) and not leads_in:
                break
            end += 1
        return end

    # --- how it is worked out --------------------------------------------------------------------

    def _leaves_m(self, lane: DirectedLane, *, crosses: bool) -> float:
        """How far along a lane a vehicle is clear of the lane's first node.

        A vehicle that turns back at a crossing is clear of its stop point when it stands at the next one: there is room for two
        to stand, turn and set off side by side (`dray.plant.layout`). Otherwise two vehicles that turned back at both ends of a road
        would each wait for a stop point that the other one still holds.
        """
        others = [
            other.heading_rad - lane.heading_rad
            for other in self._roads.leaving[lane.start]
            if other.end != lane.end
        ]
        others += [
            other.heading_rad - lane.heading_rad + pi
            for other in self._roads.entering[lane.start]
            if other.start != lane.end
        ]
        leaves_m = max(
            (self._footprint.clear_m(_between(angle)) for angle in others), default=self._footprint.spacing_m
        )
        between_stops = crosses and self.may_stop(lane.start) and self.may_stop(lane.end)
        return min(leaves_m, lane.length_m) if between_stops else leaves_m

    def _side_by_side(self, spots: Mapping[str, tuple[float, float]]) -> dict[str, tuple[str, ...]]:
        """District -> itself and its neighbours, of which a vehicle in it hears."""
        around: dict[str, dict[str, None]] = {district: {district: None} for district in self.replicas_of}
        for start, end in self._needs:
            one, other = (self.district_of[self.place_of(node)] for node in (start, end))
            around[one][other] = around[other][one] = None
        boxes = {district: _Box(spots[place] for place in self.places_in(district)) for district in around}
        for one, other in combinations(around, 2):
            if boxes[one].gap_m(boxes[other]) < NEAR_M:
                around[one][other] = around[other][one] = None
        return {district: tuple(near) for district, near in around.items()}

    def _names(
        self,
        nearest: Mapping[str, str],
        replicas_of: Mapping[str, tuple[str, ...]],
        spots: Mapping[str, tuple[float, float]],
    ) -> dict[str, str]:
        """First replica of a district -> the district's name."""
        told: dict[str, list[object]] = {first: [replicas] for first, replicas in replicas_of.items()}
        for place, (x_m, y_m) in sorted(spots.items()):
            told[nearest[place]].append((place, f"{x_m:.3f} {y_m:.3f}"))
        for (start, end), places in sorted(self._needs.items()):
            for first in sorted({nearest[place] for place in (self.place_of(start), *places)}):
                told[first].append((start, end, places, f"{self._clear_m[start, end]:.3f}"))
        return {first: f"{first}.{crc32(repr(parts).encode()):08x}" for first, parts in told.items()}

    def _divide(
        self, spots: Mapping[str, tuple[float, float]], at_m: Mapping[str, tuple[float, float]]
    ) -> dict[str, str]:
        """Place -> the replica nearest to the first of the places that go together with it."""
        together = _Together(spots)
        for dock, entry in self.dock_entries.items():
            together.join(self.place_of(entry), self.place_of(dock))
        for node, outward in self.dead_ends.items():
            together.join(self.place_of(outward), self.place_of(node))
        for (_, end), places in self._needs.items():
            for one, other in pairwise(places):
                together.join(one, other)
            if not self.may_stop(end):
                for onward in self._roads.leaving[end]:
                    for place in self._needs[onward.start, onward.end]:
                        together.join(places[-1], place)
        nearest = {place: _nearest(spot, at_m)[0] for place, spot in spots.items()}
        return {place: nearest[together.first_of(place)] for place in spots}


class _Box:
    """The smallest rectangle round some points."""

    def __init__(self, spots: Iterable[tuple[float, float]]) -> None:
        xs_m, ys_m = zip(*spots, strict=True)
        self._left_m, self._right_m = min(xs_m), max(xs_m)
        self._low_m, self._high_m = min(ys_m), max(ys_m)

    def gap_m(self, other: _Box) -> float:
        """Distance to another one; 0 where they overlap."""
        beside_m = max(self._left_m - other._right_m, other._left_m - self._right_m, 0.0)
        above_m = max(self._low_m - other._high_m, other._low_m - self._high_m, 0.0)
        return hypot(beside_m, above_m)


class _Together:
    """Which places go together: disjoint sets, each named by its first place."""

    def __init__(self, places: Iterable[str]) -> None:
        self._order = {place: number for number, place in enumerate(places)}
        self._above = {place: place for place in self._order}

    def first_of(self, place: str) -> str:
        while self._above[place] != place:
            self._above[place] = self._above[self._above[place]]
            place = self._above[place]
        return place

    def join(self, one: str, other: str) -> None:
        first, second = sorted((self.first_of(one), self.first_of(other)), key=self._order.__getitem__)
        self._above[second] = first


def _dock_entries(plant: Plant) -> dict[str, str]:
    """Dock -> the node that leads to it, for docks at the end of a spur or on a one-way loop beside the road."""
    entries: dict[str, str] = {}
    for place in plant.places:
        dock = plant.node_of(place)
        before = {lane.start for lane in plant.roads.entering[dock]}
        after = {lane.end for lane in plant.roads.leaving[dock]}
        if len(before) == 1 and len(after) == 1:
            entries[dock] = before.pop()
    return entries


def _replicas(plant: Plant) -> tuple[str, ...]:
    """The machines; with fewer than `REPLICAS`, also the stations of the storages."""
    machines = tuple(plant.machines)
    return machines if len(machines) >= REPLICAS else (*machines, *plant.stores)


def _nearest(spot: tuple[float, float], at_m: Mapping[str, tuple[float, float]]) -> tuple[str, ...]:
    """Replicas by straight distance, ties by id."""
    return tuple(sorted(at_m, key=lambda replica: (_distance_m(spot, at_m[replica]), replica)))


def _distance_m(one: tuple[float, float], other: tuple[float, float]) -> float:
    # Rounded, so that rounding errors of the root decide nothing.
    return round(hypot(one[0] - other[0], one[1] - other[1]), 6)


def _between(angle_rad: float) -> float:
    """An angle between two directions, from 0 to half a turn."""
    turn_rad = 2.0 * pi
    angle_rad = abs(angle_rad) % turn_rad
    return min(angle_rad, turn_rad - angle_rad)
