"""An order's progress, computed from its goals. Pure: the historian and the panels share it.

Facts come late, doubled and in any order. So a goal keeps only the maximum reported, and an order is recomputed from all
of its goals: the result does not depend on the order of the facts.

A goal *counts as running* under three conditions: the strategist's newest life knows it, its machine has not failed with
it, and its order was not revoked. Pieces that another goal had made but not delivered are lost; its delivered pieces stay
delivered and are never made again.

With several strategists, an order's holder continues the goals that machines make, and reports the others. A later holder reports
with a higher epoch (`held`). Each strategist's lives are counted separately, and never compared with another's.
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
from dray.messages.history import HISTORY_KEPT, LIVES_TOLD
from dray.messages.overtaken import OVERTAKES_S
from dray.store.history.clocks import ToWall

FAR_APART = (LIVES_TOLD, LIVES_TOLD, HISTORY_KEPT)
"""Epochs, lives and facts of one life beyond which two facts about one goal are far apart (`Goal.told`)."""


class OrderStatus(StrEnum):
    """The life of an order (ISA-95's define, publish, and the factory's progress)."""

    STORED = "stored"
    RELEASED = "released"
    IN_PRODUCTION = "in_production"
    IN_DELIVERY = "in_delivery"
    DELIVERED = "delivered"
    CANCELLED = "cancelled"


OPEN = (OrderStatus.RELEASED, OrderStatus.IN_PRODUCTION, OrderStatus.IN_DELIVERY)
"""Orders that the factory works at."""

UNENDED = (OrderStatus.STORED, *OPEN)
"""Orders that may still change."""

ENDED = (OrderStatus.DELIVERED, OrderStatus.CANCELLED)
"""Final states."""


class Goal(msgspec.Struct, gc=False):
    """The state of one production goal. Fields are 0 or empty until a fact has set them."""

    id: str
    order_id: str | None = None
    item: int | None = None
    """The order's item whose pieces it makes; None for parts, which count for none."""
    product: str = ""
    quantity: int = 0
    machine: str = ""
    """Empty before a contract is known, and again when the machine has failed with it or need not make it."""
    promised_at_s: float | None = None
    incarnation: int = 0
    """The life of the strategist that contracted or ended it; 0 while unknown."""
    number: int = 0
    """The number of that fact in that life."""
    held: int = 0
    """The epoch with which that strategist held the order; 0 for a single strategist."""
    told_at_s: float | None = None
    """When that fact was told (wall clock); None if unknown."""
    made: int = 0
    """Pieces made; never decreases."""
    delivered: int = 0
    """Pieces delivered; never decreases."""
    delivered_at_s: float | None = None
    """The time of the last delivery (wall clock)."""

    @property
    def told(self) -> tuple[int, int, int]:
        """The number of the newest fact about its machine or quantity."""
        return self.held, self.incarnation, self.number

    def has_newer(self, told: tuple[int, int, int], at_s: float | None) -> bool:
        """Whether its newest fact is newer than one with this number, told at this time (wall clock; None if unknown).

        The higher number is newer, whatever clocks say: they are set, and a restarted strategist's may be wrong. But between
        numbers so far apart that no strategist tells both of one goal, a clearly later time decides: a thief of a strategist's
        certificate has told the number of the far future.
        """
        if at_s is not None and self.told_at_s is not None and _are_far_apart(self.told, told):
            if abs(self.told_at_s - at_s) > OVERTAKES_S:
                return self.told_at_s > at_s
        return self.told > told

    @property
    def lost(self) -> bool:
        """Whether its machine has failed with it: another goal replaces the missing pieces."""
        return self.over and self.quantity > 0

    @property
    def over(self) -> bool:
        """Whether its machine has failed with it, or its order was revoked."""
        return self.incarnation > 0 and not self.machine

    def is_known(self, life: int) -> bool:
        """Whether the strategist at work on its order knows it, by its newest life that has accepted the order.

        A life far later than that of the goal is a thief's word, and makes no goal unknown.
        """
        is_far = 0 < self.incarnation < life - FAR_APART[1]
        return self.held > 0 or self.incarnation >= life or is_far


class Progress(msgspec.Struct, frozen=True, gc=False):
    """The progress of an order."""

    status: OrderStatus
    made: tuple[int, ...]
    """Pieces made per item, at most its quantity."""
    delivered: tuple[int, ...]
    delivered_at_s: float | None
    """The time of the last piece's arrival, by facts; None before all have arrived."""


OfGoal = GoalContracted | GoalLost | GoalReduced | GoalWithdrawn | PieceMade | GoodsDelivered
"""Facts about a goal."""


