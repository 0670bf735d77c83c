"""What one seed of the search stands for: a plant, a load, a schedule of faults and the people in it.

Everything is drawn here, before anything runs, so that a trial can be shown and replayed. Plants are
small: what is wrong in a protocol goes wrong between a handful of agents, and a hundred small trials
meet more of it than one large one.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from math import ceil
from random import Random

import msgspec

from dray.plant import (
    MachineSpec,
    Making,
    Material,
    Plant,
    PlantFile,
    Product,
    VehicleSpec,
    VehicleType,
)
from dray_sim.faults import (
    CLOCKS,
    LEAVING,
    WEIGHTS,
    CoverageHole,
    Crashed,
    Fault,
    JournalLost,
    LinkTrouble,
    LoadShifted,
    Partition,
    PoweredOff,
    Timed,
    VehicleBroken,
    WlanCut,
    describe,
    random_schedule,
    random_waves,
)
from dray_sim.insiders import BEHAVIOURS
from dray_sim.people import demand
from dray_sim.people.habits import Habits
from dray_sim.people.revoker import Revised
from dray_sim.plants.generator import generate_plant

DURATION_S = 1200.0
"""The least virtual time of a trial."""

FAULTS_UNTIL_S = 900.0
"""Then every fault has ended and no order comes any more: the calm in which everything must end."""

TRANSPORT_S = 120.0
"""What a vehicle needs for a transport in a small plant, about: the demand is held below what the fleet carries."""

TAKEN_BACK_TIMES = (1, 1, 1, 2, 3)
"""How often an order is taken back that is taken back at all."""

LONGEST_REST_S = 120.0
"""How long an order rests before it is published again: long enough for its goals to be gone, and for goods
that were on the way to have found the gate shut."""

BATTERY_SHARE = (0.08, 0.25)
"""Of the usual battery: it lasts for ten minutes to an hour, and is charged in three to a quarter of an hour."""

LEAST_LOT = 2
"""Pieces in the smallest container of a trial."""


@dataclass(frozen=True, slots=True)
class Profile:
    """From where trials are drawn. Pairs are from and to, both included.

    Attributes:
        machines, vehicles: the size of the plant.
        lot_frac: containers and buffers against those of the default plant: small ones make many transports.
        cycle_frac: how long machines take for a piece, likewise.
        load: the demand against what machines and vehicles can do, whichever is less.
        stock_frac: how full buffers are at the beginning.
        battery_frac: of the vehicles at the beginning.
        intensity: faults in a minute.
        weights: which kinds of faults, and how often each against the others.
        leaving_frac: the part of the trials in which agents leave in order and come back.
        leaving: how many of them in a minute.
        waves_frac: the part of the trials in which whole sets of agents are restarted, in any order.
        waves: how many times in a minute.
        clocks_frac: the part of the trials in which computers' clocks are set wrong, and right again.
        clocks: how often in a minute.
        operators_frac: the part of the trials with operators.
        passerby_frac: the part in which somebody presses buttons at random.
        cancelled_frac: the part of the orders that customers cancel.
        revising_frac: the part of the trials in which managers take orders back and publish them again.
        revised_frac: in these, the part of the orders.
        insiders_frac: the part of the trials in which somebody lies who has a valid certificate.
        scarce_power: whether batteries are so small that they are emptied and charged in minutes, and chargers and
            parking places few; the chargers suffice.
    """

    machines: tuple[int, int] = (1, 6)
    vehicles: tuple[int, int] = (1, 6)
    lot_frac: tuple[float, float] = (0.1, 0.3)
    cycle_frac: tuple[float, float] = (0.2, 0.8)
    load: tuple[float, float] = (0.5, 1.5)
    stock_frac: tuple[float, float] = (0.0, 0.8)
    battery_frac: tuple[float, float] = (0.6, 1.0)
    intensity: tuple[float, float] = (0.2, 4.0)
    weights: Mapping[type[Fault], float] = field(default_factory=lambda: WEIGHTS)
    leaving_frac: float = 0.0
    leaving: tuple[float, float] = (0.2, 2.0)
    waves_frac: float = 0.0
    waves: tuple[float, float] = (0.1, 1.0)
    clocks_frac: float = 0.0
    clocks: tuple[float, float] = (0.2, 4.0)
    operators_frac: float = 0.7
    passerby_frac: float = 0.4
    cancelled_frac: float = 0.1
    revising_frac: float = 0.3
    revised_frac: float = 0.4
    insiders_frac: float = 0.0
    scarce_power: bool = False


PROFILES: Mapping[str, Profile] = {
    "all": Profile(
        weights={**WEIGHTS, JournalLost: 1.0},
        leaving_frac=0.3,
        waves_frac=0.3,
        clocks_frac=0.3,
        insiders_frac=0.2,
    ),
    "mishaps": Profile(leaving_frac=0.3),
    "deaths": Profile(weights={PoweredOff: 2.0, Crashed: 1.0}, passerby_frac=0.0),
    "links": Profile(weights={WlanCut: 2.0, LinkTrouble: 4.0, Partition: 2.0, CoverageHole: 1.0}),
    "answers": Profile(
        weights={LinkTrouble: 1.0}, intensity=(3.0, 8.0), operators_frac=0.0, passerby_frac=0.0
    ),
    "hands": Profile(weights={VehicleBroken: 1.0, LoadShifted: 2.0}, operators_frac=1.0, passerby_frac=1.0),
    "revisions": Profile(revising_frac=1.0, revised_frac=0.8),
    "updates": Profile(intensity=(0.0, 1.0), leaving_frac=1.0, leaving=(0.5, 4.0), passerby_frac=0.2),
    "restarts": Profile(
        intensity=(0.0, 0.3), passerby_frac=0.0, operators_frac=0.3, waves_frac=1.0, waves=(0.3, 3.0)
    ),
    "notes": Profile(
        weights={JournalLost: 2.0, Crashed: 1.0, PoweredOff: 0.5}, waves_frac=0.5, passerby_frac=0.0
    ),
    "clocks": Profile(intensity=(0.0, 1.0), waves_frac=0.5, clocks_frac=1.0),
    "liars": Profile(intensity=(0.0, 0.5), operators_frac=0.0, passerby_frac=0.0, insiders_frac=1.0),
    "calm": Profile(intensity=(0.0, 0.0), passerby_frac=0.0),
    "batteries": Profile(
        vehicles=(1, 10), battery_frac=(0.2, 0.9), intensity=(0.0, 0.0), passerby_frac=0.0, scarce_power=True
    ),
}
"""By name, as `dray sim explore --profile` takes them."""


@dataclass(frozen=True, slots=True)
class Trial:
    """One run of the search, wholly decided.

    Attributes:
        seed: it follows from this, and from the profile.
        profile: the name of the profile.
        load: part of the machines' time that the demand takes.
        faults_until_s: the calm begins then.
        duration_s: it lasts at least so long, and on until everything has ended.
        orders: the demand.
        codec: whether all messages go through the wire format.
        habits: of the operators; None where there are none.
        passerby: whether somebody presses buttons at random.
        cancelled: orders that are cancelled, and when (plant clock), in the order of their times.
        revised: orders that are taken back and published again.
        insider: how somebody lies until the calm (`dray_sim.insiders`); empty where nobody does.
    """

    seed: int
    profile: str
    plant: Plant
    load: float
    stock_frac: tuple[float, float]
    faults_until_s: float
    duration_s: float
    codec: bool
    habits: Habits | None
    passerby: bool
    orders: tuple[demand.Order, ...] = field(repr=False)
    schedule: tuple[Timed, ...] = field(repr=False)
    cancelled: tuple[tuple[float, str], ...] = field(repr=False)
    revised: tuple[Revised, ...] = field(repr=False)
    insider: str = ""

    @property
    def has_faults(self) -> bool:
        """Whether anything goes wrong in it."""
        return bool(self.schedule or self.passerby or self.insider)

    def __str__(self) -> str:
        """In one line, for a reader."""
        parts = (
            f"{len(self.plant.machines)} machines",
            f"{len(self.plant.fleet)} vehicles",
            f"{len(self.orders)} orders ({len(self.cancelled)} cancelled, {len(self.revised)} taken back)",
            f"load {self.load:.0%}",
            f"{len(self.schedule)} faults",
            "operators" if self.habits is not None else "no operators",
        )
        more = ("a passerby",) * self.passerby + (f"one that {self.insider}",) * bool(self.insider)
        return ", ".join((*parts, *more))

    def timetable(self) -> list[str]:
        """What will go wrong, and when, line by line."""
        return [
            f"{timed.at_s:7.1f} to {timed.until_s or self.faults_until_s:7.1f} s  {describe(timed.fault)}"
            for timed in self.schedule
        ]


def draw(seed: int, profile: str = "all") -> Trial:
    """The trial of a seed; the same in every process.

    Args:
        seed: decides everything.
        profile: a name in `PROFILES`.
    """
    ranges = PROFILES[profile]
    random = Random(f"{seed} trial")
    plant = _small_plant(seed, ranges, random)
    load = random.uniform(*ranges.load) * min(1.0, _bearable_load(plant))
    emptiest = random.uniform(*ranges.stock_frac)
    orders = tuple(demand.orders(plant, Random(f"{seed} demand"), load=load, until_s=FAULTS_UNTIL_S))
    return Trial(
        seed=seed,
        profile=profile,
        plant=plant,
        load=load,
        stock_frac=(emptiest, max(emptiest, ranges.stock_frac[1])),
        faults_until_s=FAULTS_UNTIL_S,
        duration_s=DURATION_S,
        # It costs time and finds little that the other nine would not: some of them see that it is harmless.
        codec=random.random() < 0.1,
        habits=_habits(random) if random.random() < ranges.operators_frac else None,
        passerby=random.random() < ranges.passerby_frac,
        orders=orders,
        schedule=_schedule(seed, plant, ranges, random.uniform(*ranges.intensity)),
        cancelled=_cancelled(orders, ranges.cancelled_frac, Random(f"{seed} regret")),
        revised=_revised(orders, ranges, Random(f"{seed} revised")),
        insider=_insider(ranges, Random(f"{seed} insider")),
    )


def _insider(ranges: Profile, random: Random) -> str:
    """How somebody lies who never moves; one that drives would leave its loads to the calm."""
    if random.random() >= ranges.insiders_frac:
        return ""
    return random.choice([name for name, behaviour in BEHAVIOURS.items() if not behaviour.drives])


def _schedule(seed: int, plant: Plant, ranges: Profile, intensity: float) -> tuple[Timed, ...]:
    """Mishaps, agents that leave or are restarted, and clocks that are set, in the order in which they begin."""
    schedule = list(
        random_schedule(plant, Random(f"{seed} faults"), FAULTS_UNTIL_S, intensity, weights=ranges.weights)
    )
    random = Random(f"{seed} sent away")
    if random.random() < ranges.leaving_frac:
        a_minute = random.uniform(*ranges.leaving)
        schedule += random_schedule(plant, random, FAULTS_UNTIL_S, a_minute, weights=LEAVING)
    random = Random(f"{seed} waves")
    if random.random() < ranges.waves_frac:
        schedule += random_waves(plant, random, FAULTS_UNTIL_S, random.uniform(*ranges.waves))
    random = Random(f"{seed} clocks")
    if random.random() < ranges.clocks_frac:
        a_minute = random.uniform(*ranges.clocks)
        schedule += random_schedule(plant, random, FAULTS_UNTIL_S, a_minute, weights=CLOCKS)
    return tuple(sorted(schedule, key=lambda timed: timed.at_s))


def _cancelled(
    orders: tuple[demand.Order, ...], frac: float, random: Random
) -> tuple[tuple[float, str], ...]:
    """Some are cancelled at once, most while they are made."""
    regretted = [order for order in orders if random.random() < frac]
    return tuple(sorted((random.uniform(order.at_s, FAULTS_UNTIL_S), order.id) for order in regretted))


def _revised(orders: tuple[demand.Order, ...], ranges: Profile, random: Random) -> tuple[Revised, ...]:
    """Taken back at any moment of their lives, some more than once, and published again at once or later."""
    if random.random() >= ranges.revising_frac:
        return ()
    return tuple(
        Revised(order, tuple(_takings_back(order.at_s, random)))
        for order in orders
        if random.random() < ranges.revised_frac
    )


def _takings_back(placed_s: float, random: Random) -> Iterator[tuple[float, float]]:
    at_s = placed_s
    for _ in range(random.choice(TAKEN_BACK_TIMES)):
        at_s = random.uniform(at_s, FAULTS_UNTIL_S)
        again_s = min(at_s + random.choice((0.0, random.uniform(0.0, LONGEST_REST_S))), FAULTS_UNTIL_S)
        yield at_s, again_s
        at_s = again_s


def _habits(random: Random) -> Habits:
    """Quick people, since trials are short; some promise more than they keep."""
    return Habits(
        react_s=(1.0, random.uniform(2.0, 15.0)),
        promises_frac=random.random(),
        estimate=(random.uniform(0.3, 1.0), 1.5),
        walk_s=(5.0, 30.0),
        mend_s=(5.0, random.uniform(10.0, 60.0)),
        carry_s=(10.0, 30.0),
        push_s=(10.0, 30.0),
        silent_s=random.uniform(10.0, 40.0),
        slow_frac=random.uniform(0.3, 1.0),
    )


def _bearable_load(plant: Plant) -> float:
    """Part of the machines' time at which the whole fleet is busy all the time."""
    busy_frac = 0.0
    for product in plant.products.values():
        loads = 1.0 / product.lot + sum(
            line.quantity / plant.materials[line.material].lot for line in product.bill
        )
        busy_frac += loads * TRANSPORT_S / demand.mean_cycle_s(plant, product.id) / len(plant.products)
    return len(plant.fleet) / (len(plant.machines) * busy_frac)


