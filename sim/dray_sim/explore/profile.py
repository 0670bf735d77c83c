"""Distributions of the runs of a search: ranges, and the fraction of runs that have a feature."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from dray_sim.faults import (
    WEIGHTS,
    CoverageHole,
    Crashed,
    Fault,
    JournalLost,
    LinkTrouble,
    LoadShifted,
    MachineBroken,
    Partition,
    PoweredOff,
    VehicleBroken,
    WlanCut,
)


@dataclass(frozen=True, slots=True)
class Profile:
    """A distribution of runs. Pairs are from and to, both included.

    Attributes:
        machines, vehicles: the size of the plant.
        lot_frac: containers and buffers against those of the default plant: small ones make many transports.
        cycle_frac: how long machines take for a piece, likewise.
        load: the demand relative to the capacity of the machines or the vehicles, whichever is less.
        stock_frac: how full buffers are at the beginning.
        battery_frac: of the vehicles at the beginning.
        intensity: faults in a minute.
        weights: which kinds of faults, and how often each against the others.
        leaving_frac: the part of the runs in which agents shut down gracefully and come back.
        leaving: how many of them in a minute.
        waves_frac: the part of the runs in which whole sets of agents are restarted, in any order.
        waves: how many times in a minute.
        clocks_frac: the part of the runs in which computers' clocks are set wrong, and right again.
        clocks: how often in a minute.
        obstacles_frac: the part of the runs in which something is put on lanes.
        obstacles: how often in a minute.
        doors_frac: the part of the runs in plants with doors, which fail as often as something is put on lanes.
        operators_frac: the part of the runs with operators.
        random_operator_frac: the part in which a person presses buttons at random.
        cancelled_frac: the part of the orders that customers cancel.
        revoking_frac: the part of the runs in which managers take orders back and publish them again.
        revoked_frac: in these, the part of the orders.
        insiders_frac: the part of the runs in which an agent with a valid certificate lies.
        carried_frac: the part of the runs with right of way in which people carry vehicles away and put them back.
        closures_frac: the part of the runs in which a manager closes lanes, nodes and areas.
        calls_frac: the part of the runs in which people call transports.
        things_frac: in these, the part of the calls that are for uncounted things.
        levels_frac: the part of the runs in plants of two machines and more in which some make parts for others.
        scrap_frac: the part of the runs in which machines make bad pieces.
        priorities_frac: the part of the runs in which orders have priorities.
        stations_frac: the part of the runs in plants with storages that vehicles refill, or where machines fetch in the warehouse.
        rests_frac: the part of the runs in which machines rest now and then by their working time.
        bodies_frac: the part of the runs in which machines, stores and the gate are controllers, whose wires are cut.
        damaged_frac: the part of these in which the memories of some of their bodies are damaged.
        strategists: how many there are; where there are several, they are killed one after the other.
        scarce_power: whether batteries are so small that they are emptied and charged in minutes, and chargers and
            parking places are few; the chargers suffice.
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
    obstacles_frac: float = 0.0
    obstacles: tuple[float, float] = (0.3, 3.0)
    doors_frac: float = 0.0
    operators_frac: float = 0.7
    random_operator_frac: float = 0.4
    cancelled_frac: float = 0.1
    revoking_frac: float = 0.3
    revoked_frac: float = 0.4
    insiders_frac: float = 0.0
    closures_frac: float = 0.0
    carried_frac: float = 0.0
    calls_frac: float = 0.0
    things_frac: float = 0.0
    levels_frac: float = 0.0
    scrap_frac: float = 0.0
    priorities_frac: float = 0.0
    stations_frac: float = 0.0
    rests_frac: float = 0.0
    bodies_frac: float = 0.0
    damaged_frac: float = 0.0
    strategists: int = 1
    scarce_power: bool = False


ONE_LEVEL = Profile(
    weights={**WEIGHTS, JournalLost: 1.0},
    leaving_frac=0.3,
    waves_frac=0.3,
    clocks_frac=0.3,
    obstacles_frac=0.2,
    insiders_frac=0.2,
    closures_frac=0.2,
    carried_frac=0.3,
    calls_frac=0.4,
)
"""Everything but parts, bad pieces, priorities, and storages that vehicles refill."""

