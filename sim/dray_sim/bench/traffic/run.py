"""One run of a lean world under one scheme, and its figures."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from statistics import quantiles

from dray.messages import Message
from dray.messages.floor.traffic import PlaceReservation, YieldAsked, YieldRefused
from dray.plant import Plant
from dray.protocol.traffic.neighbours import Neighbours
from dray.protocol.traffic.places import Footprint, Places
from dray.protocol.traffic.prices import Prices
from dray.protocol.traffic.reservations.copies import Kept
from dray.protocol.traffic.ways import Ways
from dray_sim.bench.traffic.air import Air, Quality
from dray_sim.bench.traffic.boxes import BoxMachine, BoxPilot
from dray_sim.bench.traffic.carrier import Carrier, Work
from dray_sim.bench.traffic.checks import STUCK_S, Checks, Found
from dray_sim.bench.traffic.clock import LeanClock
from dray_sim.bench.traffic.ghosts import Ghost
from dray_sim.bench.traffic.jobs import Poisson, Saturated


@dataclass(frozen=True, slots=True)
class Setting:
    """The parameters of a run.

    Attributes:
        plant: roads and fleet.
        seed: of transports and chance.
        span_s: virtual time.
        per_h: transports in an hour (Poisson); 0 for saturated.
        quality: of the network.
    """

    plant: Plant
    seed: int
    span_s: float = 1800.0
    per_h: float = 0.0
    quality: Quality = Quality()  # noqa: RUF009

    def work(self) -> Work:
        if self.per_h:
            return Poisson(self.plant, self.seed, self.per_h)
        return Saturated(self.plant, self.seed)


@dataclass(frozen=True, slots=True)
class Rules:
    """The rules of right of way in force; all of them, except in ablations.

    Attributes:
        yields: holders in the way are asked to make room.
        refuses: a holder with nowhere to go says so.
        groups: a dock is taken with its entry.
        prices: ways heed traffic, and the convention.
        reroutes: a vehicle that is held up looks for another way.
    """

    yields: bool = True
    refuses: bool = True
    groups: bool = True
    prices: bool = True
    reroutes: bool = True


WHOLE = Rules()

FIRST_COME = Rules(yields=False, refuses=False, groups=False, prices=False, reroutes=False)
"""Reserve the next node, first come: the simplest scheme, which deadlocks."""


class PlainWays(Ways):
    """The shortest ways, without regard to traffic."""

    def way(self, start: str, goal: str, prices: Prices | None = None) -> tuple[str, ...] | None:
        return super().way(start, goal)


@dataclass(slots=True)
class Figures:
    """The figures of a run.

    Attributes:
        per_h: transports in an hour.
        p50_s, p95_s: of a transport.
        longest_s: that any vehicle stood with somewhere to go.
        stuck: vehicles that stood for `STUCK_S`.
        said: messages to and from vehicles, per vehicle and second.
    """

    per_h: float
    p50_s: float
    p95_s: float
    longest_s: float
    stuck: int
    said: float
    wired: float = 0.0
    waiting_frac: float = 0.0
    found: Found = field(default_factory=Found)


def carriers_of(setting: Setting, clock: LeanClock) -> list[Carrier]:
    """The fleet, each where the plant file says."""
    plant, work = setting.plant, setting.work()
    homes = [plant.node_of(parking) for parking in plant.parkings]
    carriers = []
    for number, spec in enumerate(plant.fleet.values()):
        home = homes[number % len(homes)] if len(homes) >= len(plant.fleet) else ""
        kind = plant.vehicle_types[spec.type]
        carriers.append(Carrier(spec.id, plant, kind, spec.node, home, work, clock))

    def wake() -> None:
        for carrier in carriers:
            carrier.ask_for_work()

    work.start(clock, wake)
    clock.call_at(1.0, wake)
    return carriers


def run_ghosts(setting: Setting) -> Figures:
    """Run without right of way: vehicles pass through one another."""
    clock = LeanClock()
    carriers = carriers_of(setting, clock)
    for carrier in carriers:
        carrier.pilot = Ghost(carrier, setting.plant)
    clock.run(setting.span_s)
    return figures(setting, carriers, Found())


@dataclass(slots=True)
class World:
    """A lean world with right of way, ready to run."""

    clock: LeanClock
    air: Air
    carriers: list[Carrier]
    pilots: dict[str, BoxPilot]
    machines: dict[str, BoxMachine]
    checks: Checks
    places: Places
    setting: Setting


def build(
    setting: Setting,
    *,
    footprint: Footprint | None = None,
    rules: Rules = WHOLE,
) -> World:
    """A lean world in which every reservation table says where the vehicles stand."""
    plant = setting.plant
    clock = LeanClock()
    air = Air(clock, setting.quality, setting.seed)
    air.vehicles = frozenset(plant.fleet)
    footprint = footprint or Footprint()
    places = Places(plant, footprint)
    if not rules.groups:
        places.dock_entries = places.dead_ends = {}
    mute: set[type[Message]] = set()
    if not rules.yields:
        mute.add(YieldAsked)
    if not rules.refuses:
        mute.add(YieldRefused)
    air.mute = frozenset(mute)
    neighbours = Neighbours()
    carriers = carriers_of(setting, clock)
    ways = {
        kind: Ways(plant, places, spec) if rules.prices else PlainWays(plant, places, spec, convention=False)
        for kind, spec in plant.vehicle_types.items()
    }
    tables: dict[str, list[PlaceReservation]] = {district: [] for district in places.replicas_of}
    for spec in plant.fleet.values():
        place = places.place_of(spec.node)
        tables[places.district_of[place]].append(PlaceReservation(place=place, number=1, atv=spec.id))
    kept = {district: Kept(0, 0, 1, tuple(lines)) for district, lines in tables.items()}
    names = dict.fromkeys(name for replicas in places.replicas_of.values() for name in replicas)
    machines = {
        name: BoxMachine(
            name,
            places,
            tuple(plant.fleet),
            {d: k for d, k in kept.items() if name in places.replicas_of[d]},
            neighbours,
            clock,
            air,
        )
        for name in names
    }
    for machine in machines.values():
        machine.start()
    pilots = {}
    for number, carrier in enumerate(carriers):
        pilot = BoxPilot(carrier, places, ways[carrier.kind.id], neighbours, clock, air)
        pilot.reroutes = rules.reroutes
        carrier.pilot = pilot
        pilots[carrier.atv] = pilot
        pilot.start(0.1 + number / len(carriers))
    checks = Checks(carriers, pilots, machines, places, air, footprint, clock)
    checks.start()
    return World(clock, air, carriers, pilots, machines, checks, places, setting)


def run_boxes(
    setting: Setting, prepare: Callable[[World], None] | None = None, *, rules: Rules = WHOLE
) -> Figures:
    """Dray's own right of way, whole or with a rule left out."""
    world = build(setting, rules=rules)
    if prepare is not None:
        prepare(world)
    world.clock.run(setting.span_s)
    return finish(world)


