"""Who may say what: the one place that every bus asks before anybody hears a message (`objection`).

Names hold on every bus: on a key that belongs to one agent nobody else speaks, and whatever a message says
of its speaker is true. Kinds hold where they are known, by certificates or in a simulated plant: a vehicle has
neither a machine's words nor a strategist's facts, and nobody but a gateway gives orders.
"""

from __future__ import annotations

from collections.abc import Container, Mapping
from enum import StrEnum

from dray.messages.base import Message
from dray.messages.contract import (
    Accepted,
    Award,
    Bid,
    Confirmed,
    Declined,
    Disbelieved,
    Docked,
    DockExpected,
    DockHeld,
    DockOpened,
    GoalClosed,
    Handover,
    HandoverAccepted,
    Release,
    Resigned,
    Superseded,
    TakenOver,
    TaskAnnounced,
    Withdrawn,
    WorkSought,
)
from dray.messages.fact import (
    AtvStatusChanged,
    AwardAnswered,
    AwardGiven,
    BidReceived,
    BidRefused,
    BidSent,
    BookRefused,
    CarrierChanged,
    ClosuresKnown,
    CommandObeyed,
    ContractEnded,
    ContractorRated,
    ContractTaken,
    Fact,
    GoalContracted,
    GoalLost,
    GoalReduced,
    GoalWaits,
    GoalWithdrawn,
    GoodsDelivered,
    HandoverDisputed,
    HelpAsked,
    HelpCallEnded,
    HelpPromised,
    LinkChanged,
    MachineStatusChanged,
    MemoryLost,
    NameMisused,
    NotBelieved,
    OrderAccepted,
    OrderChanged,
    OrderDropped,
    OrderFulfilled,
    OrderProgressed,
    OrderReturned,
    OrderTakenOver,
    PhaseEntered,
    PieceMade,
    PieceScrapped,
    PlaceKept,
    PlacesFreed,
    PrimarySuspected,
    RoundFailed,
    SparePieceMade,
    TaskClosed,
    TaskOpened,
    TookOver,
    TransportProgressed,
    WatchLost,
    WordDisbelieved,
)
from dray.messages.floor.closure import Closures
from dray.messages.floor.dwell_point import DwellPointClaimed
from dray.messages.floor.obstacle import ObstacleCleared, ObstacleSeen
from dray.messages.floor.removal import Removals
from dray.messages.floor.traffic import (
    BookAsked,
    BookKept,
    BookTold,
    FloorTold,
    HoldsAsked,
    PlaceBooked,
    PlaceConfirmed,
    PlaceGranted,
    PlaceWished,
    YieldAsked,
    YieldRefused,
)
from dray.messages.gate import (
    AdmissionAsked,
    CountHeard,
    GateAsked,
    GateTold,
    GoodsCounted,
    HolderHeard,
    HolderTold,
    OrderClaimed,
)
from dray.messages.heartbeat import AtvHeartbeat, MachineHeartbeat, StationHeartbeat
from dray.messages.history import Event, EventsAsked, EventsKept
from dray.messages.keys import owner_of
from dray.messages.order import (
    CancellationTaken,
    GoalRevised,
    GoalRevisionTaken,
    HolderChanged,
    OrderCancelled,
    OrderReleased,
    OrderRevoked,
    OrderTaken,
    RevocationTaken,
    StrategistHeartbeat,
)
from dray.messages.people.call import CallAnswered, HelpCall
from dray.messages.people.command import CommandAnswered, MachineCommand, VehicleCommand
from dray.messages.people.operator import OPERATOR_PREFIX, OperatorHeartbeat
from dray.messages.problem import ProblemEnded
from dray.messages.shutout import ShutOut
from dray.messages.stock import StockAsked, StockFreed, StockReserved, StockShort
from dray.messages.transport import TransportAnswered, TransportCancelled, TransportOrdered


class Kind(StrEnum):
    """What an agent is."""

    ATV = "atv"
    MACHINE = "machine"
    STATION = "station"
    """Of a storage."""
    STRATEGIST = "strategist"
    GATE = "gate"
    """Of the delivery warehouses."""
    OPERATOR = "operator"
    """Somebody on duty. A gateway speaks for those at its tablets."""
    GATEWAY = "gateway"
    HISTORIAN = "historian"


STOP_SUFFIX = "-stop"


def stop_sender_of(gateway: str) -> str:
    """The name of the agent by which a gateway says stops, beside its own."""
    return gateway + STOP_SUFFIX


