"""Whole schedules of faults, drawn from a seed: the weather of a search.

Faults begin as in a Poisson process, so they overlap as independent mishaps do; each lasts for a time that fits its
kind. Everything has ended by a given moment: after it a search asks that everything comes to its end.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from random import Random

from msgspec.structs import replace

from dray.messages import Problem, ProblemKind
from dray.plant import Plant
from dray_sim.faults.kinds import (
    ClockSet,
    Crashed,
    DoorFailed,
    Fault,
    JournalLost,
    LaneBlocked,
    LoadDropped,
    LoadShifted,
    MachineBroken,
    PoweredOff,
    SentAway,
    Thing,
    VehicleBroken,
)
from dray_sim.faults.names import Cast
from dray_sim.faults.schedule import Timed
from dray_sim.network.coverage import access_points_of
from dray_sim.network.faults import AccessPointDown, CoverageHole, LinkTrouble, Partition, RadioCut, WlanCut

KILLED_S = 90.0
"""Six times as long as strategists wait for one another, at most."""

MEAN_GAP_S = 60.0
"""Between the beginnings of two faults at intensity 1: rare enough that something goes on between them."""

MAX_FAULTS = 500
"""Most faults in one schedule; a higher intensity would only mean standstill."""

WEIGHTS: Mapping[type[Fault], float] = {
    WlanCut: 4.0,
    LinkTrouble: 4.0,
    PoweredOff: 3.0,
    Crashed: 3.0,
    VehicleBroken: 2.0,
    LoadShifted: 2.0,
    MachineBroken: 2.0,
    Partition: 2.0,
    CoverageHole: 2.0,
    RadioCut: 1.0,
    AccessPointDown: 1.0,
}
"""Relative frequency of each kind: the most frequent ones strike a transport in the middle."""

LEAVING: Mapping[type[Fault], float] = {SentAway: 1.0}
"""Agents that leave and come back are no mishap, and drawn apart."""

OBSTACLES: Mapping[type[Fault], float] = {LaneBlocked: 1.0}
"""Obstacles on lanes are drawn separately."""

DROPPED: Mapping[type[Fault], float] = {LoadDropped: 1.0}
"""Loads that vehicles lose on lanes are drawn separately, too."""

DOORS: Mapping[type[Fault], float] = {DoorFailed: 1.0}
"""Doors that fail, likewise; only where there are any."""

CLOCKS: Mapping[type[Fault], float] = {ClockSet: 1.0}
"""Wrong clocks are drawn separately, too: a wrong clock alone does not put an agent in trouble."""

VEHICLE_BACK_S = 2.0
"""A vehicle whose next life begins this soon is not suspected: it beats once a second at work, and 3.5 s count as
silence."""

COORDINATOR_BACK_S = 10.0
"""A machine or the strategist likewise: a machine keeps its goals for 15 s of silence."""

LONGEST_GAP_S = 5.0
"""Longest gap between two agents of a wave: longer than any step of an agent's start."""

LEAST_STEP_S, LARGEST_STEP_S = 0.05, 60.0
"""Range of the errors of clocks, uniform on a logarithmic scale: from NTP's remaining error to a person's mistake."""

LONGEST_PROBATION = 3
"""Transports; more than that hardly anybody does in a short run."""

SHORT_S, LONG_S = 2.0, 240.0
"""Range of the durations of faults, uniform on a logarithmic scale: below every bound of suspicion, and above."""

BAD_LINK_FRAC = 0.4
"""Up to here loss, doubling and reordering go: beyond 40 % the paper's own network is down (case 3)."""

LONG_DELAY_S = 5.0
"""Up to here delays go, as in the latency sweep."""


