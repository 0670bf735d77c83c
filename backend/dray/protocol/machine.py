"""A production machine: makes goals, orders its own material, has its products carried away (paper, 3.2).

It is a contractor towards the strategist, whose goals it bids for (`goal_bidding`), and the coordinator
of all its transports (`coordinator`, `docking`). It watches its buffers (`supply`); everything else
follows from `_pursue`, which is asked after every change: start the next cycle, order what runs low,
have finished goods fetched, say so.
"""

from __future__ import annotations

from typing import cast

from dray.body import (
    BodyState,
    Broken,
    CycleDone,
    CycleFailed,
    Repaired,
    StartCycle,
    StockChanged,
    WorkcellState,
)
from dray.errors import ProtocolViolation
from dray.memory import MachineMemory, Memory
from dray.messages import (
    Accepted,
    AtvHeartbeat,
    Award,
    Bid,
    Brief,
    BufferLevel,
    Confirmed,
    Declined,
    Docked,
    GoalClosed,
    Handover,
    MachineHeartbeat,
    MachineStatus,
    Phase,
    Release,
    Resigned,
    TakenOver,
    TaskAnnounced,
    TaskBrief,
    Transport,
    Withdrawn,
    Work,
)
from dray.messages.fact import MachineStatusChanged, PieceMade
from dray.messages.keys import Keys
from dray.plant import Plant
from dray.protocol.auction import AuctionRules, Place
from dray.protocol.coordinator import ADOPT_S, Coordinator
from dray.protocol.core import Core
from dray.protocol.docking import Dock
from dray.protocol.events import (
    Ignore,
    Instruct,
    Publish,
    Record,
    Subscribe,
    Unsubscribe,
)
from dray.protocol.goal_bidding import CONFIRM, GoalBidder
from dray.protocol.production import Goal, GoalBook
from dray.protocol.supervision import Following
from dray.protocol.supply import Supply
from dray.protocol.suspicion import IDLE_INTERVAL_S, WORKING_INTERVAL_S
from dray.protocol.tasks import OpenTask

BEAT = "beat"
ADOPT = "adopt"

ON_THE_WAY = frozenset({Phase.APPROACHING, Phase.LOADING, Phase.CARRYING, Phase.UNLOADING})
"""Phases of a transport that has not been handed over: only such a one is news to a machine that forgot all."""