def finish(world: World) -> Figures:
    """The figures of a world that has run."""
    result = figures(world.setting, world.carriers, world.checks.found)
    vehicle_s = len(world.carriers) * world.setting.span_s
    result.said = world.air.said / vehicle_s
    result.wired = world.air.wired / vehicle_s
    return result


def figures(setting: Setting, carriers: list[Carrier], found: Found) -> Figures:
    """The figures of the vehicles' transports and waits."""
    took = sorted(took_s for carrier in carriers for _, took_s in carrier.done)
    parts = quantiles(took, n=20) if len(took) > 1 else [0.0] * 19
    stands = [end_s - begin_s for carrier in carriers for begin_s, end_s in carrier.stands]
    stands += [setting.span_s - c.stood_since_s for c in carriers if c.stood_since_s is not None]
    stuck = sum(
        any(end_s - begin_s > STUCK_S for begin_s, end_s in c.stands)
        or (c.stood_since_s is not None and setting.span_s - c.stood_since_s > STUCK_S)
        for c in carriers
    )
    return Figures(
        per_h=len(took) * 3600.0 / setting.span_s,
        p50_s=parts[9],
        p95_s=parts[18],
        longest_s=max(stands, default=0.0),
        stuck=stuck,
        said=0.0,
        waiting_frac=sum(stands) / (len(carriers) * setting.span_s),
        found=found,
    )
