"""A machine's material flow: its own orders and its goods, besides all other transports to it.

Its transports are those of every place (`dray.protocol.transports.transport_flow`). Its own orders are in `supply`,
its goods in `finished_goods`, loads that others fetch from its buffers in `issuing`. This class joins them; the
machine decides what follows from a change.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import cast

from msgspec.structs import replace

from dray.body import OpenDock, StockChanged, WorkcellState
from dray.memory import DepartureMemory, MachineMemory, Memory, ReservationMemory, visits_of
from dray.messages import THING, Docked, Phase, Transport, TransportAnswered
from dray.messages.keys import Keys
from dray.plant import Plant
from dray.protocol.contract_net.auction_rules import AuctionRules
from dray.protocol.contract_net.changes import ContractChanged, TaskDelivered
from dray.protocol.contract_net.task import OpenTask
from dray.protocol.machine.finished_goods import FinishedGoods
from dray.protocol.machine.production import Goal, GoalBook
from dray.protocol.machine.put_away import PUT_AWAY, PutAway
from dray.protocol.machine.supply import Supply
from dray.protocol.runtime.life import Life
from dray.protocol.runtime.shutdown import GracefulShutdown
from dray.protocol.transports.issuing import Issuing
from dray.protocol.transports.receiving import GateCount
from dray.protocol.transports.reservations import Reservations
from dray.protocol.transports.sourcing import Need
from dray.protocol.transports.transport_flow import TransportFlow


class MaterialFlow(TransportFlow):
    """The material flow of one machine.

    Args:
        machine: its id in the plant.
        plant: its plant.
        keys: the plant's bus keys.
        goals: its goals.
        supply: its buffers and goods.
        rules: time-outs and radius of its auctions.
        shutdown: of the machine: while it drains it sets nothing aside for others.
        tells_node: whether every transport names its node, because others' plant files lack it.

    Attributes:
        task_count: number of its own task names, over all lives.
        goods: its finished goods.
        put_away: parts that no goal here needs.
        cycling: the product of the running cycle; empty for none.
    """

    def __init__(
        self,
        machine: str,
        plant: Plant,
        keys: Keys,
        goals: GoalBook,
        supply: Supply,
        rules: AuctionRules,
        life: Life,
        shutdown: GracefulShutdown,
        *,
        tells_node: bool,
    ) -> None:
        self._goals = goals
        self._supply = supply
        self._node = plant.node_of(machine) if tells_node else ""
        self.task_count, self._mark = 0, life.mark
        super().__init__(machine, plant, keys, supply.materials, supply, rules, life)
        self.goods = FinishedGoods(machine, plant, goals, supply, self.tasks, life)
        self.cycling = ""
        self.put_away = PutAway(machine, plant, life)
        self._book = Reservations({item: plant.materials[item].buffer for item in supply.materials})
        goals.promised = self._book.promised
        self._issuing = Issuing(
            machine,
            self._book,
            life,
            self.door,
            shutdown,
        )
        self.message_handlers |= self._issuing.message_handlers
        self.message_handlers[TransportAnswered] = self.put_away.on_answered
        self.alarms = {**self.alarms, **self._issuing.alarms, PUT_AWAY: self._put_away_again}

    # --- the beginning ---

    def take_count(self, body: WorkcellState) -> None:
        """Take over the body's count."""
        self._supply.take_count(body.stock, body.seq)
        self.take_abilities(body)

    def restore(self, memory: MachineMemory, notes: Memory, now_s: float) -> None:
        """Restore the transports of an earlier life."""
        self.task_count = memory.task_count
        self.put_away.restore(memory.put_away, memory.put_away_count, now_s)
        self.restore_tasks(memory.tasks, notes, now_s)
        visits = visits_of(memory)
        self.visits.restore(visits)
        self.visits.doubts.restore(memory.doubts)
        self.bookings.restore(memory.booked)
        for load in () if self.visits.counts else visits:
            if load.task and load.takes and (load.permitted or load.coordinator):
                fetched = ReservationMemory(
                    *(load.task, load.epoch, load.item, load.quantity, load.coordinator),
                    vehicle=load.vehicle,
                    opened=load.epoch,
                )
                self._book.restore(fetched, (load.vehicle,), now_s)

    def shut_unknown(self, opened: Iterable[str]) -> None:
        """Shut the dock for vehicles of an earlier life that are unknown now."""
        carriers = {task.primary for task in self.tasks}
        self._issuing.shut_unknown(vehicle for vehicle in opened if vehicle not in carriers)

    def follow_unnoted(self, let_in: OpenDock, life: int) -> None:
        """Follow a vehicle that an earlier life, of which no notes are left, has let in to load goods or to bring material.

        Args:
            let_in: what the body remembers.
            life: this life's number, under which the body books the load.
        """
        vehicle, item, quantity = let_in.vehicle, let_in.item, let_in.quantity
        if self._goals.products.is_goods(item):
            taken = DepartureMemory(vehicle, "", life, item, -quantity, permitted=True)
            self.visits.restore((taken,))
        elif item in self._supply.materials:
            self.visits.restore((DepartureMemory(vehicle, item=item, change=quantity, let_in=False),))

    # --- requests and reports of the machine ---

    @property
    def is_held(self) -> bool:
        return super().is_held or self._issuing.is_held

    def announce_needs(self, product: str, now_s: float) -> None:
        """Have needed material brought, and goods fetched."""
        self.called.pursue(now_s)
        for need in list(self.sourcing):
            if not self.called.has(need.task) and not self._supply.needs(need.work.item, product):
                self._drop(need)
        while (order := self._supply.next_order(product, now_s)) is not None:
            work, deadline_s = order
            self.seek(self._next_task(), work, deadline_s, now_s)
        for work, deadline_s in self.goods.shipments(now_s):
            self._announce(self._next_task(), self._docked_here(work), deadline_s, now_s)
        self._put_away(now_s)
        self.called.review(now_s)

    def give_back(self, now_s: float) -> None:
        """Withdraw transports of unneeded material that are not on board, unless they were ordered."""
        for task in unneeded(self.tasks, self._supply):
            if not self.called.has(task.id):
                self.withdraw(task, now_s)

    def note_stock(self, now_s: float) -> None:
        """The stock may have changed: update reservations."""
        self._review_stranded()
        for part in self._goals.products.parts():
            self._book.keep(part, self._plant.machines[self._place].goods_capacity)
        for material in self._supply.materials:
            self._book.keep(material, self._plant.materials[material].buffer)
        self._book.assume(self._to_give)
        self._issuing.settle(now_s)

    def _to_give(self, item: str) -> int:
        """Pieces that others may fetch: spare goods, parts that no goal here takes, and any material."""
        if self._goals.products.is_goods(item):
            return self._goals.spare(item)
        if item in self._plant.parts:
            return self._supply.surplus(item, self.cycling)
        return self._supply.level(item)

    def _put_away_again(self, transport: str, now_s: float) -> None:
        if not self.put_away.ask_again(transport, now_s):
            self._put_away(now_s)

    def _put_away(self, now_s: float) -> None:
        products, making = (
            self._goals.products,
            {goal.work.product for goal in self._goals.at_work() if goal.to_make > 0},
        )
        for part in products.parts():
            if part not in making or self.goods.room < products.container(part)[0]:
                self.put_away.offer(part, self._book.level(part) - self._book.asked(part), now_s)
        for part in self._supply.materials:
            if part in self._plant.parts:
                self.put_away.offer(part, self._book.level(part) - self._book.asked(part), now_s)

    def on_material(self, report: StockChanged, word: DepartureMemory | None, now_s: float) -> None:
        super().on_material(report, word, now_s)
        if report.vehicle and report.change < 0:
            self._issuing.on_taken(report.vehicle, report.item)
        self.note_stock(now_s)

    def on_goods(
        self, report: StockChanged, word: DepartureMemory | None, is_news: bool, now_s: float
    ) -> None:
        """Goods were made, have left, or were found; `word`: the agent's report that the body answers."""
        if report.counted or (word is not None and word.brings):
            self.goods.recount(now_s)
        elif report.vehicle and report.change < 0 and self._book.take(report.vehicle, report.item):
            self._goals.take_spare(report.item, -report.change)
        else:
            self.goods.moved(report, now_s)
        if not is_news:
            self.goods.recount(now_s)

    def on_goal_counted(self, goal: str, now_s: float) -> None:
        """The gate's count of a goal was updated."""
        self._handovers.on_goal_counted(goal, now_s)

    # --- what follows from changes ---

    def _on_contract_changed(self, changed: ContractChanged, now_s: float) -> None:
        super()._on_contract_changed(changed, now_s)
        if changed.task.is_held:
            self._review_stranded()
        self.goods.keep_unwanted()

    def book_delivered(self, delivered: TaskDelivered, now_s: float) -> Goal | None:
        """Book a delivered load. Returns its goal if pieces of it are missing."""
        work, counted = cast(Transport, delivered.task.work), delivered.counted
        goal = self._goals.get(work.goal)
        if goal is not None:
            goal.deliver(delivered.carrier, work.quantity, min(counted, work.quantity))
            return goal if counted < work.quantity else None
        if work.destination == self._place:
            self._supply.settled(work, now_s - delivered.task.opened_s)
        return None

    # --- internals ---

    def _review_stranded(self) -> None:
        """Update each goal's pieces that wait for a person: no other machine makes them meanwhile."""
        waiting = [task for task in self.tasks if task.stranded is not None or task.left]
        works = [cast(Transport, task.work) for task in waiting]
        for goal in self._goals:
            goal.stranded = sum(work.quantity for work in works if work.goal == goal.id)

    def _next_task(self) -> str:
        self.task_count += 1
        return f"{self._place}{self._mark}-{self.task_count}"

    def _on_docked(self, sender: str, message: Docked, now_s: float) -> None:
        if message.station == self._place and message.item and not self.knows(message.task):
            # Another place's transport fetches its load here.
            self._book.assume(self._to_give)
            self._issuing.on_docked(sender, message, now_s)
        else:
            super()._on_docked(sender, message, now_s)

    def _latest_s(self, need: Need, now_s: float) -> float:
        if need.work.item == THING:
            return super()._latest_s(need, now_s)
        return self._supply.latest_s(need.work, need.deadline_s, now_s)

    def _docked_here(self, work: Transport) -> Transport:
        return replace(work, node=self._node) if self._node else work

    def _note_ordered(self, work: Transport) -> None:
        self._supply.ordered(work)

    def _note_settled(self, work: Transport, took_s: float | None) -> None:
        if work.destination == self._place:
            self._supply.settled(work, took_s)

    def _on_restored(self, work: Transport) -> None:
        goal = self._goals.get(work.goal)
        if goal is not None:
            goal.committed += work.quantity
        elif work.destination == self._place:
            self._supply.ordered(work)

    def _on_recovered(self, now_s: float) -> None:
        # Carriers have reported by now what left before this life.
        self.goods.recount(now_s)

    def _on_lacking(self, now_s: float) -> None:
        self.goods.recount(now_s)

    def _counted_of(self, goal: str) -> GateCount | None:
        return self._goals.get(goal)


def unneeded(tasks: Iterable[OpenTask], supply: Supply) -> list[OpenTask]:
    """Transports of material that no goal takes any more, and that are neither on board nor perhaps here, as far as is known."""
    return [
        task
        for task in tasks
        if not task.is_of_goods
        and task.perhaps_down is None
        and task.contract.phase in (None, Phase.APPROACHING)
        and cast(Transport, task.work).item in supply.materials
        and not supply.needs(task.work_item, "")
    ]
