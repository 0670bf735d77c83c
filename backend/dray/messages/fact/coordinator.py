"""Facts of a coordinator: its tasks, their auctions, and its ratings of contractors."""

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
"""The result of an award."""


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
    """The coordinator's surcharge on this bidder before it ranks the bids (`ContractorRated`)."""
    battery_reckoned: bool | UnsetType = UNSET
    """The same field of the bid."""


class AwardGiven(Fact, told_by=COORDINATORS, frozen=True):
    """A bidder was asked to take the contract; `rank` is 1 for the cheapest."""

    task: Id
    epoch: Count
    role: Role
    bidder: Id
    rank: Count


class AwardAnswered(Fact, told_by=COORDINATORS, frozen=True):
    """The result of an award: accepted, declined with a reason, or silent."""

    task: Id
    epoch: Count
    role: Role
    bidder: Id
    answer: Answer
    reason: Refusal | None = None
    """Why it was declined."""


class RoundFailed(Fact, told_by=COORDINATORS, frozen=True):
    """This round contracted no bidder; the next one begins at `next_round_s`."""

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
    """When the carrier had promised to be done (plant clock); 0 without a promise."""


class PrimarySuspected(Fact, told_by=VEHICLES | DOCKS, frozen=True):
    """A task's primary was silent for longer than the suspicion bound."""

    task: Id
    epoch: Count
    primary: Id
    silent_s: Seconds


class CarrierChanged(Fact, told_by=DOCKS, frozen=True):
    """A task has another carrier, or is without one and put up for auction again."""

    task: Id
    epoch: Count
    """The new epoch."""
    replaced: Id
    carrier: IdOrNone
    """The secondary that has taken over; empty when the task is announced anew."""
    reason: Reason
    silent_s: Seconds = 0.0
    """How long the replaced carrier had been silent."""


class ContractorRated(Fact, told_by=DOCKS, frozen=True):
    """A coordinator's rating of a contractor, from its own contracts with it."""

    contractor: Id
    task: Id
    """The task that led to the rating."""
    reason: Reason
    """`KEPT`, `LATE`, or why it was dropped; `DISPUTED` if that counts no more, since the place is at fault."""
    surcharge_s: Seconds
    """Surcharge on its bids from now on, with a half-life of half an hour."""
    restricted: bool
    """Whether it gets short tasks only."""
    late_s: Seconds = 0.0
    """Delay beyond its promise, if that is the reason."""


class WordDisbelieved(Fact, told_by=COORDINATORS, frozen=True):
    """A coordinator does not believe a contractor's implausible message. At most once a minute for each contractor."""

    contractor: Id
    task: Id
    reason: Implausible
    clock_ahead_s: Seconds = 0.0
    """How far the contractor's clock is ahead of the coordinator's, behind if negative; 0 when that is not the reason."""


class NameMisused(Fact, told_by=DOCKS, frozen=True):
    """An agent requests places in the name of a vehicle that holds some, without its key. At most once a minute for each vehicle."""

    atv: Id


class BookRefused(Fact, told_by=DOCKS, frozen=True):
    """A replica's table is refused: it takes places from vehicles without their release, or has an implausible version.

    Recorded at most once a minute for each replica.
    """

    keeper: Id


class HandoverDisputed(Fact, told_by=DOCKS, frozen=True):
    """A contractor reports a load as down, and the dock has counted something else."""

    task: Id
    epoch: Count
    contractor: Id
    item: Id
    said: Count
    """Pieces by the contractor's report."""
    counted: Count
    """Pieces by the dock's count, which is the valid one."""
    where: Id
    """The place whose dock has counted."""


class LoadDoubted(Fact, told_by=DOCKS, frozen=True):
    """Nobody can tell whether a load lies at this place, and a person is asked to count. It is not in the stock."""

    load: Id
    """Its name (`DoubtfulLoad`)."""
    vehicle: Id
    item: Id
    quantity: Count
    brought: bool
    """Whether the vehicle was to bring it; otherwise to take it."""
    task: IdOrNone = ""
    """Its transport; empty where no notes say for which the vehicle was let in."""


class TransportProgressed(Fact, told_by=DOCKS, frozen=True):
    """The state of a plain transport has changed."""

    transport: Id
    state: TransportState
    item: Id
    quantity: Count
    """Pieces still to be brought, or brought once it is delivered."""
    source: Id
    destination: Id
    task: IdOrNone = ""
    """The name of its present task; empty for none."""
    carrier: IdOrNone = ""
    expected_s: Seconds | None = None
    """When its carrier has promised to be done (plant clock)."""
    wait: TransportWait | None = None
    """Why it has no carrier, while it waits."""
    refused: TransportRefusal | None = None
    """Why it cannot be done, if that has ended it."""
