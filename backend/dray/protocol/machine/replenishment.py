"""When, and how early, a machine orders material: pure arithmetic.

    reorder point = use per second * lead time * SAFETY + one cycle

so that a machine at full speed gets the next load before it runs out (paper, 4.1 and case 3: the bidding time is
part of the lead time, and is ordered ahead).
"""

from __future__ import annotations

import math

from dray.plant.working_time import WorkingTime

SAFETY = 1.5
"""Lead times vary by about a third around their mean; half as much again covers 9 of 10."""

LEAD_TIME_WEIGHT = 0.2
"""Weight of the newest lead time in the running mean: about the last ten count."""


def reorder_point(use_per_s: float, lead_time_s: float, per_cycle: int, ceiling: int) -> int:
    """The level at which to order more.

    Args:
        use_per_s: pieces used per second at full speed.
        lead_time_s: from the announcement to the material in the buffer.
        per_cycle: pieces that one cycle takes.
        ceiling: maximum level: above it a whole lot would find no room.
    """
    wanted = math.ceil(use_per_s * lead_time_s * SAFETY) + per_cycle
    return max(per_cycle, min(wanted, ceiling))


def order_quantity(*, level: int, on_order: int, need: int, point: int, lot: int, capacity: int) -> int:
    """Pieces to order now; 0 for none.

    Args:
        level: pieces in the buffer.
        on_order: pieces announced and not yet there.
        need: pieces that all goals still take.
        point: the reorder point.
        lot: pieces in one container.
        capacity: pieces the buffer holds.
    """
    expected = level + on_order
    if need <= expected or expected > point:
        return 0
    return max(0, min(lot, capacity - expected))


def runs_out_at_s(now_s: float, expected: int, use_per_s: float, working_time: WorkingTime) -> float:
    """When `expected` pieces are used up at full speed, in working time."""
    return working_time.after_s(working_time.next_on_s(now_s), expected / use_per_s)


class LeadTime:
    """A running mean of the lead time of replenishments.

    Args:
        first_guess_s: an estimate from the plant's ways, before any delivery.
    """

    __slots__ = ("mean_s",)

    def __init__(self, first_guess_s: float) -> None:
        self.mean_s = first_guess_s

    def note(self, took_s: float) -> None:
        """Note a replenishment's lead time."""
        self.mean_s += LEAD_TIME_WEIGHT * (took_s - self.mean_s)
