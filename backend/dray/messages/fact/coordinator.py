"""What a coordinator tells: its tasks, their auctions, and what it has learned of contractors."""

from __future__ import annotations

from typing import Literal

from msgspec import UNSET, UnsetType

from dray.messages.base import Count, Id, IdOrNone, Metres, Seconds
from dray.messages.contract import Refusal, Work
from dray.messages.cost import Cost
from dray.messages.fact.base import Fact
from dray.messages.heartbeat import Role
from dray.messages.kinds import COORDINATORS, DOCKS, VEHICLES
from dray.messages.reason import Implausible, Reason
from dray.messages.transport import TransportRefusal, TransportState, TransportWait

Outcome = Literal["delivered", "withdrawn"]
"""How a task has ended."""

Answer = Literal["accepted", "declined", "silent"]
"""What became of an award."""


class TaskOpened(Fact, told_by=COORDINATORS, frozen=True):
    """A round of bidding began (round 1 of epoch 1 is the birth of the task)."""

    task: Id
    epoch: Count
    role: Role
    round: Count
    work: Work
    radius_m: Metres
    deadline_s: Seconds
    bids_until_s: Seconds


class BidReceived(Fact, told_by=COORDINATORS, frozen=True):
    """A bid came in time."""

    task: Id
    epoch: Count
    role: Role
    round: Count
    bidder: Id
    cost: Cost
    total_s: Seconds
    finish_s: Seconds
    source: IdOrNone = ""
    surcharge_s: Seconds = 0.0
    """What its coordinator adds before it ranks, for what it has seen of the bidder (`ContractorRated`)."""
    battery_reckoned: bool | UnsetType = UNSET
    """As the bid has said it."""


class AwardGiven(Fact, told_by=COORDINATORS, frozen=True):
    """A bidder was asked to take the contract; `rank` is 1 for the cheapest."""

    task: Id
    epoch: Count
    role: Role
    bidder: Id
    rank: Count


class AwardAnswered(Fact, told_by=COORDINATORS, frozen=True):
    """What became of an award: accepted, declined with a reason, or silent."""

    task: Id
    epoch: Count
    role: Role
    bidder: Id
    answer: Answer
    reason: Refusal | None = None
    """Why it was declined."""


class RoundFailed(Fact, told_by=COORDINATORS, frozen=True):
    """Nobody was contracted in this round; the next one begins at `next_round_s`."""

    task: Id
    epoch: Count
    role: Role
    round: Count
    bids: Count
    next_round_s: Seconds


class WatchLost(Fact, told_by=DOCKS, frozen=True):
    """A task has no secondary any more; another one is sought."""

    task: Id
    epoch: Count
    secondary: IdOrNone
    reason: Reason


class TaskClosed(Fact, told_by=COORDINATORS, frozen=True):
    """A task ended: `delivered` or `withdrawn` (invariant 1)."""

    task: Id
    epoch: Count
    outcome: Outcome
    carrier: IdOrNone
    promised_s: Seconds = 0.0
    """When the carrier had promised to be done (plant clock); 0 when nobody had."""


class PrimarySuspected(Fact, told_by=VEHICLES | DOCKS, frozen=True):
    """Nothing was heard of a task's primary for longer than the suspicion bound."""

    task: Id
    epoch: Count
    primary: Id
    silent_s: Seconds


class CarrierChanged(Fact, told_by=DOCKS, frozen=True):
    """A task has another carrier, or is without one and put up for auction again."""

    task: Id
    epoch: Count
    """The new one."""
    replaced: Id
    carrier: IdOrNone
    """The secondary that has taken over; empty when the task is announced anew."""
    reason: Reason
    silent_s: Seconds = 0.0
    """How long nothing had been heard of the one that was replaced."""


class ContractorRated(Fact, told_by=DOCKS, frozen=True):
    """What a coordinator has learned of a contractor, from its own contracts with it."""

    contractor: Id
    task: Id
    """What it was learned from."""
    reason: Reason
    """`KEPT`, `LATE`, or why it was dropped."""
    surcharge_s: Seconds
    """Added to its bids from now on; half of it is forgotten in half an hour."""
    restricted: bool
    """It is given short tasks only."""
    late_s: Seconds = 0.0
    """How much later than promised it was done, where that is the reason."""


class WordDisbelieved(Fact, told_by=COORDINATORS, frozen=True):
    """A coordinator does not believe what a contractor has said: it cannot be. Told once a minute of each."""

    contractor: Id
    task: Id
    reason: Implausible
    clock_ahead_s: Seconds = 0.0
    """How far the contractor's clock is ahead of the coordinator's, behind if negative; 0 where that is not the reason."""


class NameMisused(Fact, told_by=DOCKS, frozen=True):
    """Somebody requests places in the name of a vehicle that holds some, and has not signed with its key. Told once a minute of each."""

    atv: Id


class BookRefused(Fact, told_by=DOCKS, frozen=True):
    """A replica's table is not copied: it takes places from vehicles that have not given them back, or has a version to which no reservation table has come.

    Told once a minute of each.
    """

    keeper: Id


class HandoverDisputed(Fact, told_by=DOCKS, frozen=True):
    """A contractor says that a load is down, and the dock where it was to go has counted something else."""

    task: Id
    epoch: Count
    contractor: Id
    item: Id
    said: Count
    """Pieces, by the contractor's word."""
    counted: Count
    """Pieces, by the dock's count: these are there, and no others."""
    where: Id
    """The place whose dock has counted."""


class TransportProgressed(Fact, told_by=DOCKS, frozen=True):
    """A plain transport that somebody has asked for is otherwise than before."""

    transport: Id
    state: TransportState
    item: Id
    quantity: Count
    """Pieces that are still to be brought, or were brought when it is delivered."""
    source: Id
    destination: Id
    task: IdOrNone = ""
    """Under which name it is given out at present; empty for none."""
    carrier: IdOrNone = ""
    expected_s: Seconds | None = None
    """When its carrier has promised to be done (plant clock)."""
    wait: TransportWait | None = None
    """Why nobody carries it, while it waits."""
    refused: TransportRefusal | None = None
    """Why it cannot be done, where that has ended it."""