def goal_of(event: Event) -> str | None:
    """The id of the goal of an event, if any."""
    fact = event.fact
    return fact.goal or None if isinstance(fact, OfGoal) else None


def accepted_order(event: Event) -> str | None:
    """The id of the order that an event accepts, if any."""
    return event.fact.order if isinstance(event.fact, OrderAccepted) else None


def life_with(event: Event) -> int:
    """The life that accepted an order without knowing earlier lives' goals; 0 where the order's holder knows all."""
    return 0 if isinstance(event.fact, OrderAccepted) and event.fact.held else event.incarnation


def note(goal: Goal, event: Event, to_wall_s: ToWall) -> None:
    """Update a goal by an event; repeated and late events are harmless."""
    match event.fact:
        case GoalContracted() as fact:
            goal.order_id, goal.product = fact.order, fact.product
            goal.item = None if fact.part_of else fact.item
            if _is_news(goal, event, fact.held, to_wall_s):
                goal.quantity, goal.machine = fact.quantity, fact.machine
                goal.promised_at_s = to_wall_s(fact.finish_s)
        case GoalLost() | GoalWithdrawn() as fact:
            if _is_news(goal, event, fact.held, to_wall_s):
                goal.machine, goal.promised_at_s = "", None
                if isinstance(fact, GoalWithdrawn):
                    goal.quantity = 0  # The missing pieces are not made, unless the order is released again.
            if fact.arrived > 0:
                # The delivery warehouse has counted more than the machine could still report. The time of the last piece is
                # unknown; now is the latest possible.
                goal.delivered = max(goal.delivered, fact.arrived)
                goal.delivered_at_s = max(goal.delivered_at_s or 0.0, to_wall_s(event.at_s))
        case GoalReduced() as fact:
            goal.order_id, goal.item, goal.product = fact.order, fact.item, fact.product
            if _is_news(goal, event, fact.held, to_wall_s):
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


def _is_news(goal: Goal, event: Event, held: int, to_wall_s: ToWall) -> bool:
    """Whether an event is newer than all noted ones of a goal; if so it is noted."""
    told, at_s = (held, event.incarnation, event.number), to_wall_s(event.at_s)
    if told == goal.told or goal.has_newer(told, at_s):
        return False
    goal.held, goal.incarnation, goal.number = told
    goal.told_at_s = at_s
    return True


def _are_far_apart(one: tuple[int, int, int], other: tuple[int, int, int]) -> bool:
    return next((abs(a - b) > far for a, b, far in zip(one, other, FAR_APART, strict=True) if a != b), False)


def merge(goal: Goal, other: Goal) -> None:
    """Update a goal by another record of it, as if all its facts were noted."""
    if other.item is not None:
        goal.order_id, goal.item = other.order_id, other.item
    goal.product = other.product or goal.product
    if other.told != goal.told and not goal.has_newer(other.told, other.told_at_s):
        goal.held, goal.incarnation, goal.number = other.told
        goal.told_at_s = other.told_at_s
        goal.quantity, goal.machine = other.quantity, other.machine
        goal.promised_at_s = other.promised_at_s
    goal.made = max(goal.made, other.made)
    goal.delivered = max(goal.delivered, other.delivered)
    if other.delivered_at_s is not None:
        goal.delivered_at_s = max(goal.delivered_at_s or 0.0, other.delivered_at_s)


def progress(
    quantities: Sequence[int], goals: Iterable[Goal], incarnation: int, arrived: Sequence[int]
) -> Progress:
    """Compute an order's progress.

    Args:
        quantities: pieces ordered, per item.
        goals: all known goals of the order.
        incarnation: the newest life of the strategist that has accepted the order; 0 for none.
        arrived: pieces known to be delivered, per item, if their facts come later.
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
    """An order's new status, from the progress of its goals.

    A cancelled order stays cancelled. A stored one stays stored, unless all of it has arrived: its revocation came
    too late.
    """
    keeps = status is OrderStatus.CANCELLED or (
        status is OrderStatus.STORED and reached is not OrderStatus.DELIVERED
    )
    return status if keeps else reached


def delivered_after(status: OrderStatus, known_s: float | None, reached_s: float | None) -> float | None:
    """The arrival time of an order's last piece, for its new status; None before all have arrived.

    Args:
        status: the order's new status.
        known_s: the stored time: without facts, the time of the strategist's message.
        reached_s: the time by facts, which prevails, however late they come.
    """
    return (reached_s or known_s) if status is OrderStatus.DELIVERED else None
