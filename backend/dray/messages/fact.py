"""Facts: what an agent writes into its own numbered history.

An agent numbers its facts from 1 in every incarnation and publishes each as an `Event`. The
historian keeps them in SQL; panels and reports are computed from them. A fact says what the agent
itself did, decided or saw, and nothing about what others might think of it.
"""

from __future__ import annotations

from dray.messages.base import Count, Id, IdOrNone, Message, Metres, Part, Seconds, Text
from dray.messages.contract import Cost, Refusal, Work
from dray.messages.heartbeat import AtvStatus, Link, MachineStatus, Phase, Role


class Fact(Part, tag_field="kind", tag=True, frozen=True):
    """One thing that happened, named by its class name in `kind`."""


# --- said by a coordinator -----------------------------------------------------------------------


class TaskOpened(Fact, frozen=True):
    """A round of bidding began (round 1 of epoch 1 is the birth of the task)."""

    task: Id
    epoch: Count
    role: Role
    round: Count
    work: Work
    radius_m: Metres
    deadline_s: Seconds
    bids_until_s: Seconds


class BidReceived(Fact, frozen=True):
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


class AwardGiven(Fact, frozen=True):
    """A bidder was asked to take the contract; `rank` is 1 for the cheapest."""

    task: Id
    epoch: Count
    role: Role
    bidder: Id
    rank: Count


class AwardAnswered(Fact, frozen=True):
    """What became of an award: accepted, declined with a reason, or silent."""

    task: Id
    epoch: Count
    role: Role
    bidder: Id
    answer: Text
    """`accepted`, `silent`, or the reason of the decline."""


class RoundFailed(Fact, frozen=True):
    """Nobody was contracted in this round; the next one begins at `next_round_s`."""

    task: Id
    epoch: Count
    role: Role
    round: Count
    bids: Count
    next_round_s: Seconds


class WatchLost(Fact, frozen=True):
    """A task has no secondary any more; another one is sought."""

    task: Id
    epoch: Count
    secondary: IdOrNone
    reason: Text


class TaskClosed(Fact, frozen=True):
    """A task ended: `delivered` or `withdrawn` (invariant 1)."""

    task: Id
    epoch: Count
    outcome: Text
    carrier: IdOrNone
    promised_s: Seconds = 0.0
    """When the carrier had promised to be done (plant clock); 0 when nobody had."""


class PrimarySuspected(Fact, frozen=True):
    """Nothing was heard of a task's primary for longer than the suspicion bound."""

    task: Id
    epoch: Count
    primary: Id
    silent_s: Seconds


class CarrierChanged(Fact, frozen=True):
    """A task has another carrier, or is without one and put up for auction again."""

    task: Id
    epoch: Count
    """The new one."""
    replaced: Id
    carrier: IdOrNone
    """The secondary that has taken over; empty when the task is announced anew."""
    reason: Text
    silent_s: Seconds = 0.0
    """How long nothing had been heard of the one that was replaced."""


class ContractorRated(Fact, frozen=True):
    """What a coordinator has learned of a contractor, from its own contracts with it."""

    contractor: Id
    task: Id
    """What it was learned from."""
    reason: Text
    """`kept`, how late it was, or why it was dropped."""
    surcharge_s: Seconds
    """Added to its bids from now on; half of it is forgotten in half an hour."""
    restricted: bool
    """It is given short tasks only."""


class WordDisbelieved(Fact, frozen=True):
    """A coordinator does not believe what a contractor has said: it cannot be. Told once a minute of each."""

    contractor: Id
    task: Id
    reason: Text
    clock_ahead_s: Seconds = 0.0
    """How far the contractor's clock is ahead of the coordinator's, behind if negative; 0 where that is not the reason."""


class HandoverDisputed(Fact, frozen=True):
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


# --- said by a contractor ------------------------------------------------------------------------


class BidSent(Fact, frozen=True):
    """The vehicle or machine made a bid; the bid itself is the coordinator's fact."""

    task: Id
    epoch: Count
    role: Role
    total_s: Seconds


class BidRefused(Fact, frozen=True):
    """It did not bid, and why (protocol, step 2)."""

    task: Id
    epoch: Count
    role: Role
    reason: Refusal
    detail: Text = ""


class ContractTaken(Fact, frozen=True):
    """It is bound now."""

    task: Id
    epoch: Count
    role: Role
    coordinator: Id


HANDED_OVER = "handed_over"
"""Why a contract has ended (`ContractEnded.reason`) that was done well."""


class ContractEnded(Fact, frozen=True):
    """It is free of this contract: `handed_over`, `released`, `resigned`, `superseded`, `withdrawn`."""

    task: Id
    epoch: Count
    role: Role
    reason: Text


class NotBelieved(Fact, frozen=True):
    """A coordinator has said that it does not believe this agent, and why. Told once a minute of each."""

    by: Id
    task: Id
    reason: Text


class TookOver(Fact, frozen=True):
    """A secondary carries the task from now on, because its primary has failed."""

    task: Id
    epoch: Count
    """The new one."""
    primary: Id
    """Whom it replaces."""
    silent_s: Seconds
    reason: Text


class LinkChanged(Fact, frozen=True):
    """The vehicle is on the WLAN again, or left with its radio (paper, case 3)."""

    link: Link


class HelpAsked(Fact, frozen=True):
    """The vehicle has a problem that a person can solve (paper, case 4)."""

    task: IdOrNone
    reason: Text
    until_s: Seconds


