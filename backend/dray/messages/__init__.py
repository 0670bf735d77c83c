"""Everything agents say to one another: frozen structs, one per utterance.

`heartbeat` is what everybody may hear at any time, `contract` the negotiation, `order` what customers want, `product` what is known of a product, `stock` how material in
storages is reserved, `gate` what strategists ask of the gate of the delivery warehouses, `shutout` the agents whom a manager has excluded, `fact` what each writes into its `history`. `people` holds
what people say and hear (who is on duty, who calls for help, commands), `floor` what is said about the floor (who may drive where,
where one may stand, what is closed or lies there).
How messages become bytes is `dray.codec`; when they are said is `dray.protocol`.
"""

from __future__ import annotations

from dray.messages.base import WIRE_VERSION, Message, Part
from dray.messages.contract import (
    Accepted,
    Award,
    Bid,
    Brought,
    Confirmed,
    Declined,
    Disbelieved,
    Docked,
    DockExpected,
    DockHeld,
    DockOpened,
    DockTime,
    GoalClosed,
    Handover,
    HandoverAccepted,
    Production,
    Refusal,
    Release,
    Resigned,
    Superseded,
    TakenOver,
    TaskAnnounced,
    Transport,
    Wait,
    Withdrawn,
    Work,
    WorkSought,
)
from dray.messages.cost import Cost, ProductionCost, TransportCost
from dray.messages.fact import AnyFact, Fact
from dray.messages.floor.closure import Closure, ClosureKind, Closures, closed_words
from dray.messages.floor.dwell_point import DwellPointClaimed
from dray.messages.floor.obstacle import ObstacleCleared, ObstacleSeen
from dray.messages.floor.removal import Removal, Removals, removed_words
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
from dray.messages.heartbeat import (
    AtvHeartbeat,
    AtvStatus,
    BodyWait,
    Brief,
    BufferLevel,
    GoalBrief,
    JoiningMachine,
    MachineHeartbeat,
    MachineStatus,
    MaterialWait,
    OutOfService,
    PeopleAsBody,
    Phase,
    Pose,
    ProbationBrief,
    Role,
    StationHeartbeat,
    StockLevel,
    TaskBrief,
    UnconfirmedLoad,
)
from dray.messages.history import Event, EventsAsked, EventsKept
from dray.messages.link import Link, LostWlan
from dray.messages.order import (
    CancellationTaken,
    GoalRevised,
    GoalRevisionTaken,
    HolderChanged,
    OrderCancelled,
    OrderItem,
    OrderReleased,
    OrderRevoked,
    OrderTaken,
    RevocationTaken,
    StrategistHeartbeat,
)
from dray.messages.people.call import CallAnswer, CallAnswered, CallState, HelpCall
from dray.messages.people.command import (
    CommandAnswered,
    CommandKind,
    Grant,
    MachineCommand,
    MachineCommandKind,
    VehicleCommand,
    signed_words,
)
from dray.messages.people.operator import OPERATOR_PREFIX, DutyStatus, OperatorHeartbeat
from dray.messages.problem import (
    NOTHING_KNOWN,
    HelpWanted,
    Problem,
    ProblemEnded,
    ProblemKind,
    StrandedGoods,
)
from dray.messages.product import (
    BillLine,
    Document,
    DocumentBrief,
    DocumentState,
    MachineCycle,
    PartDefinition,
    ProductDefinition,
)
from dray.messages.reason import CommandRefusal, Implausible, Reason
from dray.messages.shutout import ShutOut
from dray.messages.stock import StockAsked, StockFreed, StockReserved, StockShort
from dray.messages.transport import (
    THING,
    TRANSPORT_ENDED,
    TransportAnswered,
    TransportCancelled,
    TransportOrdered,
    TransportRefusal,
    TransportState,
    TransportWait,
)

Heartbeat = AtvHeartbeat | MachineHeartbeat
"""Of those who bid."""

