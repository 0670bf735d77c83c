"""What strategists and the gate of the delivery warehouses say to one another: what is let in, what has arrived, who holds which order.

All of it may be lost, doubled or late. Strategists repeat what they ask until it is answered; the gate repeats what it tells of itself
until that is answered. Counts are totals, and words about one goal are numbered: an old one changes nothing.
"""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta

from dray.messages.base import Count, Id, IdOrNone, Message, Part
from dray.messages.contract import Brought
from dray.messages.kinds import GATES, STRATEGISTS

HELD_TOLD = 500
"""Orders in one `GateReported`: some ten kilobytes."""


class GoalOf(Part, frozen=True):
    """What a goal is for, and who makes it: for a strategist that takes its order over."""

    order: Id
    item: Count
    """Its index in the order."""
    machine: Id
    epoch: Count
    """Of the contract with the machine."""


class GoalHeld(Part, frozen=True):
    """A goal that the gate knows of an order."""

    goal: Id
    of: GoalOf
    admitted: Count
    arrived: Count


class OrderHeld(Part, frozen=True):
    """Who holds an order: the answer to a claim, and said to a holder that has lost it, or admits a goal of what it does not hold."""

    order: Id
    holder: Id
    epoch: Count
    arrived: tuple[Count, ...] = ()
    """Per item, what has arrived of all goals that the order ever had; told to the holder."""
    goals: tuple[GoalHeld, ...] = ()
    """Those that are open; likewise."""
    over: Count = 0
    """Releases up to this one have ended."""
    done: tuple[GoalHeld, ...] = ()
    """Those that are not open any more, and of which something has arrived; told to the holder."""


class HeldOrder(Part, frozen=True):
    """An order that a strategist holds."""

    order: Id
    epoch: Count


class GateAsked(Message, said_by=STRATEGISTS, frozen=True):
    """A strategist begins its life, or has heard that the gate has: what does it hold? Repeated until the gate answers."""

    forgotten: bool = False
    """It remembers nothing: the gate is to be shut for all goals of its earlier lives, and answers when it is."""
    after: IdOrNone = ""
    """Only orders after this one, by name: a long list is told in parts."""


class GateReported(Message, said_by=GATES, frozen=True):
    """The gate answers `GateAsked`."""

    after: IdOrNone
    held: Annotated[tuple[HeldOrder, ...], Meta(max_length=HELD_TOLD)]
    """The orders that the strategist holds, sorted by name; none where a plant has one strategist."""
    more: bool
    """There are further ones, after the last of these."""
    since: Count
    """The life of the gate in which its notes begin: with another one than before it has lost all that it was told."""


class AdmissionAsked(Message, said_by=STRATEGISTS, frozen=True, omit_defaults=True):
    """Let in as many pieces of this goal, those that have arrived included, and no more. Repeated until `GoodsCounted` answers it."""

    goal: Id
    quantity: Count
    incarnation: Count
    number: Count
    """In this life of the strategist: an earlier word about the goal counts for nothing once a later one was heard."""
    of: GoalOf | None = None
    """Told with a new goal where a plant has several strategists."""
    held: Count = 0
    """With which epoch its order is held; 0 where a plant has one strategist."""


class GoodsCounted(Message, said_by=GATES, frozen=True, omit_defaults=True):
    """How many pieces of a goal are in. The gate alone says so: as an answer, and after each arrival until `CountAcknowledged` answers that."""

    goal: Id
    arrived: Count
    admitted: Count
    """How many may get in at all; 0 tells that the gate is shut and `arrived` the last word."""
    incarnation: Count = 0
    number: Count = 0
    """Of the word about this goal that the gate has obeyed last; 0 while it obeys it."""
    brought: tuple[Brought, ...] = ()
    """By whom, as far as the gate can tell."""
    by_people: bool = False
    """People count, later than goods come."""


class CountAcknowledged(Message, said_by=STRATEGISTS, frozen=True):
    """A strategist has heard so many pieces of a goal."""

    goal: Id
    arrived: Count


class OrderClaimed(Message, said_by=STRATEGISTS, frozen=True, omit_defaults=True):
    """A strategist wants to hold an order, or tells that one which it holds has ended. Repeated until `HolderReported` answers it."""

    order: Id
    epoch: Count
    over: Count = 0
    """Releases up to this one have ended: nothing is to be made of them any more, whoever takes the order over."""


class HolderReported(Message, said_by=GATES, frozen=True):
    """Who holds an order: an answer; to a holder that has lost it also unasked, until `HolderAcknowledged` answers that."""

    held: OrderHeld


class HolderAcknowledged(Message, said_by=STRATEGISTS, frozen=True):
    """A strategist has heard that another one holds an order."""

    order: Id
    epoch: Count
