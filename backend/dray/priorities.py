"""How soon something is wanted: a priority becomes a time, and by such times agents sort and price work.

Nobody passes for ever. What was released after an order's wanted time is wanted later than that, whatever its priority,
since no wanted time lies before its release. So from its wanted time on an order is passed only by what was there before.
"""

from __future__ import annotations

from enum import StrEnum

SHIFT_S = 8 * 3600.0


class Priority(StrEnum):
    """How soon something is wanted."""

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
"""Plant seconds within which a plain transport is wanted where no time is given; of high and urgent ones at the latest. Of what waits
the vehicles take first what was wanted first, and all counts as wanted five minutes after it was given out (`auction_rules.PATIENCE_S`): from then on it is
passed only by what had been called for before."""

ORDER_WITHIN_S = {
    Priority.URGENT: 900.0,
    Priority.HIGH: 2700.0,
    Priority.NORMAL: SHIFT_S,
    Priority.LOW: 2 * SHIFT_S,
}
"""The same for an order, from its release on: the small ones take some 20 minutes in a quiet plant."""

LOW_STANDS_BACK_S = SHIFT_S
"""Plant seconds by which an order of low priority is wanted later than it is due: it lets pass what is due a shift later."""


def order_wanted_s(priority: Priority, released_s: float, due_s: float | None, per_s: float = 1.0) -> float:
    """When an order is wanted: what agents are told as its time.

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
