"""One floor with smaller and larger fleets: more vehicles should never carry less.

The floor, its chargers and its parking places stay as they are drawn. The same orders come in each time.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import msgspec
from msgspec.structs import replace

from dray.plant import Plant, VehicleSpec
from dray.plant.planning.advice import most_vehicles
from dray_sim.plants.play import Kind, plant_of
from dray_sim.run.evidence import HELD
from dray_sim.run.report import Report
from dray_sim.run.stage import Shift, play, with_right_of_way

LOAD = 1.0
"""Part of the machines' time that orders take: more than a small fleet can carry."""

FIRST_BATTERY_FRAC = 0.8
"""Battery level of added vehicles."""


class FleetSize(msgspec.Struct, frozen=True):
    """The transports of one fleet."""

    vehicles: int
    places: int
    """Number of vehicles for which the floor has dwell points and places out of the way, those of the reserve
    included."""
    transports: int
    pieces: int
    p50_s: float
    p95_s: float
    starvation_frac: float
    """Part of the machines' time in which they waited for material."""
    invariants: str
    most: int
    """How many of them the floor bears: `dray plant check` calls more an error."""

    @property
    def holds(self) -> bool:
        """Whether no invariant was broken."""
        return self.invariants == HELD

    def tell(self) -> str:
        """A row of the table."""
        broken = "" if self.holds else f" {self.invariants}"
        named = f" too many: the floor bears {self.most} at most" if self.most < self.vehicles else ""
        return (
            f"{self.vehicles:8d} {self.places:6d} {self.transports:10d} {self.pieces:6d} {self.p50_s:6.0f} "
            f"{self.p95_s:6.0f} {self.starvation_frac:8.1%}{named}{broken}"
        )


HEADING = f"{'vehicles':>8} {'places':>6} {'transports':>10} {'pieces':>6} {'p50 s':>6} {'p95 s':>6} {'starving':>8}"


def with_fleet(plant: Plant, count: int) -> Plant:
    """The same plant with so many vehicles, or as many as can begin the day at nodes of their own.

    Args:
        plant: as it was. The first vehicles of its file stay; further ones are of their types, in turn.
        count: how many vehicles.
    """
    file = plant.file
    fleet = list(file.fleet[:count])
    taken = {spec.node for spec in fleet}
    docks = {plant.node_of(place) for place in plant.places}
    entries = {lane.start for dock in docks for lane in plant.roads.entering[dock]}
    stands = [plant.node_of(place) for place in plant.dwell_points]
    roads = sorted((node for node in plant.stops if node not in docks), key=entries.__contains__)
    free = [node for node in (*stands, *roads) if node not in taken]
    for number, node in zip(range(len(fleet), count), free, strict=False):
        kind = file.fleet[number % len(file.fleet)].type
        fleet.append(VehicleSpec(f"V{number + 1}", kind, node, FIRST_BATTERY_FRAC))
    return Plant(replace(file, fleet=tuple(fleet)))


def play_sizes(
    seed: int,
    counts: Sequence[int],
    kind: Kind = "raster",
    *,
    small: bool = False,
    hours: float = 1.0,
    traffic: bool = True,
) -> Iterator[FleetSize]:
    """Let each fleet work on the floor of a seed.

    Args:
        seed: decides the floor and its orders.
        counts: how many vehicles.
        kind: of plant.
        small: a few machines.
        hours: of demand, which is how long each run takes.
        traffic: whether vehicles drive with right of way.
    """
    floor = plant_of(seed, kind, small=small)
    for count in counts:
        plant = with_fleet(floor, count)
        shift = Shift(name="fleet sizes", duration_s=hours * 3600.0, load=LOAD)
        with with_right_of_way(traffic):
            report = play(shift, plant, seed).report
        yield _row(plant, report)


def _row(plant: Plant, report: Report) -> FleetSize:
    return FleetSize(
        vehicles=len(plant.fleet),
        places=len(plant.dwell_points) + len(plant.spare_places.clear) + len(plant.spare_places.reserve),
        transports=report.transports,
        pieces=report.pieces_delivered,
        p50_s=report.transport_p50_s,
        p95_s=report.transport_p95_s,
        starvation_frac=report.starvation_frac,
        invariants=report.invariants,
        most=most_vehicles(plant),
    )
