"""A machine's finished goods: its stock, its shipments, and lost pieces.

Every piece exists once. It is ready for its goal, waits for a vehicle, is on board, has arrived, or is spare
because its goal has ended. A piece that is lost on the way is made once more.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import cast

from msgspec.structs import replace

from dray.body import StockChanged
from dray.messages import BufferLevel, Production, Reason, Transport
from dray.plant import Plant
from dray.protocol.contract_net.task import OpenTask
from dray.protocol.machine.production import Goal, GoalBook
from dray.protocol.machine.supply import Supply
from dray.protocol.runtime.life import Change, Life
from dray.protocol.transports.transports import Transports


@dataclass(frozen=True, slots=True)
class GoodsLost(Change):
    """Pieces that waited for a vehicle are gone.

    Attributes:
        goal: their goal; None if it has ended.
    """

    goal: Goal | None


class FinishedGoods:
    """The goods of one machine.

    Args:
        machine: the machine's id.
        plant: lots, and delivery warehouses.
        goals: the machine's goals.
        supply: its stock.
        tasks: the machine's transports.
    """

    def __init__(
        self,
        machine: str,
        plant: Plant,
        goals: GoalBook,
        supply: Supply,
        tasks: Transports,
        life: Life,
    ) -> None:
        self._machine = machine
        self._plant = plant
        self._goals = goals
        self._supply = supply
        self._tasks = tasks
        self._life = life
        self._capacity = plant.machines[machine].goods_capacity
        self._products = goals.products
        self._counted: tuple[dict[str, int] | None, dict[str, int]] = None, {}
        """The stock and the spare pieces from which `_levels` were computed."""
        self._levels: tuple[BufferLevel, ...] = ()
        self._delivery = plant.closest(plant.node_of(machine), plant.delivery_warehouses, 1)[0]

    @property
    def full(self) -> bool:
        """Whether there is no room for another piece."""
        return self.room <= 0

    @property
    def room(self) -> int:
        """Pieces for which there is room."""
        stock = self._supply.stock
        return self._capacity - sum(stock[item] for item in stock if self._products.is_goods(item))

    def has_room_for(self, work: Production) -> bool:
        """Whether there is room for a piece of a goal.

        Parts wait here until they are fetched. So a part leaves room for a container, or an equal share, of every
        other product of this machine. Otherwise a user of parts could lack one product and stop fetching the other.
        """
        if not work.part_of:
            return not self.full
        own = self._products.own
        lack = {
            product: min(self._products.container(product)[0], self._capacity // len(own))
            - self._supply.level(product)
            for product in own
        }
        if lack.pop(work.product, 0) > 0:
            return not self.full
        return self.room > sum(max(0, pieces) for pieces in lack.values())

    def levels(self) -> tuple[BufferLevel, ...]:
        """Stock of every product, for the heartbeat; computed only after a change."""
        stock, spares = self._supply.stock, self._goals.spares
        if stock != self._counted[0] or spares != self._counted[1]:
            self._counted = dict(stock), dict(spares)
            self._levels = tuple(
                BufferLevel(
                    item=product,
                    level=stock.get(product, 0),
                    capacity=self._capacity,
                    spare=spares.get(product, 0),
                )
                for product in self._products
                if product in self._products.own or stock.get(product, 0)
            )
        return self._levels

    def count(self) -> None:
        """At the start, count unclaimed pieces as spare."""
        for product in self._products:
            self._goals.add_spare(product, max(0, self._supply.level(product) - self._claimed(product)))

    def recount(self, now_s: float) -> None:
        """Correct the books by the stock: missing pieces are made anew, surplus pieces are spare.

        A lot that waits for its vehicle is either complete, or has left with another vehicle.
        """
        gone: list[OpenTask] = []
        for product in self._products:
            left = self._supply.level(product)
            for task in self._waiting(product):
                quantity = cast(Transport, task.work).quantity
                if quantity <= left:
                    left -= quantity
                else:
                    gone.append(task)
            for goal in self._goals:
                if goal.work.product == product:
                    goal.made -= max(0, goal.ready - left)
                    left -= goal.ready
            self._goals.set_spare(product, left)
        for task in gone:
            self._tasks.close(task, "withdrawn")
            self._life.note(GoodsLost(self.lost(task)))
            self._life.settle(now_s)

    # --- shipping ---

    def shipments(self, now_s: float) -> Iterator[tuple[Transport, float]]:
        """The transports to announce for ready pieces, each with its deadline (plant clock).

        The pieces of each count as committed from then on.
        """
        for goal in self._goals:
            yield from self._shipments(goal, now_s)
        if self.full:
            yield from self._spare_shipments(now_s)

    def _shipments(self, goal: Goal, now_s: float) -> Iterator[tuple[Transport, float]]:
        lot, ability = goal.work.definition.lot, goal.work.definition.ability
        # Finished goods of interrupted goals must not fill the machine for ever.
        whole = goal.to_make > 0 and goal.given_back_s is None and not self.full
        while goal.ready >= lot or (goal.ready > 0 and not whole):
            quantity = min(goal.ready, lot)
            goal.committed += quantity
            deadline_s = max(goal.deadline_s, now_s + self._supply.patience_s())
            yield self._way_out(goal.work.product, ability, quantity, goal.id), deadline_s

    def _spare_shipments(self, now_s: float) -> Iterator[tuple[Transport, float]]:
        """Transports of spare pieces, which make room in a full machine."""
        parts = self._products.parts()
        for product in self._products:
            if product in parts:
                continue  # A storage keeps them (`put_away`).
            lot, ability = self._products.container(product)
            quantity = min(self._goals.spare(product), lot)
            if quantity:
                self._goals.take_spare(product, quantity)
                deadline_s = now_s + self._supply.patience_s()
                yield self._way_out(product, ability, quantity, ""), deadline_s

    def _way_out(self, product: str, ability: str, quantity: int, goal: str) -> Transport:
        return Transport(
            item=product,
            quantity=quantity,
            sources=(self._machine,),
            destination=self._delivery,
            ability=ability,
            goal=goal,
        )

    # --- progress ---

    def moved(self, report: StockChanged, now_s: float) -> None:
        """Pieces have left the machine, or have come back."""
        if report.change < 0:
            self._left(report, now_s)
        else:
            self._came_back(report, now_s)
            self._life.settle(now_s)

    def lost(self, task: OpenTask) -> Goal | None:
        """A transport has ended without delivery: its pieces are made anew. Returns their goal; None if it has ended."""
        work = cast(Transport, task.work)
        goal = self._goals.get(work.goal)
        if goal is not None:
            goal.lose(work.quantity)
        return goal

    def keep_unwanted(self) -> None:
        """Keep unfetched pieces of ended goals here, as spare."""
        for task in list(self._tasks):
            work = cast(Transport, task.work)
            if work.goal and task.lies_at_source and self._goals.get(work.goal) is None:
                self._tasks.close(task, "withdrawn")
                lie_there = self._supply.level(work.item) - self._claimed(work.item)
                unbooked = max(0, lie_there - self._goals.spare(work.item))
                self._goals.add_spare(work.item, min(work.quantity, unbooked))

    def _left(self, report: StockChanged, now_s: float) -> None:
        for task in self._tasks:
            if report.vehicle and task.primary == report.vehicle and task.work_item == report.item:
                self._tasks.failover.note_loaded(task)
                return
        self.recount(now_s)

    def _came_back(self, report: StockChanged, now_s: float) -> None:
        """A person has brought pieces back from a failed vehicle."""
        for task in list(self._tasks):
            work = cast(Transport, task.work)
            if task.lies_at_source or work.item != report.item or work.quantity != report.change:
                continue
            if not task.primary:
                # The open task names a place where the pieces are no more: they serve their goal from here.
                self._goals.add_spare(report.item, report.change)
                self._tasks.give_up(task, now_s)
                return
            self._tasks.failover.aboard.forget(task)
            task.work = replace(work, sources=(self._machine,), handed_at="")
            self._tasks.reopen(task, Reason.BROUGHT_BACK, now_s)
            return
        self._goals.add_spare(report.item, report.change)

    def _waiting(self, product: str) -> list[OpenTask]:
        """Transports of a product whose load was not fetched yet."""
        return [task for task in self._tasks if task.lies_at_source and task.work_item == product]

    def _claimed(self, product: str) -> int:
        """Pieces among the goods that belong to a goal or wait for a vehicle."""
        ready = sum(goal.ready for goal in self._goals if goal.work.product == product)
        return ready + sum(cast(Transport, task.work).quantity for task in self._waiting(product))