def names_of(agent: str, kind: Kind) -> dict[str, Kind]:
    """Whom the process of an agent speaks for, as its certificate says."""
    names = (agent, stop_sender_of(agent)) if kind is Kind.GATEWAY else (agent,)
    return dict.fromkeys(names, kind)


def kind_in(agent: str, certified: Mapping[str, Kind]) -> Kind | None:
    """What an agent is by a certificate that names these; None when the certificate is not good for it.

    People come and go, so no certificate names them: whoever may speak for a gateway may speak for the operators at its tablets.
    """
    if agent.startswith(OPERATOR_PREFIX) and Kind.GATEWAY in certified.values():
        return Kind.OPERATOR
    return certified.get(agent)


_ATVS = frozenset({Kind.ATV})
_MACHINES = frozenset({Kind.MACHINE})
_STATIONS = frozenset({Kind.STATION})
_STRATEGISTS = frozenset({Kind.STRATEGIST})
_GATES = frozenset({Kind.GATE})
_GATEWAYS = frozenset({Kind.GATEWAY})
_OPERATORS = frozenset({Kind.OPERATOR})
_BIDDERS = _ATVS | _MACHINES
_DOCKS = _MACHINES | _STATIONS
_COORDINATORS = _DOCKS | _STRATEGISTS
_TELLERS = _BIDDERS | _COORDINATORS | _STATIONS | _GATES

SPEAKERS: Mapping[type[Message], frozenset[Kind]] = {
    AtvHeartbeat: _ATVS,
    MachineHeartbeat: _MACHINES,
    StationHeartbeat: _STATIONS | _GATES,
    StrategistHeartbeat: _STRATEGISTS,
    OperatorHeartbeat: _OPERATORS,
    HelpCall: _BIDDERS | _STATIONS,
    CallAnswered: _OPERATORS,
    TaskAnnounced: _COORDINATORS,
    Bid: _BIDDERS,
    Award: _COORDINATORS,
    Accepted: _BIDDERS,
    Declined: _BIDDERS,
    Confirmed: _COORDINATORS,
    Release: _COORDINATORS,
    Superseded: _COORDINATORS,
    Withdrawn: _COORDINATORS,
    GoalClosed: _STRATEGISTS,
    GoalRevised: _STRATEGISTS,
    GoalRevisionTaken: _MACHINES,
    Disbelieved: _COORDINATORS,
    Resigned: _ATVS,
    TakenOver: _ATVS,
    Docked: _ATVS,
    DockOpened: _DOCKS,
    DockHeld: _DOCKS,
    Handover: _ATVS,
    HandoverAccepted: _DOCKS,
    StockAsked: _DOCKS,
    StockReserved: _DOCKS,
    StockShort: _DOCKS,
    StockFreed: _DOCKS,
    TransportOrdered: _GATEWAYS | _MACHINES,
    TransportCancelled: _GATEWAYS | _MACHINES,
    TransportAnswered: _DOCKS,
    DwellPointClaimed: _ATVS,
    WorkSought: _ATVS,
    DockExpected: _ATVS,
    ProblemEnded: _BIDDERS,
    ObstacleSeen: _ATVS,
    ObstacleCleared: _GATEWAYS,
    CommandAnswered: _BIDDERS | _STATIONS | _GATES,
    OrderReleased: _GATEWAYS,
    OrderCancelled: _GATEWAYS,
    OrderRevoked: _GATEWAYS,
    VehicleCommand: _GATEWAYS,
    MachineCommand: _GATEWAYS,
    ShutOut: _GATEWAYS,
    Closures: _GATEWAYS,
    Removals: _GATEWAYS,
    OrderTaken: _STRATEGISTS,
    HolderChanged: _STRATEGISTS,
    GateAsked: _STRATEGISTS,
    GateTold: _GATES,
    AdmissionAsked: _STRATEGISTS,
    GoodsCounted: _GATES,
    CountHeard: _STRATEGISTS,
    OrderClaimed: _STRATEGISTS,
    HolderTold: _GATES,
    HolderHeard: _STRATEGISTS,
    CancellationTaken: _STRATEGISTS,
    RevocationTaken: _STRATEGISTS,
    Event: _TELLERS,
    EventsKept: _TELLERS,
    EventsAsked: _GATEWAYS | {Kind.HISTORIAN},
    PlaceWished: _ATVS,
    PlaceGranted: _DOCKS,
    PlaceConfirmed: _DOCKS,
    FloorTold: _DOCKS,
    YieldAsked: _DOCKS,
    YieldRefused: _ATVS,
    HoldsAsked: _DOCKS,
    PlaceBooked: _DOCKS,
    BookKept: _DOCKS,
    BookAsked: _DOCKS,
    BookTold: _DOCKS,
}
"""Every message, and the kinds of agents that may say it."""