class HelpPromised(Fact, frozen=True):
    """A person is on the way, and the takeover is held back until then."""

    until_s: Seconds
    promised_by: Text


class PhaseEntered(Fact, frozen=True):
    """A transport went one step further."""

    task: Id
    epoch: Count
    phase: Phase
    station: IdOrNone = ""


class AtvStatusChanged(Fact, frozen=True):
    """The vehicle's state machine took a step."""

    status: AtvStatus
    reason: Text = ""


class CommandObeyed(Fact, frozen=True):
    """A person's command was carried out, or refused with a reason."""

    command: Id
    what: Text
    done: bool
    reason: Text = ""
    issued_by: Text = ""


# --- said by a machine ---------------------------------------------------------------------------


class MachineStatusChanged(Fact, frozen=True):
    """The machine began, starved, was blocked, broke or stopped."""

    status: MachineStatus
    product: IdOrNone = ""
    reason: Text = ""


class PieceMade(Fact, frozen=True):
    """One cycle ended well."""

    goal: Id
    product: Id
    made: Count
    """Of this goal, with this one."""


# --- said by the strategist ----------------------------------------------------------------------


class OrderAccepted(Fact, frozen=True):
    """The strategist split an order into goals."""

    order: Id
    goals: tuple[Id, ...]


class GoalContracted(Fact, frozen=True):
    """A machine took a goal."""

    goal: Id
    order: Id
    item: Count
    product: Id
    quantity: Count
    machine: Id
    finish_s: Seconds


class GoodsDelivered(Fact, frozen=True):
    """Finished goods of a goal reached the delivery warehouse."""

    goal: Id
    order: Id
    item: Count
    product: Id
    quantity: Count
    """In this transport."""
    delivered: Count
    """Of this goal, with these."""


class GoalLost(Fact, frozen=True):
    """A machine has failed with a goal; what had not arrived is announced again under another name."""

    goal: Id
    machine: Id
    arrived: Count
    """Pieces that count, once."""
    successor: IdOrNone
    """The new goal for the rest; empty when nothing was left to make."""


class GoalWithdrawn(Fact, frozen=True):
    """A machine need not make a goal any more, because its order was taken back."""

    goal: Id
    machine: Id
    arrived: Count
    """Pieces that count, once."""


class GoalWaits(Fact, frozen=True):
    """Nobody who lives can make this goal; only its order waits (paper, case 1)."""

    goal: Id
    order: Id
    reason: Text


class OrderProgressed(Fact, frozen=True):
    """How much of an order is made and delivered, over all its goals."""

    order: Id
    made: Count
    delivered: Count
    quantity: Count


class OrderFulfilled(Fact, frozen=True):
    """All of an order is in the delivery warehouse."""

    order: Id


class OrderDropped(Fact, frozen=True):
    """A cancelled order left the strategist's books."""

    order: Id


class OrderReturned(Fact, frozen=True):
    """An order that was taken back left the strategist's books; it may be released again."""

    order: Id
    release: Count
    outstanding: tuple[Count, ...]
    """Per item, what had not arrived."""


# --- said by anybody -----------------------------------------------------------------------------


class MemoryLost(Fact, frozen=True):
    """An agent has begun a life without what it was bound by in earlier ones: its journal was lost or damaged."""

    reason: Text


AnyFact = (
    TaskOpened
    | BidReceived
    | AwardGiven
    | AwardAnswered
    | RoundFailed
    | WatchLost
    | TaskClosed
    | PrimarySuspected
    | CarrierChanged
    | ContractorRated
    | WordDisbelieved
    | HandoverDisputed
    | NotBelieved
    | TookOver
    | LinkChanged
    | HelpAsked
    | HelpPromised
    | BidSent
    | BidRefused
    | ContractTaken
    | ContractEnded
    | PhaseEntered
    | AtvStatusChanged
    | CommandObeyed
    | MachineStatusChanged
    | PieceMade
    | GoodsDelivered
    | OrderAccepted
    | GoalContracted
    | GoalLost
    | GoalWithdrawn
    | GoalWaits
    | OrderProgressed
    | OrderFulfilled
    | OrderDropped
    | OrderReturned
    | MemoryLost
)


EVENTS_PER_ANSWER = 200
"""Events that one answer to `EventsAsked` holds at most."""

HISTORY_KEPT = 10_000
"""Events that an agent keeps of its history, some 5 MB on the disk: nobody asks for older ones. A strategist whose machines
come and go tells a thousand facts in minutes, and what it forgets before the historian is back is gone for good."""


class EventsAsked(Message, frozen=True):
    """Tell again what was missed.

    Answered to the asker alone, with those `Event`s that the agent still has, `EVENTS_PER_ANSWER` at most,
    and then with `EventsKept`. Asking for more than there is shows what was said last.
    """

    incarnation: Count
    first: Count
    last: Count
    """Both included."""


class EventsKept(Message, frozen=True):
    """Which numbers of one of its lives an agent can still tell: all from `first` to `last`.

    What is asked for and lies before `first` is gone for good. None are kept when `last` is below `first`.
    """

    incarnation: Count
    """The life that was asked about."""
    first: Count
    last: Count
    life: Count
    """The one that answers: of those before it there will be no more."""


class Event(Message, frozen=True):
    """One numbered line of an agent's history."""

    agent: Id
    incarnation: Count
    number: Count
    """1, 2, 3 ... in one incarnation, without a gap."""
    at_s: Seconds
    fact: AnyFact
