"""The holder of each order with several strategists: one, and another only with a higher epoch (invariant 26)."""

from __future__ import annotations

from msgspec.structs import replace

from dray.body.gate import EVERY_RELEASE
from dray.memory import GateGoal, GateOrder, Memory
from dray.messages.base import COUNT_MAX
from dray.messages.gate import HELD_TOLD, GoalHeld, HeldOrder, OrderHeld
from dray.protocol.gate.admissions import Admissions
from dray.protocol.runtime.events import Commit

KEPT_ORDERS = 65_536
"""Maximum remembered orders: more than a strategist takes (`order_book.ORDERS_MAX`)."""

EPOCH_MAX = COUNT_MAX // 2
"""Highest believed epoch of an order that the gate has forgotten: later ones still have numbers."""


class OrderHolders:
    """The holders of one gate's orders.

    Args:
        goals: the goals at the gate.
        kept: maximum number of remembered orders; the oldest is forgotten first.
    """

    def __init__(self, goals: Admissions, kept: int = KEPT_ORDERS) -> None:
        self._goals, self._kept = goals, kept
        self._orders: dict[str, GateOrder] = {}
        self._unwritten: dict[str, None] = {}

    def restore(self, memory: Memory) -> None:
        """Restore the notes of earlier lives."""
        for note in memory.values():
            if isinstance(note, GateOrder):
                self._orders[note.order] = note

    def commits(self) -> list[Commit]:
        """The changes since the last call."""
        commits = [Commit(self._orders.get(order), f"{order} held") for order in self._unwritten]
        self._unwritten.clear()
        return commits

    def lost(self) -> tuple[GateOrder, ...]:
        """Orders whose former holder has not heard of the new one yet."""
        return tuple(order for order in self._orders.values() if order.lost_by)

    def loser(self, order: str) -> str:
        """The former holder of an order that has not heard of the new one yet; empty for none."""
        known = self._orders.get(order)
        return "" if known is None else known.lost_by

    def make_again(self, strategist: str, order: str, release: int) -> None:
        """The holder of an order makes a release although it was said to have ended; 0 for none. Others change nothing."""
        known = self._orders.get(order)
        if known is not None and known.holder == strategist and 0 < release <= known.over:
            self._put(replace(known, over=release - 1))

    def claim(self, strategist: str, order: str, epoch: int, over: int = 0) -> OrderHeld:
        """Claim an order for a strategist, unless another one has it with as high an epoch; returns the holder."""
        known = self._orders.get(order)
        if known is None:
            known = GateOrder(order, strategist, min(epoch, EPOCH_MAX))
            self._put(known)
        elif known.holder != strategist and epoch > known.epoch:
            # Whatever it has claimed: its successor needs a higher epoch.
            known = replace(known, holder=strategist, epoch=known.epoch + 1, lost_by=known.holder)
            self._put(known)
        if known.holder == strategist and over > known.over:
            self._put(replace(known, over=over))
        return self.told(order, strategist)

    def refusal(self, strategist: str, order: str, epoch: int) -> OrderHeld | None:
        """The holder of an order if this strategist may not act for it, or used an epoch before its loss; else None.

        An unknown order (lost notes) is held by the first strategist that acts for it.
        """
        known = self._orders.get(order)
        if known is None:
            self._put(GateOrder(order, strategist, min(epoch, EPOCH_MAX)))
            return None
        if known.holder == strategist and epoch >= known.epoch:
            return None
        return self.told(order, strategist)

    def count(self, order: str, item: int, pieces: int) -> None:
        """Count arrived pieces of an item."""
        known = self._orders.get(order)
        if known is not None:
            arrived = [*known.arrived, *([0] * (item + 1 - len(known.arrived)))]
            arrived[item] += pieces
            self._put(replace(known, arrived=tuple(arrived)))

    def heard(self, strategist: str, order: str, epoch: int) -> bool:
        """A strategist has heard of the new holder with this epoch; returns whether repetition can stop."""
        known = self._orders.get(order)
        if known is None or known.lost_by != strategist or epoch < known.epoch:
            return False
        self._put(replace(known, lost_by=""))
        return True

    def held_by(self, strategist: str, after: str) -> tuple[tuple[HeldOrder, ...], bool]:
        """One part by name of a strategist's orders that are open or have a known goal, and whether more follow."""
        known = {goal.of.order for goal in self._goals if goal.of is not None}
        names = sorted(
            order.order
            for order in self._orders.values()
            if order.holder == strategist and (order.over < EVERY_RELEASE or order.order in known)
        )
        left = [name for name in names if name > after]
        part = tuple(HeldOrder(name, self._orders[name].epoch) for name in left[:HELD_TOLD])
        return part, len(left) > HELD_TOLD

    def told(self, order: str, to: str) -> OrderHeld:
        """The holder of an order, for this strategist; with all details if it is the holder."""
        known = self._orders[order]
        if known.holder != to:
            return OrderHeld(order, known.holder, known.epoch, over=known.over)
        goals = [
            (goal, GoalHeld(goal.goal, goal.of, goal.admitted, goal.arrived))
            for goal in self._goals.of_order(order)
            if goal.of is not None
        ]
        return OrderHeld(
            order,
            known.holder,
            known.epoch,
            arrived=known.arrived,
            goals=tuple(held for goal, held in goals if _is_open(goal)),
            over=known.over,
            done=tuple(held for goal, held in goals if goal.arrived and not _is_open(goal)),
        )

    def _put(self, order: GateOrder) -> None:
        self._orders[order.order] = order
        self._unwritten[order.order] = None
        if len(self._orders) > self._kept:
            oldest = next(iter(self._orders))
            del self._orders[oldest]
            self._unwritten[oldest] = None


def _is_open(goal: GateGoal) -> bool:
    return goal.arrived < goal.admitted
