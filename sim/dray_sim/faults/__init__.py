"""Faults of a simulated factory, as data: begun and ended by hand, by a script, or by a seed.

`kinds` are the faults themselves, `names` checks the agents that they name, and `schedule` adds times and reads JSON.
`chance` draws whole schedules, and `active` begins and ends faults in a factory.
"""

from __future__ import annotations

from dray_sim.faults.active import Faults, World, play
from dray_sim.faults.chance import (
    CLOCKS,
    DOORS,
    DROPPED,
    LEAVING,
    OBSTACLES,
    WEIGHTS,
    random_kills,
    random_schedule,
    random_waves,
)
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
    describe,
    kind_of,
)
from dray_sim.faults.names import Cast, FaultError
from dray_sim.faults.schedule import Timed, read_fault, read_schedule, write_schedule
from dray_sim.network.faults import (
    AccessPointDown,
    CoverageHole,
    LinkTrouble,
    NetworkFault,
    Partition,
    RadioCut,
    WlanCut,
)

__all__ = [
    "CLOCKS",
    "DOORS",
    "DROPPED",
    "LEAVING",
    "OBSTACLES",
    "WEIGHTS",
    "AccessPointDown",
    "Cast",
    "ClockSet",
    "CoverageHole",
    "Crashed",
    "DoorFailed",
    "Fault",
    "FaultError",
    "Faults",
    "JournalLost",
    "LaneBlocked",
    "LinkTrouble",
    "LoadDropped",
    "LoadShifted",
    "MachineBroken",
    "NetworkFault",
    "Partition",
    "PoweredOff",
    "RadioCut",
    "SentAway",
    "Thing",
    "Timed",
    "VehicleBroken",
    "WlanCut",
    "World",
    "describe",
    "kind_of",
    "play",
    "random_kills",
    "random_schedule",
    "random_waves",
    "read_fault",
    "read_schedule",
    "write_schedule",
]
