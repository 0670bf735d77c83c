"""Facts: what an agent writes into its own numbered history.

An agent numbers its facts from 1 in every incarnation and publishes each as an `Event`. The
historian keeps them in SQL; panels and reports are computed from them. A fact says what the agent
itself did, decided or saw, and nothing about what others might think of it.
"""

from __future__ import annotations

from dray.messages.base import Message, Part
from dray.messages.contract import Cost, Refusal, Work
from dray.messages.heartbeat import AtvStatus, MachineStatus, Phase, Role


class Fact(Part, tag_field="kind", tag=True, frozen=True):
    """One thing that happened, named by its class name in `kind`."""


# --- said by a coordinator -----------------------------------------------------------------------


class TaskOpened(Fact, frozen=True):
    """A round of bidding began (round 1 of epoch 1 is the birth of the task)."""

    task: str
    epoch: int
    role: Role
    round: int
    work: Work
    radius_m: float
    deadline_s: float
    bids_until_s: float


class BidReceived(Fact, frozen=True):
    """A bid came in time."""

    task: str
    epoch: int
    role: Role
    round: int
    bidder: str
    cost: Cost
    total_s: float
    finish_s: float
    source: str = ""


class AwardGiven(Fact, frozen=True):
    """A bidder was asked to take the contract; `rank` is 1 for the cheapest."""

    task: str
    epoch: int
    role: Role
    bidder: str
    rank: int


class AwardAnswered(Fact, frozen=True):
    """What became of an award: accepted, declined with a reason, or silent."""

    task: str
    epoch: int
    role: Role
    bidder: str
    answer: str
    """`accepted`, `silent`, or the reason of the decline."""


class RoundFailed(Fact, frozen=True):
    """Nobody was contracted in this round; the next one begins at `next_round_s`."""

    task: str
    epoch: int
    role: Role
    round: int
    bids: int
    next_round_s: float


class WatchLost(Fact, frozen=True):
    """A task has no secondary any more; another one is sought."""

    task: str
    epoch: int
    secondary: str
    reason: str


class TaskClosed(Fact, frozen=True):
    """A task ended: `delivered` or `withdrawn` (invariant 1)."""

    task: str
    epoch: int
    outcome: str
    carrier: str
    promised_s: float = 0.0
    """When the carrier had promised to be done (plant clock); 0 when nobody had."""


class PrimarySuspected(Fact, frozen=True):
    """Nothing was heard of a task's primary for longer than the suspicion bound."""

    task: str
    epoch: int
    primary: str
    silent_s: float


# --- said by a contractor ------------------------------------------------------------------------


class BidSent(Fact, frozen=True):
    """The vehicle or machine made a bid; the bid itself is the coordinator's fact."""

    task: str
    epoch: int
    role: Role
    total_s: float


class BidRefused(Fact, frozen=True):
    """It did not bid, and why (protocol, step 2)."""

    task: str
    epoch: int
    role: Role
    reason: Refusal
    detail: str = ""


class ContractTaken(Fact, frozen=True):
    """It is bound now."""

    task: str
    epoch: int
    role: Role
    coordinator: str


class ContractEnded(Fact, frozen=True):
    """It is free of this contract: `handed_over`, `released`, `resigned`, `superseded`, `withdrawn`."""

    task: str
    epoch: int
    role: Role
    reason: str


class PhaseEntered(Fact, frozen=True):
    """A carriage went one step further."""

    task: str
    epoch: int
    phase: Phase
    station: str = ""


class AtvStatusChanged(Fact, frozen=True):
    """The vehicle's state machine took a step."""

    status: AtvStatus
    reason: str = ""


class CommandObeyed(Fact, frozen=True):
    """A person's command was carried out, or refused with a reason."""

    command: str
    what: str
    done: bool
    reason: str = ""
    issued_by: str = ""


# --- said by a machine ---------------------------------------------------------------------------


class MachineStatusChanged(Fact, frozen=True):
    """The machine began, starved, was blocked, broke or stopped."""

    status: MachineStatus
    product: str = ""
    reason: str = ""


class PieceMade(Fact, frozen=True):
    """One cycle ended well."""

    goal: str
    product: str
    made: int
    """Of this goal, with this one."""


class GoodsDelivered(Fact, frozen=True):
    """Finished goods of a goal reached the delivery warehouse."""

    goal: str
    order: str
    item: int
    product: str
    quantity: int
    """In this transport."""
    delivered: int
    """Of this goal, with these."""


# --- said by the strategist ----------------------------------------------------------------------


class OrderAccepted(Fact, frozen=True):
    """The strategist split an order into goals."""

    order: str
    goals: tuple[str, ...]


class GoalContracted(Fact, frozen=True):
    """A machine took a goal."""

    goal: str
    order: str
    item: int
    product: str
    quantity: int
    machine: str
    finish_s: float


class OrderProgressed(Fact, frozen=True):
    """How much of an order is made and delivered, over all its goals."""

    order: str
    made: int
    delivered: int
    quantity: int


class OrderFulfilled(Fact, frozen=True):
    """All of an order is in the delivery warehouse."""

    order: str


class OrderDropped(Fact, frozen=True):
    """A cancelled order left the strategist's books."""

    order: str


AnyFact = (
    TaskOpened
    | BidReceived
    | AwardGiven
    | AwardAnswered
    | RoundFailed
    | WatchLost
    | TaskClosed
    | PrimarySuspected
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
    | OrderProgressed
    | OrderFulfilled
    | OrderDropped
)


class Event(Message, frozen=True):
    """One numbered line of an agent's history."""

    agent: str
    incarnation: int
    number: int
    """1, 2, 3 ... in one incarnation, without a gap."""
    at_s: float
    fact: AnyFact