def _small_plant(seed: int, ranges: Profile, random: Random) -> Plant:
    """A generated plant whose containers and buffers are small, so that a lot is carried in a short time."""
    machines, vehicles = random.randint(*ranges.machines), random.randint(*ranges.vehicles)
    lot_frac, cycle_frac = random.uniform(*ranges.lot_frac), random.uniform(*ranges.cycle_frac)
    file = generate_plant(seed, machines, vehicles).file
    fleet = tuple(_charged(spec, random.uniform(*ranges.battery_frac)) for spec in file.fleet)
    if ranges.scarce_power:
        file = with_scarce_power(file, Random(f"{seed} power"))
    return Plant(
        msgspec.structs.replace(
            file,
            materials=tuple(_small_material(each, lot_frac) for each in file.materials),
            products=tuple(_small_product(each, lot_frac) for each in file.products),
            machines=tuple(_quick(each, lot_frac, cycle_frac) for each in file.machines),
            fleet=fleet,
        )
    )


def with_scarce_power(file: PlantFile, random: Random) -> PlantFile:
    """The same plant with small batteries, and with as few chargers and parking places as can do, or more.

    Chargers suffice when they give what the whole fleet would need if it drove all the time: it does so for half of
    its time at most, and the rest is for ways to chargers and waits.
    """
    share = random.uniform(*BATTERY_SHARE)
    kinds = {kind.id: kind for kind in file.vehicle_types}
    needs_w = sum(_driving_w(kinds[spec.type]) for spec in file.fleet)
    least = ceil(needs_w / min(kind.charge_w for kind in kinds.values()))
    chargers = random.randint(min(least, len(file.chargers)), len(file.chargers))
    return msgspec.structs.replace(
        file,
        vehicle_types=tuple(
            msgspec.structs.replace(kind, battery_wh=kind.battery_wh * share) for kind in file.vehicle_types
        ),
        chargers=file.chargers[:chargers],
        parkings=file.parkings[: random.randint(0, len(file.parkings))],
    )


