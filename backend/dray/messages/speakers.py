"""Who may say what: the kinds of agents, and the words of each.

On a bus with certificates, a message of a kind of agent that has no such word is refused, so that a vehicle
does not speak as a machine and nobody but a gateway gives orders.
"""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum

from dray.messages.base import Message
from dray.messages.berth import BerthClaimed
from dray.messages.command import CommandAnswered, VehicleCommand
from dray.messages.contract import (
    Accepted,
    Award,
    Bid,
    Confirmed,
    Declined,
    Docked,
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
)
from dray.messages.fact import Event, EventsAsked, EventsKept
from dray.messages.heartbeat import AtvHeartbeat, MachineHeartbeat
from dray.messages.order import (
    CancellationTaken,
    OrderCancelled,
    OrderReleased,
    OrderRevoked,
    OrderTaken,
    RevocationTaken,
)


class Kind(StrEnum):
    """What an agent is."""

    ATV = "atv"
    MACHINE = "machine"
    STRATEGIST = "strategist"
    GATEWAY = "gateway"
    HISTORIAN = "historian"


_ATVS = frozenset({Kind.ATV})
_MACHINES = frozenset({Kind.MACHINE})
_STRATEGISTS = frozenset({Kind.STRATEGIST})
_GATEWAYS = frozenset({Kind.GATEWAY})
_BIDDERS = _ATVS | _MACHINES
_COORDINATORS = _MACHINES | _STRATEGISTS
_TELLERS = _BIDDERS | _COORDINATORS

SPEAKERS: Mapping[type[Message], frozenset[Kind]] = {
    AtvHeartbeat: _ATVS,
    MachineHeartbeat: _MACHINES,
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
    Resigned: _ATVS,
    TakenOver: _ATVS,
    Docked: _ATVS,
    DockOpened: _MACHINES,
    DockHeld: _MACHINES,
    Handover: _ATVS,
    HandoverAccepted: _MACHINES,
    BerthClaimed: _ATVS,
    CommandAnswered: _ATVS,
    OrderReleased: _GATEWAYS,
    OrderCancelled: _GATEWAYS,
    OrderRevoked: _GATEWAYS,
    VehicleCommand: _GATEWAYS,
    OrderTaken: _STRATEGISTS,
    CancellationTaken: _STRATEGISTS,
    RevocationTaken: _STRATEGISTS,
    Event: _TELLERS,
    EventsKept: _TELLERS,
    EventsAsked: _GATEWAYS | {Kind.HISTORIAN},
}
"""Every message, and the kinds of agents that may say it."""
