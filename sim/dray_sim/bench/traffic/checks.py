"""Checks of a lean world by geometry: overlapping rectangles, and places that two vehicles believe to hold."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import cos, hypot, sin

from dray.protocol.traffic.driving.right_of_way import Errand
from dray.protocol.traffic.driving.yielding import LAPSE_S
from dray.protocol.traffic.places import Footprint, Places
from dray.protocol.traffic.reservations.district import District
from dray_sim.bench.traffic.air import Air
from dray_sim.bench.traffic.boxes import BoxMachine, BoxPilot
from dray_sim.bench.traffic.carrier import Carrier
from dray_sim.bench.traffic.clock import LeanClock

LOOK_S = 0.1
"""Between two looks: at the highest speed 15 cm."""

STUCK_S = 300.0
"""A vehicle that stands for so long and has somewhere to go is stuck."""

RULES_EVERY = 10
"""Rules that are not about safety are looked at once in so many looks."""

OUTDATED_S = 5.0 * LAPSE_S
"""Each vehicle of a chain may keep a rank for `LAPSE_S` longer than the one before it, and requests take time."""

Rectangle = tuple[float, float, float]
"""x (m), y (m), heading (rad)."""


@dataclass
class Found:
    """Findings of the checks.

    Attributes:
        overlaps: pairs of rectangles, each counted once until they are apart again.
        double_holds: places, likewise.
        unrecorded: places that a vehicle holds and the table does not know of, likewise.
        in_entries: vehicles that wait for their dock in its entry, likewise.
        outdated: ranks that are inherited though their owner has another one for long, likewise.
        first: the first of them, in words.
    """

    overlaps: int = 0
    double_holds: int = 0
    unrecorded: int = 0
    in_entries: int = 0
    outdated: int = 0
    first: list[str] = field(default_factory=list)

    @property
    def faults(self) -> int:
        """Number of all violations."""
        return self.overlaps + self.double_holds + self.unrecorded + self.in_entries + self.outdated


class Checks:
    """Looks at a lean world ten times a second.

    Args:
        carriers: all vehicles.
        pilots: those with right of way, by name; none for ghosts.
        machines: that keep the tables, by name.
        places: of the plant.
        air: the network.
        footprint: of every vehicle.
        clock: of the world.
    """

    def __init__(
        self,
        carriers: Sequence[Carrier],
        pilots: Mapping[str, BoxPilot],
        machines: Mapping[str, BoxMachine],
        places: Places,
        air: Air,
        footprint: Footprint,
        clock: LeanClock,
    ) -> None:
        self._carriers = tuple(carriers)
        self._pilots = dict(pilots)
        self._machines = dict(machines)
        self._places = places
        self._air = air
        self._footprint = footprint
        self._clock = clock
        self._touching: set[tuple[str, str]] = set()
        self._double: set[tuple[str, str, str]] = set()
        self._wrong: set[tuple[str, str]] = set()
        self._since_s: dict[tuple[str, str], float] = {}
        self._looks = 0
        self.found = Found()

    def start(self) -> None:
        self._clock.call_at(self._clock.now_s, self._look)

    def _look(self) -> None:
        self._look_at_floor()
        if self._pilots:
            self._look_at_holds()
            self._looks += 1
            if self._looks % RULES_EVERY == 0:
                self._look_at_rules()
        self._clock.call_at(self._clock.now_s + LOOK_S, self._look)

    def _look_at_floor(self) -> None:
        now_s = self._clock.now_s
        reach_m = 2.0 * self._footprint.turning_radius_m
        cells: dict[tuple[int, int], list[tuple[str, Rectangle]]] = {}
        touching: set[tuple[str, str]] = set()
        for carrier in self._carriers:
            pose = carrier.travel.pose(now_s)
            here = (pose.x_m, pose.y_m, pose.heading_rad)
            column, row = int(pose.x_m // reach_m), int(pose.y_m // reach_m)
            for near in range(column - 1, column + 2):
                for by in range(row - 1, row + 2):
                    for other, there in cells.get((near, by), ()):
                        if hypot(here[0] - there[0], here[1] - there[1]) < reach_m and overlap(
                            here, there, self._footprint
                        ):
                            touching.add((other, carrier.atv))
            cells.setdefault((column, row), []).append((carrier.atv, here))
        for pair in touching - self._touching:
            self.found.overlaps += 1
            self._note(f"{now_s:.1f} s: {pair[0]} and {pair[1]} overlap")
        self._touching = touching

    def _look_at_holds(self) -> None:
        holders: dict[str, str] = {}
        double: set[tuple[str, str, str]] = set()
        for atv, pilot in self._pilots.items():
            for place in pilot.right_of_way.way.held:
                other = holders.setdefault(place, atv)
                if other != atv:
                    double.add((place, other, atv))
        for one in double - self._double:
            self.found.double_holds += 1
            self._note(f"{self._clock.now_s:.1f} s: {one[0]} is held by {one[1]} and {one[2]}")
        self._double = double

    def _look_at_rules(self) -> None:
        """Check that the table has every hold, and that no vehicle waits in its dock's entry or keeps an outdated rank."""
        wrong: set[tuple[str, str]] = set()
        places = self._places
        for atv, pilot in self._pilots.items():
            row = pilot.right_of_way
            for place in row.way.held:
                district = self._leading(places.district_of[place])
                if district is not None and district.table.holder(place) != atv:
                    wrong.add(("table", f"{place} is held by {atv}, and not in the table"))
            halves = not row.stands and row.errand is Errand.OWN and not pilot.was_cut
            if halves and row.goal == row.way.goal and places.dock_entries.get(row.goal) == row.way.base_end:
                wrong.add(
                    ("entry", f"{atv} drives to the entry {row.way.base_end} of its dock, and may not go on")
                )
            rank = row.rank(self._clock.now_s)
            owner = self._pilots.get(rank[2])
            over = owner is not None and owner.right_of_way.own_rank != rank and self._is_heard(atv, rank[2])
            if self._lasts(("rank", atv), over, OUTDATED_S):
                wrong.add(("rank", f"{atv} has inherited {rank}, which is over"))
        for kind, words in wrong - self._wrong:
            self.found.unrecorded += kind == "table"
            self.found.in_entries += kind == "entry"
            self.found.outdated += kind == "rank"
            self._note(f"{self._clock.now_s:.1f} s: {words}")
        self._wrong = wrong

    def _leading(self, name: str) -> District | None:
        """The district at the machine that keeps its table; None while that is being settled."""
        machines = [self._machines[replica] for replica in self._places.replicas_of[name]]
        newest = max(machine.tables.districts[name].copies.kept.epoch for machine in machines)
        for machine in machines:
            district = machine.tables.districts[name]
            if not machine.off and district.leads and district.copies.kept.epoch == newest:
                return district
        return None

    def _is_heard(self, *atvs: str) -> bool:
        """Whether nothing is wrong with some vehicles, and the network is whole."""
        air = self._air
        return not air.parts and not any(atv in air.deaf or self._pilots[atv].off for atv in atvs)

    def _lasts(self, what: tuple[str, str], holds: bool, longer_s: float) -> bool:
        """Whether a condition has lasted longer than that."""
        if not holds:
            self._since_s.pop(what, None)
            return False
        return self._clock.now_s - self._since_s.setdefault(what, self._clock.now_s) > longer_s

    def _note(self, words: str) -> None:
        if len(self.found.first) < 10:
            self.found.first.append(words)


def overlap(one: Rectangle, other: Rectangle, size: Footprint) -> bool:
    """Whether two rectangles of one size have a point in common (separating axes)."""
    half_m = (size.length_m / 2.0, size.width_m / 2.0)
    dx_m, dy_m = other[0] - one[0], other[1] - one[1]
    for heading, away in ((one[2], other[2]), (other[2], one[2])):
        axis_x, axis_y = cos(heading), sin(heading)
        turn = away - heading
        along, across = abs(cos(turn)), abs(sin(turn))
        if abs(dx_m * axis_x + dy_m * axis_y) >= half_m[0] + half_m[0] * along + half_m[1] * across:
            return False
        if abs(-dx_m * axis_y + dy_m * axis_x) >= half_m[1] + half_m[0] * across + half_m[1] * along:
            return False
    return True