def random_schedule(
    plant: Plant,
    random: Random,
    duration_s: float,
    intensity: float = 1.0,
    *,
    from_s: float = 0.0,
    weights: Mapping[type[Fault], float] = WEIGHTS,
) -> tuple[Timed, ...]:
    """Draw a schedule; the same for the same arguments, in every process.

    Args:
        plant: its agents and things can fail.
        random: the only source of chance.
        duration_s: by then every fault has ended (plant clock).
        intensity: faults in a minute, on average; 0 for none.
        from_s: no fault begins before.
        weights: the kinds that may happen, and how often each is drawn against the others.

    Returns:
        Faults in the order in which they begin; all of them end.
    """
    schedule: list[Timed] = []
    if intensity <= 0.0 or not weights:
        return ()
    kinds, shares = tuple(weights), tuple(weights.values())
    at_s = from_s
    while len(schedule) < MAX_FAULTS:
        at_s += random.expovariate(intensity / MEAN_GAP_S)
        begin_s = _neat(at_s)
        if begin_s + SHORT_S > duration_s:
            break
        kind = random.choices(kinds, shares)[0]
        lasts_s = SHORT_S * (LONG_S / SHORT_S) ** random.random()
        end_s = min(_neat(begin_s + lasts_s), duration_s)
        fault = _DRAW[kind](plant, random)
        if isinstance(fault, VehicleBroken):
            fault = replace(fault, problem=_problem(Random(f"problem at {begin_s}")))
        schedule.append(Timed(begin_s, fault, end_s))
    return tuple(schedule)


def random_waves(plant: Plant, random: Random, duration_s: float, intensity: float) -> tuple[Timed, ...]:
    """Draw restarts of whole sets of agents, in any order: crashes that end so soon that they should cost nothing.

    Args:
        plant: its agents restart.
        random: the only source of chance.
        duration_s: by then all are back (plant clock).
        intensity: waves in a minute, on average.
    """
    cast = Cast.of_plant(plant)
    waves: list[Timed] = []
    at_s = random.expovariate(intensity / MEAN_GAP_S)
    while at_s < duration_s and len(waves) < MAX_FAULTS:
        for agent in _some_agents(cast, random):
            down_s = COORDINATOR_BACK_S if agent not in cast.vehicles else VEHICLE_BACK_S
            end_s = at_s + random.uniform(0.01, down_s)
            if end_s < duration_s:
                waves.append(Timed(_neat(at_s), Crashed(agent), _neat(end_s)))
            at_s += random.choice((0.0, random.uniform(0.0, LONGEST_GAP_S)))
        at_s += random.expovariate(intensity / MEAN_GAP_S)
    return tuple(sorted(waves, key=lambda timed: timed.at_s))


def random_kills(agents: tuple[str, ...], random: Random, duration_s: float) -> tuple[Timed, ...]:
    """Kill one of these agents after another, for times too short to be missed and for much longer ones.

    Args:
        agents: to be killed.
        random: the only source of chance.
        duration_s: by then all are back (plant clock).
    """
    kills: list[Timed] = []
    at_s = random.expovariate(1.0 / MEAN_GAP_S)
    while at_s < duration_s:
        end_s = at_s + random.uniform(0.01, KILLED_S)
        if end_s < duration_s:
            kills.append(Timed(_neat(at_s), Crashed(random.choice(agents)), _neat(end_s)))
        at_s += random.expovariate(1.0 / MEAN_GAP_S)
    return tuple(kills)


def _some_agents(cast: Cast, random: Random) -> list[str]:
    """All machines before all vehicles, or the other way round, or a mixture; some kinds not at all."""
    groups = [list(group) for group in (cast.machines, cast.vehicles, cast.others) if random.random() < 0.7]
    for group in groups:
        random.shuffle(group)
        if random.random() < 0.5:
            del group[random.randint(1, len(group)) :]
    random.shuffle(groups)
    agents = [agent for group in groups for agent in group]
    if random.random() < 0.5:
        random.shuffle(agents)
    return agents


def _problem(random: Random) -> Problem:
    """A problem of any kind, with true, false or no details."""
    know = (None, False, True)
    kind = random.choice(tuple(ProblemKind))
    return Problem(kind, random.choice(know), random.choice(know), random.choice(know))


def _neat(seconds: float) -> float:
    """Round to a hundredth, so that a schedule reads well."""
    return round(seconds, 2)


def _vehicle(plant: Plant, random: Random) -> str:
    return random.choice(tuple(plant.fleet))


def _machine(plant: Plant, random: Random) -> str:
    return random.choice(tuple(plant.machines))