AnyMessage = (
    AtvHeartbeat
    | MachineHeartbeat
    | StationHeartbeat
    | StrategistHeartbeat
    | OperatorHeartbeat
    | HelpCall
    | CallAnswered
    | TaskAnnounced
    | Bid
    | Award
    | Accepted
    | Confirmed
    | Declined
    | Release
    | Resigned
    | TakenOver
    | Docked
    | DockOpened
    | DockHeld
    | DockExpected
    | Handover
    | HandoverAccepted
    | Superseded
    | Withdrawn
    | GoalClosed
    | GoalRevised
    | GoalRevisionTaken
    | Disbelieved
    | OrderReleased
    | OrderTaken
    | HolderChanged
    | OrderCancelled
    | CancellationTaken
    | OrderRevoked
    | RevocationTaken
    | VehicleCommand
    | MachineCommand
    | CommandAnswered
    | DwellPointClaimed
    | ProblemEnded
    | ObstacleSeen
    | ObstacleCleared
    | WorkSought
    | Event
    | EventsAsked
    | EventsKept
    | ShutOut
    | Closures
    | Removals
    | StockAsked
    | StockReserved
    | StockShort
    | TransportOrdered
    | TransportCancelled
    | TransportAnswered
    | StockFreed
    | PlaceWished
    | PlaceGranted
    | PlaceConfirmed
    | FloorTold
    | YieldAsked
    | YieldRefused
    | HoldsAsked
    | PlaceBooked
    | BookKept
    | BookAsked
    | BookTold
    | GateAsked
    | GateTold
    | AdmissionAsked
    | GoodsCounted
    | CountHeard
    | OrderClaimed
    | HolderTold
    | HolderHeard
)

__all__ = [
    "NOTHING_KNOWN",
    "OPERATOR_PREFIX",
    "THING",
    "TRANSPORT_ENDED",
    "WIRE_VERSION",
    "Accepted",
    "AdmissionAsked",
    "AnyFact",
    "AnyMessage",
    "AtvHeartbeat",
    "AtvStatus",
    "Award",
    "Bid",
    "BillLine",
    "BodyWait",
    "BookAsked",
    "BookKept",
    "BookTold",
    "Brief",
    "Brought",
    "BufferLevel",
    "CallAnswer",
    "CallAnswered",
    "CallState",
    "CancellationTaken",
    "Closure",
    "ClosureKind",
    "Closures",
    "CommandAnswered",
    "CommandKind",
    "CommandRefusal",
    "Confirmed",
    "Cost",
    "CountHeard",
    "Declined",
    "Disbelieved",
    "DockExpected",
    "DockHeld",
    "DockOpened",
    "DockTime",
    "Docked",
    "Document",
    "DocumentBrief",
    "DocumentState",
    "DutyStatus",
    "DwellPointClaimed",
    "Event",
    "EventsAsked",
    "EventsKept",
    "Fact",
    "FloorTold",
    "GateAsked",
    "GateTold",
    "GoalBrief",
    "GoalClosed",
    "GoalRevised",
    "GoalRevisionTaken",
    "GoodsCounted",
    "Grant",
    "Handover",
    "HandoverAccepted",
    "Heartbeat",
    "HelpCall",
    "HelpWanted",
    "HolderChanged",
    "HolderHeard",
    "HolderTold",
    "HoldsAsked",
    "Implausible",
    "JoiningMachine",
    "Link",
    "LostWlan",
    "MachineCommand",
    "MachineCommandKind",
    "MachineCycle",
    "MachineHeartbeat",
    "MachineStatus",
    "MaterialWait",
    "Message",
    "ObstacleCleared",
    "ObstacleSeen",
    "OperatorHeartbeat",
    "OrderCancelled",
    "OrderClaimed",
    "OrderItem",
    "OrderReleased",
    "OrderRevoked",
    "OrderTaken",
    "OutOfService",
    "Part",
    "PartDefinition",
    "PeopleAsBody",
    "Phase",
    "PlaceBooked",
    "PlaceConfirmed",
    "PlaceGranted",
    "PlaceWished",
    "Pose",
    "ProbationBrief",
    "Problem",
    "ProblemEnded",
    "ProblemKind",
    "ProductDefinition",
    "Production",
    "ProductionCost",
    "Reason",
    "Refusal",
    "Release",
    "Removal",
    "Removals",
    "Resigned",
    "RevocationTaken",
    "Role",
    "ShutOut",
    "StationHeartbeat",
    "StockAsked",
    "StockFreed",
    "StockLevel",
    "StockReserved",
    "StockShort",
    "StrandedGoods",
    "StrategistHeartbeat",
    "Superseded",
    "TakenOver",
    "TaskAnnounced",
    "TaskBrief",
    "Transport",
    "TransportAnswered",
    "TransportCancelled",
    "TransportCost",
    "TransportOrdered",
    "TransportRefusal",
    "TransportState",
    "TransportWait",
    "UnconfirmedLoad",
    "VehicleCommand",
    "Wait",
    "Withdrawn",
    "Work",
    "WorkSought",
    "YieldAsked",
    "YieldRefused",
    "closed_words",
    "removed_words",
    "signed_words",
]
