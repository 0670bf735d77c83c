"""When machines promise to have made the items of an order. Pure."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import msgspec

from dray.store.orders.milestones import MovedPromise
from dray.store.orders.progress import Goal


class ItemPromise(msgspec.Struct, frozen=True):
    """The promises of all goals that make an item. Times are wall clock seconds."""

    at_s: float | None = None
    """The latest promise that holds now; None if nothing of the item is being made."""
    first_at_s: float | None = None
    """The latest of the first promises, if one was moved since."""
    came_before: int = 0
    """Most more urgent goals that have come before one of its goals since that was taken."""


NO_PROMISE = ItemPromise()


def promises_of(
    goals: Iterable[Goal], moved: Mapping[str, MovedPromise], speed: float
) -> dict[int, ItemPromise]:
    """The promises of an order, by item.

    Args:
        goals: all goals of the order.
        moved: by goal: the promise that holds now, if it was moved.
        speed: plant seconds per wall second.
    """
    found: dict[int, ItemPromise] = {}
    for goal in goals:
        if goal.item is None or not goal.machine or goal.promised_at_s is None or goal.made >= goal.quantity:
            continue
        now = moved.get(goal.id)
        if now is None or now.machine != goal.machine:
            told = ItemPromise(goal.promised_at_s)
        else:
            told = ItemPromise(now.promised_at_s(speed), goal.promised_at_s, now.came_before)
        found[goal.item] = _later(found.get(goal.item, NO_PROMISE), told)
    return found


def _later(one: ItemPromise, other: ItemPromise) -> ItemPromise:
    if one.at_s is None or other.at_s is None:
        return other if one.at_s is None else one
    firsts = (one.first_at_s or one.at_s, other.first_at_s or other.at_s)
    is_moved = one.first_at_s is not None or other.first_at_s is not None
    return ItemPromise(
        max(one.at_s, other.at_s),
        max(firsts) if is_moved else None,
        max(one.came_before, other.came_before),
    )
