"""Facts: what an agent writes into its own numbered history. Each module holds the facts of one kind of agent.

A fact says what the agent itself did, decided or saw, and nothing about the opinion of others. `dray.messages.history` describes
their numbers, and how missed ones are asked for again.
"""

from __future__ import annotations

from functools import reduce
from operator import or_
from typing import TYPE_CHECKING

from dray.messages.fact.base import (
    Fact,
    MemoryLost,
)
from dray.messages.fact.contractor import (
    BidRefused,
    BidSent,
    ContractEnded,
    ContractTaken,
    NotBelieved,
    TookOver,
)
from dray.messages.fact.coordinator import (
    Answer,
    AwardAnswered,
    AwardGiven,
    BidReceived,
    BookRefused,
    CarrierChanged,
    ContractorRated,
    HandoverDisputed,
    LoadDoubted,
    NameMisused,
    Outcome,
    PrimarySuspected,
    RoundFailed,
    TaskClosed,
    TaskOpened,
    TransportProgressed,
    WatchLost,
    WordDisbelieved,
)
from dray.messages.fact.machine import (
    MachineStatusChanged,
    PieceMade,
    PieceScrapped,
    PromiseMoved,
    SparePieceMade,
)
from dray.messages.fact.removal import (
    PlaceKept,
    PlacesFreed,
    RemovalRefused,
)
from dray.messages.fact.strategist import (
    GoalContracted,
    GoalLost,
    GoalReduced,
    GoalWaits,
    GoalWithdrawn,
    GoodsDelivered,
    MachineFailure,
    OrderAccepted,
    OrderChanged,
    OrderDropped,
    OrderFulfilled,
    OrderProgressed,
    OrderReturned,
    OrderTakenOver,
)
from dray.messages.fact.vehicle import (
    AtvStatusChanged,
    ClosuresKnown,
    CommandObeyed,
    HelpAsked,
    HelpCallEnded,
    HelpPromised,
    LinkChanged,
    PhaseEntered,
)

if TYPE_CHECKING:
    AnyFact = Fact
else:
    # The union of all facts, for decoding.
    AnyFact = reduce(or_, sorted(Fact.__subclasses__(), key=lambda kind: kind.__name__))

__all__ = [
    "Answer",
    "AnyFact",
    "AtvStatusChanged",
    "AwardAnswered",
    "AwardGiven",
    "BidReceived",
    "BidRefused",
    "BidSent",
    "BookRefused",
    "CarrierChanged",
    "ClosuresKnown",
    "CommandObeyed",
    "ContractEnded",
    "ContractTaken",
    "ContractorRated",
    "Fact",
    "GoalContracted",
    "GoalLost",
    "GoalReduced",
    "GoalWaits",
    "GoalWithdrawn",
    "GoodsDelivered",
    "HandoverDisputed",
    "HelpAsked",
    "HelpCallEnded",
    "HelpPromised",
    "LinkChanged",
    "LoadDoubted",
    "MachineFailure",
    "MachineStatusChanged",
    "MemoryLost",
    "NameMisused",
    "NotBelieved",
    "OrderAccepted",
    "OrderChanged",
    "OrderDropped",
    "OrderFulfilled",
    "OrderProgressed",
    "OrderReturned",
    "OrderTakenOver",
    "Outcome",
    "PhaseEntered",
    "PieceMade",
    "PieceScrapped",
    "PlaceKept",
    "PlacesFreed",
    "PrimarySuspected",
    "PromiseMoved",
    "RemovalRefused",
    "RoundFailed",
    "SparePieceMade",
    "TaskClosed",
    "TaskOpened",
    "TookOver",
    "TransportProgressed",
    "WatchLost",
    "WordDisbelieved",
]
