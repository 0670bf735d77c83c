"""One floor with smaller and larger fleets: more vehicles should never carry less.

The floor, its chargers and its parking places stay as they are. Each fleet works in several runs, with the same seeds
and so the same orders for all fleets.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from statistics import fmean

import msgspec
from msgspec.structs import replace

from dray.plant import Plant, VehicleSpec
from dray.plant.model import PlantFile
from dray.plant.planning.advice import most_vehicles
from dray_sim.plants.fall import Fall, fall_from_best, standard_error
from dray_sim.plants.many import play_each
from dray_sim.plants.play import Kind, plant_of
from dray_sim.plants.run_file import RunFile
from dray_sim.run.evidence import HELD
from dray_sim.run.stage import Shift, play, with_right_of_way

LOAD = 1.0
"""Part of the machines' time that orders take: more than a small fleet can carry."""

RUNS = 5
"""Runs of each fleet. One fleet carries 53 to 88 loads in half an hour, by the seed of the run alone."""

FIRST_BATTERY_FRAC = 0.8
"""Battery level of added vehicles."""


class Floor(msgspec.Struct, frozen=True):
    """A plant whose fleet is replaced.

    Attributes:
        name: tells it from other floors in a file of runs.
        file: the plant, with the first vehicles of all fleets.
    """

    name: str
    file: PlantFile


class Asked(msgspec.Struct, frozen=True):
    """A run to be made."""

    seed: int
    """Of the run: it decides its orders."""
    floor: Floor
    vehicles: int
    hours: float
    traffic: bool


class FleetRun(msgspec.Struct, frozen=True):
    """One run of one fleet."""

    seed: int
    """Of the run."""
    floor: str
    vehicles: int
    hours: float
    traffic: bool
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

    def answers(self, asked: Asked) -> bool:
        """Whether it is the run that was asked for."""
        this = (self.seed, self.floor, self.vehicles, self.hours, self.traffic)
        return this == (asked.seed, asked.floor.name, asked.vehicles, asked.hours, asked.traffic)


class FleetSize(msgspec.Struct, frozen=True):
    """All runs of one fleet.

    Attributes:
        runs: at least one, in the order of their seeds.
        transports: mean of the runs.
        transports_error: its standard error.
        pieces: likewise.
        pieces_error: likewise.
        fall: against the smaller fleet that carries most; None without a smaller one.
    """

    vehicles: int
    runs: tuple[FleetRun, ...]
    transports: float
    transports_error: float
    pieces: float
    pieces_error: float
    fall: Fall | None

    @property
    def holds(self) -> bool:
        """Whether no invariant was broken."""
        return all(run.invariants == HELD for run in self.runs)

    def tell(self) -> str:
        """A row of the table."""
        first = self.runs[0]
        broken = "".join(f" seed {run.seed}: {run.invariants}" for run in self.runs if run.invariants != HELD)
        named = f"; too many: the floor bears {first.most} at most" if first.most < self.vehicles else ""
        p50_s, p95_s = fmean(run.p50_s for run in self.runs), fmean(run.p95_s for run in self.runs)
        starving = fmean(run.starvation_frac for run in self.runs)
        against = self.fall.tell() if self.fall else "no smaller fleet"
        return (
            f"{self.vehicles:8d} {first.places:6d} {len(self.runs):4d} "
            f"{_told(self.transports, self.transports_error)} {_told(self.pieces, self.pieces_error)} "
            f"{p50_s:6.0f} {p95_s:6.0f} {starving:8.1%}  {against}{named}{broken}"
        )


HEADING = (
    f"{'vehicles':>8} {'places':>6} {'runs':>4} {'transports':>13} {'pieces':>13} {'p50 s':>6} {'p95 s':>6} "
    f"{'starving':>8}  transports against the best smaller fleet"
)


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


def drawn_floor(seed: int, kind: Kind = "raster", *, small: bool = False) -> Floor:
    """The floor of a seed."""
    return Floor(f"{kind} {seed}{' small' if small else ''}", plant_of(seed, kind, small=small).file)


def play_sizes(
    floor: Floor,
    counts: Sequence[int],
    *,
    runs: int = RUNS,
    hours: float = 1.0,
    traffic: bool = True,
    jobs: int = 1,
    keep: RunFile[FleetRun] | None = None,
) -> Iterator[FleetSize]:
    """Let each fleet work on a floor, in several runs.

    Args:
        floor: for all fleets.
        counts: how many vehicles; fewer where the floor has no nodes for so many. Smaller fleets come first.
        runs: of each fleet, with the seeds 1, 2 and so on.
        hours: of demand, which is how long each run takes.
        traffic: whether vehicles drive with right of way.
        jobs: processes.
        keep: runs that are in it are not made again, and each new one is added at once.

    Raises:
        UnavailableError: a process was killed from outside, or the file cannot be written.
    """
    room = len(with_fleet(Plant(floor.file), max(counts)).fleet)
    sizes, seeds = sorted({min(count, room) for count in counts}), range(1, runs + 1)
    asked = [Asked(seed, floor, size, hours, traffic) for size in sizes for seed in seeds]
    made: dict[int, dict[int, FleetRun]] = {size: {} for size in sizes}
    missing: list[Asked] = []
    for each in asked:
        kept = next((run for run in keep.kept if run.answers(each)), None) if keep else None
        if kept is None:
            missing.append(each)
        else:
            made[each.vehicles][each.seed] = kept
    still_to_come = play_each(play_run, missing, jobs=jobs, at_once=True)
    smaller: dict[int, dict[int, float]] = {}
    for size in sizes:
        while len(made[size]) < runs:
            run = next(still_to_come)
            made[run.vehicles][run.seed] = run
            if keep is not None:
                keep.add(run)
        row = _row([made[size][seed] for seed in seeds], smaller)
        smaller[size] = {run.seed: run.transports for run in row.runs}
        yield row


def play_run(asked: Asked) -> FleetRun:
    """Let one fleet work once."""
    plant = with_fleet(Plant(asked.floor.file), asked.vehicles)
    shift = Shift(name="fleet sizes", duration_s=asked.hours * 3600.0, load=LOAD)
    with with_right_of_way(asked.traffic):
        report = play(shift, plant, asked.seed).report
    return FleetRun(
        seed=asked.seed,
        floor=asked.floor.name,
        vehicles=asked.vehicles,
        hours=asked.hours,
        traffic=asked.traffic,
        places=len(plant.dwell_points) + len(plant.spare_places.clear) + len(plant.spare_places.reserve),
        transports=report.transports,
        pieces=report.pieces_delivered,
        p50_s=report.transport_p50_s,
        p95_s=report.transport_p95_s,
        starvation_frac=report.starvation_frac,
        invariants=report.invariants,
        most=most_vehicles(plant),
    )


def _row(runs: Sequence[FleetRun], smaller: Mapping[int, Mapping[int, float]]) -> FleetSize:
    transports, pieces = [run.transports for run in runs], [run.pieces for run in runs]
    return FleetSize(
        vehicles=runs[0].vehicles,
        runs=tuple(runs),
        transports=fmean(transports),
        transports_error=standard_error(transports),
        pieces=fmean(pieces),
        pieces_error=standard_error(pieces),
        fall=fall_from_best(smaller, {run.seed: run.transports for run in runs}),
    )


def _told(mean: float, error: float) -> str:
    """A mean and its standard error, if there is one."""
    return f"{mean:6.1f} ± {error:4.1f}" if math.isfinite(error) else f"{mean:6.1f}       "