def _driving_w(kind: VehicleType) -> float:
    """What a vehicle takes that drives all the time, half of it with a load (W)."""
    wh_per_m = (kind.drive_wh_per_m + kind.loaded_wh_per_m) / 2.0
    return kind.idle_w + wh_per_m * kind.max_speed_mps * 3600.0


def _small_material(material: Material, frac: float) -> Material:
    lot = _lot(material.lot, frac)
    return msgspec.structs.replace(material, lot=lot, buffer=3 * lot)


def _small_product(product: Product, frac: float) -> Product:
    return msgspec.structs.replace(product, lot=_lot(product.lot, frac))


def _quick(machine: MachineSpec, lot_frac: float, cycle_frac: float) -> MachineSpec:
    """Short cycles; few goods wait, as few are in a container."""
    makes = tuple(Making(making.product, making.cycle_s * cycle_frac) for making in machine.makes)
    room = max(_lot(machine.goods_capacity, lot_frac), 2 * LEAST_LOT)
    return msgspec.structs.replace(machine, makes=makes, goods_capacity=room)


def _lot(lot: int, frac: float) -> int:
    return max(LEAST_LOT, ceil(lot * frac))


def _charged(spec: VehicleSpec, battery_frac: float) -> VehicleSpec:
    return msgspec.structs.replace(spec, battery_frac=round(battery_frac, 2))