TELLERS: Mapping[type[Fact], frozenset[Kind]] = {
    TaskOpened: _COORDINATORS,
    BidReceived: _COORDINATORS,
    AwardGiven: _COORDINATORS,
    AwardAnswered: _COORDINATORS,
    RoundFailed: _COORDINATORS,
    TaskClosed: _COORDINATORS,
    WatchLost: _DOCKS,
    CarrierChanged: _DOCKS,
    ContractorRated: _DOCKS,
    WordDisbelieved: _COORDINATORS,
    NameMisused: _DOCKS,
    BookRefused: _DOCKS,
    HandoverDisputed: _DOCKS,
    TransportProgressed: _DOCKS,
    PrimarySuspected: _ATVS | _DOCKS,
    BidSent: _BIDDERS,
    BidRefused: _BIDDERS,
    ContractTaken: _BIDDERS,
    ContractEnded: _BIDDERS,
    NotBelieved: _BIDDERS,
    TookOver: _ATVS,
    LinkChanged: _ATVS,
    HelpAsked: _BIDDERS,
    HelpCallEnded: _BIDDERS | _STATIONS,
    HelpPromised: _BIDDERS,
    PhaseEntered: _ATVS,
    AtvStatusChanged: _ATVS,
    CommandObeyed: _BIDDERS | _STATIONS | _GATES,
    ClosuresKnown: _ATVS,
    MachineStatusChanged: _MACHINES,
    PieceMade: _MACHINES,
    PieceScrapped: _MACHINES,
    SparePieceMade: _MACHINES,
    GoodsDelivered: _STRATEGISTS,
    OrderAccepted: _STRATEGISTS,
    GoalContracted: _STRATEGISTS,
    GoalLost: _STRATEGISTS,
    GoalReduced: _STRATEGISTS,
    OrderChanged: _STRATEGISTS,
    GoalWithdrawn: _STRATEGISTS,
    GoalWaits: _STRATEGISTS,
    OrderProgressed: _STRATEGISTS,
    OrderFulfilled: _STRATEGISTS,
    OrderDropped: _STRATEGISTS,
    OrderReturned: _STRATEGISTS,
    OrderTakenOver: _STRATEGISTS,
    PlacesFreed: _DOCKS,
    PlaceKept: _DOCKS,
    MemoryLost: _TELLERS,
}
"""Every fact, and the kinds of agents that may tell it as their own."""

SIGNATURES: Mapping[type[Message], str] = {
    AtvHeartbeat: "atv",
    MachineHeartbeat: "machine",
    StationHeartbeat: "station",
    StrategistHeartbeat: "strategist",
    OperatorHeartbeat: "operator",
    HelpCall: "caller",
    CallAnswered: "operator",
    TaskAnnounced: "coordinator",
    DwellPointClaimed: "atv",
    WorkSought: "atv",
    ProblemEnded: "agent",
    ObstacleSeen: "atv",
    Event: "agent",
}
"""The messages that say who speaks, and the field in which they do."""

SHUT_OUT = "an agent that is shut out"
FOREIGN_KEY = "another agent's key"
FOREIGN_NAME = "another agent's name"
FOREIGN_WORD = "a word that its kind does not have"
FOREIGN_FACT = "a fact that its kind does not tell"


def objection(
    sender: str, kind: Kind | None, key: str, message: Message, shut_out: Container[str] = ()
) -> str:
    """Why nobody should hear this from `sender`, as a reason to count; empty when all is well.

    Args:
        sender: who has really said it, whoever has passed it on.
        kind: what the sender is; None where nobody knows, as on a bus without certificates.
        key: on which it was said; what is said to one agent alone belongs to no key of anybody's.
        message: what was said.
        shut_out: agents that nobody hears any more, whatever they say.
    """
    if sender in shut_out:
        return SHUT_OUT
    if owner_of(key) not in (None, sender):
        return FOREIGN_KEY
    said = type(message)
    if said in SIGNATURES and getattr(message, SIGNATURES[said]) != sender:
        return FOREIGN_NAME
    if kind is None:
        return ""
    if kind not in SPEAKERS[said]:
        return FOREIGN_WORD
    if isinstance(message, Event) and kind not in TELLERS[type(message.fact)]:
        return FOREIGN_FACT
    return ""