def _agent(plant: Plant, random: Random) -> str:
    """Anybody with a process; vehicles as often as all others together, for they do the work."""
    cast = Cast.of_plant(plant)
    group = cast.vehicles if random.random() < 0.5 else (*cast.machines, *cast.others)
    return random.choice(group)


def _forgetful(plant: Plant, random: Random) -> str:
    """Any agent except the strategist, whose promises are only in its notes and the gateway's database."""
    kinds = (tuple(plant.machines), tuple(plant.stores), tuple(plant.fleet), tuple(plant.fleet))
    return random.choice(random.choice(kinds))


def _step_s(random: Random) -> float:
    size_s = LEAST_STEP_S * (LARGEST_STEP_S / LEAST_STEP_S) ** random.random()
    return _neat(random.choice((-size_s, size_s)))


def _body(plant: Plant, random: Random) -> str:
    return _vehicle(plant, random) if random.random() < 0.7 else _machine(plant, random)


def _some_frac(random: Random) -> float:
    """Often none at all, so that every trouble is seen alone, too."""
    return _neat(random.uniform(0.05, BAD_LINK_FRAC)) if random.random() < 0.5 else 0.0


def _draw_trouble(plant: Plant, random: Random) -> Fault:
    ends = ["*", "*"]
    if random.random() < 0.7:
        ends[random.randrange(2)] = _agent(plant, random)
    slow = random.random() < 0.4
    return LinkTrouble(
        sender=ends[0],
        receiver=ends[1],
        latency_s=_neat(random.uniform(0.1, LONG_DELAY_S)) if slow else 0.0,
        jitter_s=_neat(random.uniform(0.0, 1.0)) if slow else 0.0,
        loss_frac=_some_frac(random),
        duplicate_frac=_some_frac(random),
        reorder_frac=_some_frac(random),
    )


def _draw_partition(plant: Plant, random: Random) -> Fault:
    """Cut one part of the factory off: some machines with some vehicles."""
    agents = Cast.of_plant(plant).agents
    apart = tuple(agent for agent in agents if random.random() < 0.4)
    return Partition(groups=(apart or (random.choice(agents),),))


def _draw_obstacle(plant: Plant, random: Random) -> Fault:
    lane = random.choice(plant.roads.lanes)
    return LaneBlocked(lane.start, lane.end, random.choice(tuple(Thing)))


def _draw_hole(plant: Plant, random: Random) -> Fault:
    return CoverageHole(
        x_m=round(random.uniform(0.0, plant.width_m), 1),
        y_m=round(random.uniform(0.0, plant.height_m), 1),
        radius_m=round(random.uniform(3.0, 15.0), 1),
    )


_DRAW: Mapping[type[Fault], Callable[[Plant, Random], Fault]] = {
    WlanCut: lambda plant, random: WlanCut(_agent(plant, random)),
    RadioCut: lambda plant, random: RadioCut(_vehicle(plant, random)),
    LinkTrouble: _draw_trouble,
    Partition: _draw_partition,
    CoverageHole: _draw_hole,
    LaneBlocked: _draw_obstacle,
    DoorFailed: lambda plant, random: DoorFailed(random.choice(tuple(plant.doors))),
    AccessPointDown: lambda plant, random: AccessPointDown(random.choice(access_points_of(plant)).id),
    PoweredOff: lambda plant, random: PoweredOff(_body(plant, random)),
    Crashed: lambda plant, random: Crashed(_agent(plant, random)),
    JournalLost: lambda plant, random: JournalLost(_forgetful(plant, random)),
    ClockSet: lambda plant, random: ClockSet(_agent(plant, random), _step_s(random)),
    SentAway: lambda plant, random: SentAway(_agent(plant, random), random.randint(0, LONGEST_PROBATION)),
    MachineBroken: lambda plant, random: MachineBroken(_machine(plant, random)),
    VehicleBroken: lambda plant, random: VehicleBroken(_vehicle(plant, random)),
    LoadDropped: lambda plant, random: LoadDropped(_vehicle(plant, random)),
    LoadShifted: lambda plant, random: LoadShifted(_vehicle(plant, random)),
}
