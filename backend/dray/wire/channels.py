"""The channels of the bus: its keys, and the messages on each of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import get_args

from dray.messages import (
    AnyMessage,
    AtvHeartbeat,
    Closures,
    DockExpected,
    DwellPointClaimed,
    Event,
    FloorReported,
    HelpCall,
    MachineHeartbeat,
    Message,
    ObstacleCleared,
    ObstacleSeen,
    OperatorHeartbeat,
    ProblemEnded,
    Removals,
    ShutOut,
    StationHeartbeat,
    StrategistHeartbeat,
    TaskAnnounced,
    WorkSought,
)
from dray.messages.keys import Keys


@dataclass(frozen=True, slots=True)
class Channel:
    """A key, or a family of keys.

    Attributes:
        name: the channel's name in documents.
        address: the key, with variable parts in braces.
        about: the listeners and their purpose.
        messages: all messages on it.
    """

    name: str
    address: str
    about: str
    messages: tuple[type[Message], ...]


_KEYS = Keys("{plant}")

_PUBLISHED = (
    Channel(
        "atvHeartbeats",
        _KEYS.atv_heartbeat("{atv}"),
        "How a vehicle is, regularly and at once when it changes. The vehicle alone speaks here.",
        (AtvHeartbeat,),
    ),
    Channel(
        "machineHeartbeats",
        _KEYS.machine_heartbeat("{machine}"),
        "How a machine is, and what it waits for. The machine alone speaks here.",
        (MachineHeartbeat,),
    ),
    Channel(
        "stationHeartbeats",
        _KEYS.station_heartbeat("{station}"),
        "What lies in a storage, and what is promised of it. Its station alone speaks here.",
        (StationHeartbeat,),
    ),
    Channel(
        "strategistHeartbeats",
        _KEYS.strategist_heartbeat("{strategist}"),
        "That a strategist is there, and how many orders it works at, to the others of its plant. The strategist alone speaks here.",
        (StrategistHeartbeat,),
    ),
    Channel(
        "operatorHeartbeats",
        _KEYS.operator_heartbeat("{operator}"),
        "Who is on duty, where, and free or busy with whom. The operator's agent alone speaks here.",
        (OperatorHeartbeat,),
    ),
    Channel(
        "calls",
        _KEYS.call("{caller}"),
        "Whom somebody asks for help, and who comes, to all operators. The caller alone speaks here.",
        (HelpCall,),
    ),
    Channel(
        "transports",
        _KEYS.transports("{cell}"),
        "Announcements of transports, to the vehicles in one cell of the grid.",
        (TaskAnnounced,),
    ),
    Channel(
        "goals",
        _KEYS.goals("{product}"),
        "Announcements of production goals, to the machines that were set up for the product; to others by their own name.",
        (TaskAnnounced,),
    ),
    Channel(
        "dwellPoints",
        _KEYS.dwell_point("{dwell_point}"),
        "Claims of one charger or parking place, to the vehicles that want it too.",
        (DwellPointClaimed,),
    ),
    Channel(
        "free",
        _KEYS.free("{atv}"),
        "A vehicle that had no time is free, and asks all coordinators for work that waits. The vehicle alone speaks here.",
        (WorkSought,),
    ),
    Channel(
        "docks",
        _KEYS.dock("{place}"),
        "When vehicles will be at the dock of a place, to those who hire vehicles for it.",
        (DockExpected,),
    ),
    Channel(
        "problems",
        _KEYS.problem("{atv}"),
        "How long a problem of a vehicle has lasted, to all vehicles. The vehicle alone speaks here.",
        (ProblemEnded,),
    ),
    Channel(
        "obstacles",
        _KEYS.obstacle("{agent}"),
        "What a vehicle has met on a lane, and that it is gone, to all vehicles; a person's word that it is. The agent alone speaks here.",
        (ObstacleSeen, ObstacleCleared),
    ),
    Channel(
        "breakdowns",
        _KEYS.breakdown("{machine}"),
        "How long a breakdown of a machine has lasted, to all machines. The machine alone speaks here.",
        (ProblemEnded,),
    ),
    Channel(
        "floor",
        _KEYS.floor("{district}"),
        "Which vehicles hold something in a district, to the vehicles that drive there or close by. A hint: the table says who holds what.",
        (FloorReported,),
    ),
    Channel(
        "events",
        _KEYS.events("{agent}"),
        "An agent's history, numbered without holes. The agent alone speaks here.",
        (Event,),
    ),
    Channel(
        "shutOut",
        _KEYS.shut_out,
        "Who is shut out, to everybody: a gateway says it every two seconds, and the highest number counts.",
        (ShutOut,),
    ),
    Channel(
        "closures",
        _KEYS.closures,
        "What is closed to vehicles, to all vehicles and machines: a gateway says it at every change and again and again, and "
        "the highest number counts.",
        (Closures,),
    ),
    Channel(
        "removals",
        _KEYS.removals,
        "Vehicles that people have carried away, or are putting back, to vehicles and to whoever keeps reservation tables: a gateway says "
        "them again and again while they are silent, and of each vehicle the highest number counts.",
        (Removals,),
    ),
)

_BROADCAST_ONLY = frozenset(
    {
        AtvHeartbeat,
        MachineHeartbeat,
        StationHeartbeat,
        StrategistHeartbeat,
        OperatorHeartbeat,
        HelpCall,
        FloorReported,
        DwellPointClaimed,
        ObstacleCleared,
        ObstacleSeen,
        ProblemEnded,
        WorkSought,
        ShutOut,
        Closures,
        Removals,
    }
)

CHANNELS = (
    *_PUBLISHED,
    Channel(
        "addressed",
        _KEYS.addressed("{agent}"),
        "What is said to one agent alone; no wildcard matches it.",
        tuple(kind for kind in get_args(AnyMessage) if kind not in _BROADCAST_ONLY),
    ),
)
"""All channels. `dray.messages.speakers` tells who may send which message."""