class Machine(Core):
    """One production machine.

    Args:
        machine: its id in the plant.
        plant: the plant it stands in.
        incarnation: how often it has been started.
        software: the version it runs, for its heartbeat.
        rules: patience and reach of its auctions.
    """

    def __init__(
        self,
        machine: str,
        plant: Plant,
        *,
        incarnation: int = 1,
        software: str = "",
        rules: AuctionRules | None = None,
    ) -> None:
        super().__init__(machine, incarnation)
        self._plant = plant
        self._spec = plant.machines[machine]
        self._software = software
        self._keys = Keys(plant.id)
        self._beat_key = self._keys.machine_heartbeat(machine)
        self._products = tuple(making.product for making in self._spec.makes)
        node = plant.node_of(machine)
        self._delivery = plant.closest(node, plant.delivery_warehouses, 1)[0]
        self._goals = GoalBook(machine, plant)
        self._supply = Supply(machine, plant, self._goals)
        self._bidder = GoalBidder(
            self._products, self._goals, self._supply, self._timers, self._out, self._commit
        )
        x_m, y_m = plant.position_of(machine)
        self._tasks = Coordinator(
            machine,
            Place(x_m=x_m, y_m=y_m, reach_m=plant.diameter_m),
            self._audience,
            rules or AuctionRules(),
            self._timers,
            Following(self._keys.atv_heartbeat, self._out),
            self._out,
            self._on_carrier_changed,
            lost=self._on_lost,
            left=self._on_left,
            unloaded=self._settle,
        )
        self._dock = Dock(machine, self._tasks, self._supply, self._out)
        self._cycling = ""
        """The product of the running cycle; empty for none."""
        self._running: Goal | None = None
        """Its goal; None for a cycle that an earlier life of this machine has begun."""
        self._problem = ""
        self._status = MachineStatus.IDLE
        self._seq = 0
        self._task_count = 0
        self._forgetful = False
        """It was started again, and has no memory of the life before."""
        self._on_message = {
            AtvHeartbeat: self._hear_vehicle,
            Bid: self._tasks.hear_bid,
            Accepted: self._tasks.hear_accepted,
            Declined: self._tasks.hear_declined,
            Resigned: self._tasks.hear_resigned,
            TakenOver: self._tasks.hear_taken_over,
            Docked: self._dock.hear_docked,
            Handover: self._hear_handover,
            TaskAnnounced: lambda _sender, message, now_s: self._bidder.hear(message, self._problem, now_s),
            Award: self._hear_award,
            Confirmed: self._hear_confirmed,
            Release: self._hear_goal_over,
            Withdrawn: self._hear_goal_over,
            GoalClosed: self._hear_goal_closed,
        }
        self._on_report = {
            CycleDone: self._cycle_done,
            CycleFailed: self._cycle_failed,
            StockChanged: self._stock_changed,
            Broken: self._broken,
            Repaired: self._repaired,
        }
        self._on_alarm = {
            BEAT: self._beat,
            CONFIRM: self._bidder.wake,
            ADOPT: self._end_adoption,
            **self._tasks.alarms,
        }

    # --- the beginning, and time passing ---

    def _start(self, body: BodyState | None, memory: Memory | None, now_s: float) -> None:
        if not isinstance(body, WorkcellState):
            raise ProtocolViolation(f"{self.id}: a machine needs a workcell, not {body!r}")
        self._supply.sense(body.stock)
        self._problem = body.broken
        self._cycling = body.cycling
        if isinstance(memory, MachineMemory):
            self._recall(memory, now_s)
        for product in self._products:
            self._goals.add_spare(product, max(0, self._supply.level(product) - self._claimed(product)))
        self._out.extend(Subscribe(self._keys.goals(product)) for product in self._products)
        if self.incarnation > 1:
            self._begin_adoption(memory is None, now_s)
        self._timers.set(BEAT, now_s)
        self._pursue(now_s)

    def _begin_adoption(self, forgetful: bool, now_s: float) -> None:
        """Listen for a while to all vehicles: some may work for this machine, and it does not know."""
        self._forgetful = forgetful
        self._out.append(Subscribe(self._keys.all_atv_heartbeats))
        self._timers.set(ADOPT, now_s + ADOPT_S)

    def _end_adoption(self, _about: None, now_s: float) -> None:
        self._out.append(Unsubscribe(self._keys.all_atv_heartbeats))
        for product in self._products:
            # What had left before this life began, its carrier has told by now.
            self._miss_goods(product, self._claimed(product) - self._supply.level(product), now_s)
        self._pursue(now_s)

    def _recall(self, memory: MachineMemory, now_s: float) -> None:
        """Go on with what an earlier life was bound by."""
        self._task_count = memory.task_count
        for booked in memory.goals:
            # It goes on with them: the strategist may be away, and the gate knows what may still get in.
            self._bidder.ask(self._goals.restore(booked), now_s)
        for kept in memory.tasks:
            work, goal = kept.work, self._goals.get(kept.work.goal)
            self._tasks.restore(kept, now_s)
            if goal is not None:
                goal.committed += work.quantity
            elif work.destination == self.id:
                self._supply.ordered(work)
        # Tasks without a carrier have a higher epoch now: no life may use one that an earlier one has used.
        self._commit()

    def _claimed(self, product: str) -> int:
        """Pieces in the goods that belong to a goal or wait for a vehicle."""
        ready = sum(goal.ready for goal in self._goals if goal.work.product == product)
        works = (cast(Transport, task.work) for task in self._tasks if not task.loaded)
        return ready + sum(work.quantity for work in works if work.item == product)

    def _memory(self) -> Memory:
        return MachineMemory(
            goals=self._goals.memories(),
            tasks=tuple(task.memory() for task in self._tasks),
            task_count=self._task_count,
        )

    def _sense(self, body: BodyState | None, now_s: float) -> None:
        if isinstance(body, WorkcellState) and self._supply.sense(body.stock):
            self._pursue(now_s)

    def _beat(self, _about: None, now_s: float) -> None:
        self._seq += 1
        heartbeat = MachineHeartbeat(
            machine=self.id,
            incarnation=self.incarnation,
            seq=self._seq,
            at_s=now_s,
            status=self._status,
            product=self._cycling,
            goals=self._goals.briefs(),
            tasks=tuple(_brief(task) for task in self._tasks),
            buffers=self._supply.levels(),
            goods=tuple(
                BufferLevel(
                    item=product,
                    level=self._supply.level(product),
                    capacity=self._spec.goods_capacity,
                )
                for product in self._products
            ),
            problem=self._problem,
            software=self._software,
        )
        self._out.append(Publish(self._beat_key, heartbeat))
        # Whoever holds goals is relied on, also while all that is left of them is on the way.
        interval_s = WORKING_INTERVAL_S if len(self._goals) else IDLE_INTERVAL_S
        self._timers.set(BEAT, now_s + (self._spread(interval_s) if self._seq == 1 else interval_s))

    # --- the workcell reports ---

    def _cycle_done(self, report: CycleDone, now_s: float) -> None:
        goal, self._running, self._cycling = self._running, None, ""
        self._supply.change(report.product, 1)
        if goal is None or self._goals.get(goal.id) is not goal:
            self._goals.add_spare(report.product, 1)
        else:
            goal.made += 1
            self._note_made(goal)
        self._pursue(now_s)

    def _note_made(self, goal: Goal) -> None:
        self._commit()
        made = goal.brief().made
        self._out.append(Record(PieceMade(goal=goal.id, product=goal.work.product, made=made)))

    def _cycle_failed(self, _report: CycleFailed, now_s: float) -> None:
        # The senses put the stock right at the next beat; then it is tried again.
        self._running, self._cycling = None, ""
        self._timers.set(BEAT, now_s)

    def _stock_changed(self, report: StockChanged, now_s: float) -> None:
        self._supply.change(report.item, report.change)
        if report.item not in self._products:
            self._material_came(report)
        elif report.change < 0:
            self._goods_left(report, now_s)
        else:
            self._goods_came_back(report, now_s)
        self._pursue(now_s)

    def _material_came(self, report: StockChanged) -> None:
        for task in self._tasks:
            if task.primary == report.vehicle and task.work_item == report.item:
                task.unloaded = True

    def _goods_left(self, report: StockChanged, now_s: float) -> None:
        for task in self._tasks:
            if task.primary == report.vehicle and task.work_item == report.item:
                self._tasks.note_loaded(task)
                self._commit()
                return
        self._miss_goods(report.item, -report.change, now_s)

    def _goods_came_back(self, report: StockChanged, now_s: float) -> None:
        """A person has brought them, from a vehicle that has failed."""
        for task in list(self._tasks):
            work = cast(Transport, task.work)
            if task.loaded and work.item == report.item and work.quantity == report.change:
                self._tasks.reopen(task, "its load was brought back", now_s)
                return
        self._goals.add_spare(report.item, report.change)
        self._goals_changed(now_s)

    def _miss_goods(self, product: str, pieces: int, now_s: float) -> None:
        """Goods are gone, and no carrier of ours has them: they are made anew."""
        if pieces <= 0:
            return
        for task in list(self._tasks):
            work = cast(Transport, task.work)
            if work.item == product and not task.loaded and work.quantity <= pieces:
                pieces -= work.quantity
                self._tasks.close(task, "withdrawn")
                self._on_lost(task, now_s)
        spare = min(pieces, self._goals.spare(product))
        self._goals.take_spare(product, spare)
        pieces -= spare
        for goal in self._goals:
            if goal.work.product == product and pieces > 0:
                gone = min(pieces, goal.ready)
                goal.made -= gone
                pieces -= gone
        self._commit()

    def _broken(self, report: Broken, now_s: float) -> None:
        self._problem = report.reason
        self._update_status(now_s)

    def _repaired(self, _report: Repaired, now_s: float) -> None:
        self._problem = ""
        self._pursue(now_s)

    # --- deciding ---

    def _pursue(self, now_s: float) -> None:
        """Do whatever the present state asks for."""
        self._share_spare()
        self._start_cycle()
        while (order := self._supply.next_order(self._cycling, now_s)) is not None:
            work, deadline_s = order
            self._supply.ordered(work)
            self._open(work, deadline_s, now_s)
        for goal in self._goals:
            self._send_goods(goal, now_s)
        if self._goods_full():
            self._clear_spare(now_s)
        self._update_status(now_s)

    def _share_spare(self) -> None:
        """Finished pieces of goals that ended early serve the next ones."""
        for goal in self._goals.confirmed():
            if self._goals.use_spare(goal, self._running):
                self._note_made(goal)

    def _start_cycle(self) -> None:
        if self._cycling or self._problem or self._goods_full():
            return
        goal = self._goals.next_to_make(self._supply.stock)
        if goal is None:
            return
        self._running, self._cycling = goal, goal.work.product
        for line in self._plant.products[goal.work.product].bill:
            self._supply.change(line.material, -line.quantity)
        self._out.append(Instruct(StartCycle(product=goal.work.product)))

    def _goods_full(self) -> bool:
        goods = sum(self._supply.level(product) for product in self._products)
        return goods >= self._spec.goods_capacity

    def _send_goods(self, goal: Goal, now_s: float) -> None:
        product = self._plant.products[goal.work.product]
        # Goods of goals that more urgent ones have interrupted must not fill the machine for ever.
        whole = goal.to_make > 0 and not self._goods_full()
        while goal.ready >= product.lot or (goal.ready > 0 and not whole):
            quantity = min(goal.ready, product.lot)
            goal.committed += quantity
            deadline_s = max(goal.deadline_s, now_s + self._supply.patience_s())
            self._open(self._way_out(product.id, quantity, goal.id), deadline_s, now_s)

    def _clear_spare(self, now_s: float) -> None:
        """Pieces that no goal wants must not fill the machine for ever: they are set aside."""
        for product in self._products:
            quantity = min(self._goals.spare(product), self._plant.products[product].lot)
            if quantity:
                self._goals.take_spare(product, quantity)
                self._open(self._way_out(product, quantity, ""), now_s + self._supply.patience_s(), now_s)

    def _way_out(self, product: str, quantity: int, goal: str) -> Transport:
        return Transport(
            item=product,
            quantity=quantity,
            sources=(self.id,),
            destination=self._delivery,
            ability=self._plant.products[product].ability,
            goal=goal,
        )

    def _open(self, work: Transport, deadline_s: float, now_s: float) -> None:
        self._task_count += 1
        life = "" if self.incarnation == 1 else f".{self.incarnation}"
        self._tasks.open(f"{self.id}{life}-{self._task_count}", work, deadline_s, now_s)
        self._commit()
        self._timers.set(BEAT, now_s)

    def _update_status(self, now_s: float) -> None:
        status, reason = self._present_status()
        if status is self._status:
            return
        self._status = status
        fact = MachineStatusChanged(status=status, product=self._cycling, reason=reason)
        self._out.append(Record(fact))
        self._timers.set(BEAT, now_s)

    def _present_status(self) -> tuple[MachineStatus, str]:
        if self._problem:
            return MachineStatus.ERROR, self._problem
        if self._cycling:
            return MachineStatus.PRODUCING, ""
        if not self._goals.unfinished:
            return MachineStatus.IDLE, ""
        if self._goods_full():
            return MachineStatus.BLOCKED, "the goods are not fetched"
        return MachineStatus.STARVED, "material is missing"

    # --- transports ---

    def _hear_vehicle(self, _sender: str, heartbeat: AtvHeartbeat, now_s: float) -> None:
        self._tasks.hear_heartbeat(heartbeat, now_s)
        brief = heartbeat.task
        if brief is not None and brief.coordinator == self.id and self._timers.is_set(ADOPT):
            self._adopt(heartbeat.atv, brief, now_s)

    def _adopt(self, atv: str, brief: Brief, now_s: float) -> None:
        """A vehicle names this machine as the one that it carries for."""
        known = self._tasks.get(brief.task)
        if known is not None:
            self._tasks.adopt(atv, brief, known.work, now_s)
        elif (
            self._forgetful and brief.item in self._plant.materials_of(self.id) and brief.phase in ON_THE_WAY
        ):
            work = Transport(
                item=brief.item,
                quantity=brief.quantity,
                sources=self._plant.storages_of(brief.item),
                destination=self.id,
                ability=self._plant.materials[brief.item].ability,
            )
            self._tasks.adopt(atv, brief, work, now_s)
            self._supply.ordered(work)

    def _audience(self, _work: Work, radius_m: float) -> tuple[str, ...]:
        x_m, y_m = self._plant.position_of(self.id)
        return tuple(self._keys.transports(cell) for cell in self._plant.cells_within(x_m, y_m, radius_m))

    def _on_carrier_changed(self, task: OpenTask, now_s: float) -> None:
        self._commit()
        self._timers.set(BEAT, now_s)
        self._withdraw_if_idle(task)

    def _withdraw_if_idle(self, task: OpenTask) -> None:
        """Goods that nobody wants any more and nobody has come for yet stay here, as spare."""
        work = cast(Transport, task.work)
        if work.goal and not task.primary and self._goals.get(work.goal) is None:
            self._tasks.close(task, "withdrawn")
            self._goals.add_spare(work.item, work.quantity)

    def _on_left(self, atv: str) -> None:
        self._dock.shut(atv)

    def _on_lost(self, task: OpenTask, now_s: float) -> None:
        """A vehicle has vanished with goods: they are made anew."""
        work = cast(Transport, task.work)
        goal = self._goals.get(work.goal)
        if goal is not None:
            goal.lose(work.quantity)
            # It may have arrived all the same: the gate has the last word.
            self._bidder.ask(goal, now_s)
        self._goals_changed(now_s)
        self._commit()

    def _hear_handover(self, sender: str, message: Handover, now_s: float) -> None:
        task = self._dock.hear_handover(sender, message)
        if task is not None:
            self._settle(task, now_s)

    def _settle(self, task: OpenTask, now_s: float) -> None:
        """A transport was delivered."""
        self._commit()
        work = cast(Transport, task.work)
        goal = self._goals.get(work.goal)
        if goal is not None:
            goal.delivered += work.quantity
        elif work.destination == self.id:
            self._supply.settled(work, now_s - task.opened_s)
        self._timers.set(BEAT, now_s)
        self._pursue(now_s)

    # --- goals ---

    def _hear_award(self, sender: str, message: Award, now_s: float) -> None:
        if self._bidder.hear_award(sender, message, self._problem, now_s):
            self._goals_changed(now_s)

    def _hear_confirmed(self, _sender: str, message: Confirmed, now_s: float) -> None:
        if self._bidder.hear_confirmed(message):
            self._goals_changed(now_s)
        else:
            self._out.append(Ignore("confirmed twice"))

    def _hear_goal_over(self, _sender: str, message: Release | Withdrawn, now_s: float) -> None:
        self._end_goal(self._bidder.hear_over(message), now_s)

    def _hear_goal_closed(self, _sender: str, message: GoalClosed, now_s: float) -> None:
        self._end_goal(self._bidder.hear_closed(message), now_s)

    def _end_goal(self, goal: Goal | None, now_s: float) -> None:
        if goal is None:
            self._out.append(Ignore("the end of a goal that has ended"))
            return
        for task in list(self._tasks):
            self._withdraw_if_idle(task)
        self._goals_changed(now_s)

    def _goals_changed(self, now_s: float) -> None:
        self._supply.goals_changed()
        self._pursue(now_s)
        self._timers.set(BEAT, now_s)


def _brief(task: OpenTask) -> TaskBrief:
    work = cast(Transport, task.work)
    return TaskBrief(
        task=task.id,
        epoch=task.epoch,
        item=work.item,
        quantity=work.quantity,
        source=task.source,
        destination=work.destination,
        deadline_s=task.deadline_s,
        primary=task.primary,
        secondary=task.secondary,
        round=task.round,
        trouble=task.trouble,
    )
