"""Messages between strategists and the gate of the delivery warehouses: admissions, arrivals, and the holders of orders.

Messages may be lost, doubled or late. Strategists repeat questions, and the gate repeats its own reports, until they are answered.
Counts are totals, and messages about one goal are numbered, so that old ones change nothing.
"""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta

from dray.messages.base import Count, Id, IdOrNone, Message, Part
from dray.messages.contract import Brought
from dray.messages.kinds import GATES, STRATEGISTS

HELD_TOLD = 500
"""Maximum orders in one `GateReported`: some ten kilobytes."""


class GoalOf(Part, frozen=True):
    """A goal's order and machine, for a strategist that takes the order over."""

    order: Id
    item: Count
    """Its index in the order."""
    machine: Id
    epoch: Count
    """Epoch of the contract with the machine."""


class GoalHeld(Part, frozen=True):
    """A goal of an order, as the gate knows it."""

    goal: Id
    of: GoalOf
    admitted: Count
    arrived: Count


class OrderHeld(Part, frozen=True):
    """The holder of an order, for a strategist that claims it, has lost it, or admits a goal of it without holding it."""

    order: Id
    holder: Id
    epoch: Count
    arrived: tuple[Count, ...] = ()
    """Pieces that have arrived, per item, of all goals that the order ever had; for the holder."""
    goals: tuple[GoalHeld, ...] = ()
    """Open goals; for the holder."""
    over: Count = 0
    """The newest release that has ended."""
    done: tuple[GoalHeld, ...] = ()
    """Closed goals of which pieces have arrived; for the holder."""


class HeldOrder(Part, frozen=True):
    """An order that a strategist holds."""

    order: Id
    epoch: Count


class GateAsked(Message, said_by=STRATEGISTS, frozen=True):
    """A strategist asks which orders it holds, after its own or the gate's restart. Repeated until the gate answers."""

    forgotten: bool = False
    """Whether it has lost its memory: the gate closes for all goals of its earlier lives, and answers then."""
    after: IdOrNone = ""
    """Only orders after this one, by name, are asked for: a long list comes in parts."""


class GateReported(Message, said_by=GATES, frozen=True):
    """The gate answers `GateAsked`."""

    after: IdOrNone
    held: Annotated[tuple[HeldOrder, ...], Meta(max_length=HELD_TOLD)]
    """The orders that the strategist holds, sorted by name; none in a plant with one strategist."""
    more: bool
    """Whether there are further orders after these."""
    since: Count
    """The gate's life in which its notes begin: a change means that the gate has lost everything."""


class AdmissionAsked(Message, said_by=STRATEGISTS, frozen=True, omit_defaults=True):
    """A strategist sets how many pieces of a goal may get in, those arrived included. Repeated until `GoodsCounted` answers."""

    goal: Id
    quantity: Count
    incarnation: Count
    number: Count
    """Number in this life of the strategist; the gate ignores older messages about the goal."""
    of: GoalOf | None = None
    """Set for a new goal in a plant with several strategists."""
    held: Count = 0
    """Epoch under which its order is held; 0 in a plant with one strategist."""


class GoodsCounted(Message, said_by=GATES, frozen=True, omit_defaults=True):
    """The gate's count of a goal's pieces: as an answer, and after each arrival until `CountAcknowledged` answers."""

    goal: Id
    arrived: Count
    admitted: Count
    """How many pieces may get in; 0 means that the gate is shut and `arrived` is final."""
    incarnation: Count = 0
    number: Count = 0
    """Number of the newest message about this goal that the gate has carried out; 0 while it carries one out."""
    brought: tuple[Brought, ...] = ()
    """The pieces by vehicle, as far as the gate knows."""
    by_people: bool = False
    """Whether people count, or a gate where containers wait, after the goods have come."""


class CountAcknowledged(Message, said_by=STRATEGISTS, frozen=True):
    """A strategist has got the gate's count of a goal."""

    goal: Id
    arrived: Count


class OrderClaimed(Message, said_by=STRATEGISTS, frozen=True, omit_defaults=True):
    """A strategist claims an order, or reports that one which it holds has ended. Repeated until `HolderReported` answers."""

    order: Id
    epoch: Count
    over: Count = 0
    """The newest release that has ended: no later holder makes anything for it or earlier ones."""
    again: Count = 0
    """The release that its holder makes although it was said to have ended; 0 for none."""


class HolderReported(Message, said_by=GATES, frozen=True):
    """The gate names the holder of an order: as an answer, and to a holder that has lost it until `HolderAcknowledged` answers."""

    held: OrderHeld


class HolderAcknowledged(Message, said_by=STRATEGISTS, frozen=True):
    """A strategist knows that another one holds an order."""

    order: Id
    epoch: Count
