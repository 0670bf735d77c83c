"""Priorities: each becomes a wanted time, and agents sort and price work by it.

Nothing is overtaken for ever. Work released after an order's wanted time is wanted later than that, in any priority: no
wanted time lies before the release. From its wanted time on, only earlier released work overtakes an order.
"""

from __future__ import annotations

from enum import StrEnum

SHIFT_S = 8 * 3600.0


class Priority(StrEnum):
    """The urgency of an order or transport."""

    LOW = "low"
    NORMAL = "normal"
    HIGH = "high"
    URGENT = "urgent"


TRANSPORT_WITHIN_S = {
    Priority.URGENT: 60.0,
    Priority.HIGH: 180.0,
    Priority.NORMAL: 900.0,
    Priority.LOW: 3600.0,
}
"""Plant seconds within which a plain transport without a given time is wanted; for high and urgent ones the upper bound. Vehicles take
waiting work by wanted time. Five minutes after its announcement (`auction_rules.PATIENCE_S`) a transport counts as wanted; after that
only earlier calls overtake it."""

ORDER_WITHIN_S = {
    Priority.URGENT: 900.0,
    Priority.HIGH: 2700.0,
    Priority.NORMAL: SHIFT_S,
    Priority.LOW: 2 * SHIFT_S,
}
"""The same for an order, from its release on: small ones take some 20 minutes in a quiet plant."""

LOW_STANDS_BACK_S = SHIFT_S
"""Plant seconds between the due time and the wanted time of an order of low priority: it lets pass work due within a shift."""


def order_wanted_s(priority: Priority, released_s: float, due_s: float | None, per_s: float = 1.0) -> float:
    """The wanted time of an order, as agents are told it.

    Args:
        priority: of the order.
        released_s: when it was released.
        due_s: when it is due; None where no time was given.
        per_s: plant seconds in a second of these times.
    """
    within_s = released_s + ORDER_WITHIN_S[priority] / per_s
    if due_s is None:
        return within_s
    if priority is Priority.NORMAL:
        return due_s
    if priority is Priority.LOW:
        return due_s + LOW_STANDS_BACK_S / per_s
    return min(due_s, within_s)
