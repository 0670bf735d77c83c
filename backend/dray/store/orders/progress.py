"""How far an order has come, computed from its goals. Pure: the historian and the panels share it.

Facts come late, doubled and in any order, so a goal only ever keeps the most that was told of it,
and an order is computed anew from all of its goals: the result does not depend on the order in
which the facts came.

A goal *counts as running* while the strategist's newest life knows it, its machine has not failed with
it and its order was not taken back. What another goal had made but not delivered is gone; what it
delivered stays delivered and is never made again.

Of several strategists, whoever holds an order goes on with all goals of it that machines make, and says which it does not; a later
holder tells with a higher epoch (`held`). Their lives are counted each for itself, and compared with nobody else's.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from enum import StrEnum

import msgspec

from dray.messages import Event
from dray.messages.fact import (
    GoalContracted,
    GoalLost,
    GoalReduced,
    GoalWithdrawn,
    GoodsDelivered,
    OrderAccepted,
    PieceMade,
)
from dray.store.history.clocks import ToWall


class OrderStatus(StrEnum):
    """The life of an order (ISA-95's define, publish, and what the factory makes of it)."""

    STORED = "stored"
    RELEASED = "released"
    IN_PRODUCTION = "in_production"
    IN_DELIVERY = "in_delivery"
    DELIVERED = "delivered"
    CANCELLED = "cancelled"


OPEN = (OrderStatus.RELEASED, OrderStatus.IN_PRODUCTION, OrderStatus.IN_DELIVERY)
"""The factory works at these."""

UNENDED = (OrderStatus.STORED, *OPEN)
"""Something may still become of these."""

ENDED = (OrderStatus.DELIVERED, OrderStatus.CANCELLED)
"""Nothing changes any more."""


class Goal(msgspec.Struct, gc=False):
    """What is known of one production goal. Fields are 0 or empty until a fact has told them."""

    id: str
    order_id: str | None = None
    item: int | None = None
    """Of its order, whose pieces it makes; None for parts, which count for none."""
    product: str = ""
    quantity: int = 0
    machine: str = ""
    """Empty before a contract was heard of, and again when the machine has failed with it or need not make it."""
    promised_at_s: float | None = None
    incarnation: int = 0
    """Life of the strategist that contracted it, or that ended it; 0 while neither was heard of."""
    number: int = 0
    """Which of that life's facts told it."""
    held: int = 0
    """The epoch with which that strategist held the order; 0 of one that is alone."""
    made: int = 0
    """Never falls."""
    delivered: int = 0
    """Never falls."""
    delivered_at_s: float | None = None
    """When the last delivery arrived (wall clock)."""

    @property
    def told(self) -> tuple[int, int, int]:
        """Rises with every fact that says by whom it is made, and how much of it."""
        return self.held, self.incarnation, self.number

    @property
    def lost(self) -> bool:
        """Whether its machine has failed with it: what is missing goes on under another name."""
        return self.over and self.quantity > 0

    @property
    def over(self) -> bool:
        """Whether its machine has failed with it, or its order was taken back."""
        return self.incarnation > 0 and not self.machine

    def is_known(self, life: int) -> bool:
        """Whether whoever works at its order knows it, when this is the newest life that has accepted that."""
        return self.held > 0 or self.incarnation >= life


class Progress(msgspec.Struct, frozen=True, gc=False):
    """How far an order has come."""

    status: OrderStatus
    made: tuple[int, ...]
    """Per item, at most its quantity."""
    delivered: tuple[int, ...]
    delivered_at_s: float | None
    """When the last piece arrived that a fact tells of; None before all have arrived."""


OfGoal = GoalContracted | GoalLost | GoalReduced | GoalWithdrawn | PieceMade | GoodsDelivered
"""Facts that tell something about a goal."""


def goal_of(event: Event) -> str | None:
    """The id of the goal that this event tells something about, if any."""
    fact = event.fact
    return fact.goal or None if isinstance(fact, OfGoal) else None


def accepted_order(event: Event) -> str | None:
    """The id of the order that this event tells the acceptance of, if any."""
    return event.fact.order if isinstance(event.fact, OrderAccepted) else None


def life_with(event: Event) -> int:
    """The life that has accepted an order and knows no goals of earlier ones; 0 where whoever holds the order knows all."""
    return 0 if isinstance(event.fact, OrderAccepted) and event.fact.held else event.incarnation


def note(goal: Goal, event: Event, to_wall_s: ToWall) -> None:
    """Add to a goal what an event tells about it; twice is once, and late is as good as early."""
    match event.fact:
        case GoalContracted() as fact:
            goal.order_id, goal.product = fact.order, fact.product
            goal.item = None if fact.part_of else fact.item
            if _is_news(goal, event, fact.held):
                goal.quantity, goal.machine = fact.quantity, fact.machine
                goal.promised_at_s = to_wall_s(fact.finish_s)
        case GoalLost() | GoalWithdrawn() as fact:
            if _is_news(goal, event, fact.held):
                goal.machine, goal.promised_at_s = "", None
                if isinstance(fact, GoalWithdrawn):
                    goal.quantity = 0  # Nobody makes what is missing, unless the order is released again.
            if fact.arrived > 0:
                # The delivery warehouse has counted more than the machine could still tell. When the last
                # piece came is not told; now is the latest that it can have been.
                goal.delivered = max(goal.delivered, fact.arrived)
                goal.delivered_at_s = max(goal.delivered_at_s or 0.0, to_wall_s(event.at_s))
        case GoalReduced() as fact:
            goal.order_id, goal.item, goal.product = fact.order, fact.item, fact.product
            if _is_news(goal, event, fact.held):
                goal.quantity, goal.machine = fact.quantity, fact.machine
        case PieceMade() as fact:
            goal.product = fact.product
            goal.made = max(goal.made, fact.made)
        case GoodsDelivered() as fact:
            goal.order_id, goal.item, goal.product = fact.order, fact.item, fact.product
            goal.delivered = max(goal.delivered, fact.delivered)
            goal.made = max(goal.made, fact.delivered)
            goal.delivered_at_s = max(goal.delivered_at_s or 0.0, to_wall_s(event.at_s))
        case _:
            return


def _is_news(goal: Goal, event: Event, held: int) -> bool:
    """Whether an event tells what comes after all that was noted of a goal; it is noted then."""
    told = (held, event.incarnation, event.number)
    if told <= goal.told:
        return False
    goal.held, goal.incarnation, goal.number = told
    return True


def merge(goal: Goal, other: Goal) -> None:
    """Add to a goal what somebody else knows of it, as if all facts behind that were noted, too."""
    if other.item is not None:
        goal.order_id, goal.item = other.order_id, other.item
    goal.product = other.product or goal.product
    if other.told > goal.told:
        goal.held, goal.incarnation, goal.number = other.told
        goal.quantity, goal.machine = other.quantity, other.machine
        goal.promised_at_s = other.promised_at_s
    goal.made = max(goal.made, other.made)
    goal.delivered = max(goal.delivered, other.delivered)
    if other.delivered_at_s is not None:
        goal.delivered_at_s = max(goal.delivered_at_s or 0.0, other.delivered_at_s)


def progress(
    quantities: Sequence[int], goals: Iterable[Goal], incarnation: int, arrived: Sequence[int]
) -> Progress:
    """Compute how far an order has come.

    Args:
        quantities: pieces ordered, per item.
        goals: all goals of the order that are known.
        incarnation: the newest life of the strategist that has accepted the order; 0 for none.
        arrived: pieces that are known to be delivered, per item, if facts about them come later.
    """
    made, delivered = [0] * len(quantities), [0] * len(quantities)
    running, last_s = False, 0.0
    for goal in goals:
        if goal.item is None or not 0 <= goal.item < len(quantities):
            continue
        alive = goal.is_known(incarnation) and not goal.over
        running = running or (alive and goal.incarnation > 0)
        made[goal.item] += goal.made if alive else goal.delivered
        delivered[goal.item] += goal.delivered
        last_s = max(last_s, goal.delivered_at_s or 0.0)
    delivered = [max(pair) for pair in zip(delivered, arrived, strict=True)]
    delivered = [min(pair) for pair in zip(delivered, quantities, strict=True)]
    made = [max(pair) for pair in zip(made, delivered, strict=True)]
    made = [min(pair) for pair in zip(made, quantities, strict=True)]
    if delivered == list(quantities):
        status = OrderStatus.DELIVERED
    elif any(delivered) or made == list(quantities):
        status = OrderStatus.IN_DELIVERY
    elif running or any(made):
        status = OrderStatus.IN_PRODUCTION
    else:
        status = OrderStatus.RELEASED
    ended_s = (last_s or None) if status is OrderStatus.DELIVERED else None
    return Progress(status, tuple(made), tuple(delivered), ended_s)


def status_after(status: OrderStatus, reached: OrderStatus) -> OrderStatus:
    """What an order becomes whose goals say how far it has come.

    A cancelled order stays cancelled. So does a stored one stay stored, unless all of it has arrived: it was
    taken back too late.
    """
    keeps = status is OrderStatus.CANCELLED or (
        status is OrderStatus.STORED and reached is not OrderStatus.DELIVERED
    )
    return status if keeps else reached


def delivered_after(status: OrderStatus, known_s: float | None, reached_s: float | None) -> float | None:
    """When the last piece of an order arrived that has this status now; None when they have not all arrived.

    Args:
        status: what the order is now.
        known_s: what was written down before: without facts it is when the strategist's word came.
        reached_s: what facts say; they know better, however late they come.
    """
    return (reached_s or known_s) if status is OrderStatus.DELIVERED else None