PROFILES: Mapping[str, Profile] = {
    "all": replace(ONE_LEVEL, levels_frac=0.4, scrap_frac=0.4, priorities_frac=0.4, stations_frac=0.3),
    "one-level": ONE_LEVEL,
    "people": replace(ONE_LEVEL, operators_frac=1.0, random_operator_frac=0.7),
    "levels": Profile(
        machines=(2, 6),
        vehicles=(2, 6),
        weights={**WEIGHTS, Crashed: 4.0, JournalLost: 0.3},
        waves_frac=0.3,
        leaving_frac=0.3,
        calls_frac=0.5,
        levels_frac=1.0,
        scrap_frac=0.7,
        priorities_frac=0.5,
    ),
    "levels-alone": Profile(
        machines=(2, 6),
        vehicles=(2, 6),
        intensity=(0.0, 0.0),
        operators_frac=0.0,
        random_operator_frac=0.0,
        levels_frac=1.0,
        scrap_frac=0.7,
        priorities_frac=0.5,
    ),
    "stations": Profile(
        vehicles=(2, 6),
        weights={**WEIGHTS, Crashed: 4.0, JournalLost: 0.5},
        waves_frac=0.4,
        leaving_frac=0.3,
        closures_frac=0.2,
        calls_frac=0.4,
        levels_frac=0.3,
        stations_frac=1.0,
    ),
    "stations-alone": Profile(
        intensity=(0.0, 0.0), operators_frac=0.0, random_operator_frac=0.0, stations_frac=1.0
    ),
    "rests": Profile(rests_frac=1.0, leaving_frac=0.3, waves_frac=0.3, levels_frac=0.3),
    "bodies": Profile(
        weights={Crashed: 1.0, JournalLost: 0.2},
        intensity=(0.0, 1.0),
        waves_frac=0.3,
        operators_frac=0.5,
        random_operator_frac=0.0,
        revoking_frac=0.0,
        levels_frac=0.3,
        scrap_frac=0.3,
        bodies_frac=1.0,
        damaged_frac=0.4,
    ),
    "mishaps": Profile(leaving_frac=0.3),
    "strategists": Profile(leaving_frac=0.3, levels_frac=0.3, strategists=2),
    "deaths": Profile(weights={PoweredOff: 2.0, Crashed: 1.0}, random_operator_frac=0.0),
    "links": Profile(weights={WlanCut: 2.0, LinkTrouble: 4.0, Partition: 2.0, CoverageHole: 1.0}),
    "answers": Profile(
        weights={LinkTrouble: 1.0}, intensity=(3.0, 8.0), operators_frac=0.0, random_operator_frac=0.0
    ),
    "hands": Profile(
        weights={VehicleBroken: 1.0, LoadShifted: 2.0}, operators_frac=1.0, random_operator_frac=1.0
    ),
    "machines": Profile(
        machines=(3, 5), weights={MachineBroken: 1.0}, operators_frac=1.0, random_operator_frac=1.0
    ),
    "revocations": Profile(revoking_frac=1.0, revoked_frac=0.8),
    "updates": Profile(intensity=(0.0, 1.0), leaving_frac=1.0, leaving=(0.5, 4.0), random_operator_frac=0.2),
    "restarts": Profile(
        intensity=(0.0, 0.3), random_operator_frac=0.0, operators_frac=0.3, waves_frac=1.0, waves=(0.3, 3.0)
    ),
    "notes": Profile(
        weights={JournalLost: 2.0, Crashed: 1.0, PoweredOff: 0.5}, waves_frac=0.5, random_operator_frac=0.0
    ),
    "clocks": Profile(intensity=(0.0, 1.0), waves_frac=0.5, clocks_frac=1.0),
    "liars": Profile(intensity=(0.0, 0.5), operators_frac=0.0, random_operator_frac=0.0, insiders_frac=1.0),
    "closures": Profile(intensity=(0.0, 0.5), closures_frac=1.0),
    "closures-alone": Profile(
        intensity=(0.0, 0.0), operators_frac=0.0, random_operator_frac=0.0, closures_frac=1.0
    ),
    "obstacles": Profile(intensity=(0.0, 0.5), obstacles_frac=1.0),
    "obstacles-alone": Profile(
        intensity=(0.0, 0.0), operators_frac=0.0, random_operator_frac=0.0, obstacles_frac=1.0
    ),
    "doors": Profile(vehicles=(2, 6), intensity=(0.0, 1.0), obstacles_frac=0.3, doors_frac=1.0),
    "doors-alone": Profile(
        vehicles=(2, 6), intensity=(0.0, 0.0), operators_frac=0.0, random_operator_frac=0.0, doors_frac=1.0
    ),
    "carried": Profile(vehicles=(2, 6), intensity=(0.0, 1.0), carried_frac=1.0),
    "calls": Profile(
        weights={**WEIGHTS, Crashed: 4.0, JournalLost: 0.5},
        waves_frac=0.4,
        leaving_frac=0.3,
        calls_frac=1.0,
        things_frac=0.25,
    ),
    "faultless": Profile(intensity=(0.0, 0.0), random_operator_frac=0.0),
    "batteries": Profile(
        vehicles=(1, 10),
        battery_frac=(0.2, 0.9),
        intensity=(0.0, 0.0),
        random_operator_frac=0.0,
        scarce_power=True,
    ),
}
"""Profiles by name, for `dray sim explore --profile`."""
