"""Who holds which order, where a plant has several strategists: one of them, and another one only with a higher epoch (invariant 26)."""

from __future__ import annotations

from msgspec.structs import replace

from dray.body.gate import EVERY_RELEASE
from dray.memory import GateGoal, GateOrder, Memory
from dray.messages.gate import HELD_TOLD, GoalHeld, HeldOrder, OrderHeld
from dray.protocol.gate.admissions import Admissions
from dray.protocol.runtime.events import Commit

KEPT_ORDERS = 65_536
"""Orders whose holders and counts it keeps in mind: more than a strategist takes (`order_book.ORDERS_MAX`)."""


class OrderHolders:
    """For one gate.

    Args:
        goals: those at the gate.
        kept: how many orders it keeps in mind; the oldest is forgotten first.
    """

    def __init__(self, goals: Admissions, kept: int = KEPT_ORDERS) -> None:
        self._goals, self._kept = goals, kept
        self._orders: dict[str, GateOrder] = {}
        self._unwritten: dict[str, None] = {}

    def restore(self, memory: Memory) -> None:
        """Take up what earlier lives have noted."""
        for note in memory.values():
            if isinstance(note, GateOrder):
                self._orders[note.order] = note

    def commits(self) -> list[Commit]:
        """What has changed since this was asked for last."""
        commits = [Commit(self._orders.get(order), f"{order} held") for order in self._unwritten]
        self._unwritten.clear()
        return commits

    def lost(self) -> tuple[GateOrder, ...]:
        """Orders of which somebody has not heard yet that another one holds them."""
        return tuple(order for order in self._orders.values() if order.lost_by)

    def loser(self, order: str) -> str:
        """Who has not heard yet that another one holds an order; empty for nobody."""
        known = self._orders.get(order)
        return "" if known is None else known.lost_by

    def claim(self, strategist: str, order: str, epoch: int, over: int = 0) -> OrderHeld:
        """Let a strategist hold an order, unless another one has it with as high an epoch; returns who holds it now."""
        known = self._orders.get(order)
        if known is None:
            known = GateOrder(order, strategist, epoch)
            self._put(known)
        elif known.holder != strategist and epoch > known.epoch:
            known = replace(known, holder=strategist, epoch=epoch, lost_by=known.holder)
            self._put(known)
        if known.holder == strategist and over > known.over:
            self._put(replace(known, over=over))
        return self.told(order, strategist)

    def refusal(self, strategist: str, order: str, epoch: int) -> OrderHeld | None:
        """Who holds an order, where this strategist may not speak for it, or has said so before it lost it and got it again; else None.

        An order of which nothing is known (the notes were lost) is held by whoever speaks for it first.
        """
        known = self._orders.get(order)
        if known is None:
            self._put(GateOrder(order, strategist, epoch))
            return None
        if known.holder == strategist and epoch >= known.epoch:
            return None
        return self.told(order, strategist)

    def count(self, order: str, item: int, pieces: int) -> None:
        """Pieces of an item have arrived."""
        known = self._orders.get(order)
        if known is not None:
            arrived = [*known.arrived, *([0] * (item + 1 - len(known.arrived)))]
            arrived[item] += pieces
            self._put(replace(known, arrived=tuple(arrived)))

    def heard(self, strategist: str, order: str, epoch: int) -> bool:
        """A strategist has heard that another one holds an order with this epoch; returns whether there is no need to say it again."""
        known = self._orders.get(order)
        if known is None or known.lost_by != strategist or epoch < known.epoch:
            return False
        self._put(replace(known, lost_by=""))
        return True

    def held_by(self, strategist: str, after: str) -> tuple[tuple[HeldOrder, ...], bool]:
        """What a strategist holds that has not ended, or has a goal that is known, in parts by name: one part, and whether more follows."""
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
        """Who holds an order, for this strategist: with all that is known of it when that one does."""
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
