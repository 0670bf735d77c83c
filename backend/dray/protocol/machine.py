"""A production machine: makes goals, orders its own material, has its products carried away (paper, 3.2).

It is a contractor towards the strategist, whose goals it bids for, and the coordinator of all its
transports. It watches its buffers; everything else follows from `_pursue`, which is asked after
every change: start the next cycle, order what runs low, have finished goods fetched, say so.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast
from zlib import crc32

from dray.body import (
    BodyState,
    Broken,
    CycleDone,
    CycleFailed,
    OpenDock,
    Repaired,
    StartCycle,
    StockChanged,
    WorkcellState,
)
from dray.errors import ProtocolViolation
from dray.messages import (
    Accepted,
    AtvHeartbeat,
    Award,
    Bid,
    BufferLevel,
    Declined,
    Docked,
    DockHeld,
    DockOpened,
    GoalClosed,
    Handover,
    HandoverAccepted,
    MachineHeartbeat,
    MachineStatus,
    Message,
    Production,
    Refusal,
    Release,
    Resigned,
    Role,
    Superseded,
    TaskAnnounced,
    TaskBrief,
    Transport,
    Withdrawn,
    Work,
)
from dray.messages.fact import (
    BidRefused,
    BidSent,
    ContractEnded,
    ContractTaken,
    GoodsDelivered,
    MachineStatusChanged,
    PieceMade,
)
from dray.messages.keys import Keys
from dray.plant import Plant
from dray.protocol.auction import AuctionRules, Place
from dray.protocol.coordinator import TIMER_KINDS, Coordinator, OpenTask
from dray.protocol.events import (
    Effect,
    Event,
    Heard,
    Instruct,
    Publish,
    Record,
    Reported,
    Send,
    Started,
    Subscribe,
    Woke,
)
from dray.protocol.production import Goal, GoalBook
from dray.protocol.replenishment import LeadTime, order_quantity, reorder_point, runs_out_at_s
from dray.protocol.supervision import Following
from dray.protocol.suspicion import IDLE_INTERVAL_S, WORKING_INTERVAL_S
from dray.protocol.timers import Timers

BEAT = "beat"

QUOTES_KEPT = 64
"""Bids for goals whose award may still come: more than a strategist has open at a time."""

QUOTE_TOLERANCE_S = 60.0
"""How much later than it bid a machine may end and still take an award."""

TYPICAL_APPROACH_S = 45.0
"""A first guess of how long a vehicle needs to reach a storage, until lead times are measured."""


class Machine:
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
        self.id = machine
        self.incarnation = incarnation
        self._plant = plant
        self._spec = plant.machines[machine]
        self._software = software
        self._keys = Keys(plant.id)
        self._beat_key = self._keys.machine_heartbeat(machine)
        self._out: list[Effect] = []
        self._timers = Timers()
        self._goals = GoalBook(machine, plant)
        self._stock: dict[str, int] = {}
        self._cycling: Goal | None = None
        self._problem = ""
        self._status = MachineStatus.IDLE
        self._seq = 0
        self._task_count = 0
        self._quoted_s: dict[str, float] = {}
        self._materials = plant.materials_of(machine)
        self._products = tuple(making.product for making in self._spec.makes)
        self._lead = {material: LeadTime(self._first_lead_time_s(material)) for material in self._materials}
        x_m, y_m = plant.position_of(machine)
        self._tasks = Coordinator(
            machine,
            Place(x_m=x_m, y_m=y_m, reach_m=plant.diameter_m),
            self._audience,
            rules or AuctionRules(),
            self._timers,
            Following(self._keys.atv_heartbeat, self._out),
            self._out,
            self._on_contracted,
        )
        self._on_message: dict[type[Message], Callable[[str, Any, float], None]] = {
            AtvHeartbeat: lambda _sender, message, now_s: self._tasks.hear_heartbeat(message, now_s),
            Bid: self._tasks.hear_bid,
            Accepted: self._tasks.hear_accepted,
            Declined: self._tasks.hear_declined,
            Resigned: self._tasks.hear_resigned,
            Docked: self._hear_docked,
            Handover: self._hear_handover,
            TaskAnnounced: self._hear_announced,
            Award: self._hear_award,
            Release: self._hear_goal_over,
            Withdrawn: self._hear_goal_over,
            GoalClosed: self._hear_goal_closed,
        }
        self._on_report: dict[type, Callable[[Any, float], None]] = {
            CycleDone: self._cycle_done,
            CycleFailed: self._cycle_failed,
            StockChanged: self._stock_changed,
            Broken: self._broken,
            Repaired: self._repaired,
        }

    @property
    def wake_at_s(self) -> float:
        return self._timers.next_s

    def handle(self, event: Event, now_s: float) -> list[Effect]:
        """Take one step; see `dray.protocol.events.Agent`."""
        kind = type(event)
        if kind is Heard:
            heard = cast(Heard, event)
            hear = self._on_message.get(type(heard.message))
            if hear is not None:
                hear(heard.sender, heard.message, now_s)
        elif kind is Woke:
            self._wake(cast(Woke, event).body, now_s)
        elif kind is Reported:
            report = cast(Reported, event).report
            self._on_report[type(report)](report, now_s)
        else:
            self._start(cast(Started, event).body, now_s)
        effects = self._out[:]
        self._out.clear()
        return effects

    # --- the beginning, and time passing ---

    def _start(self, body: BodyState | None, now_s: float) -> None:
        if not isinstance(body, WorkcellState):
            raise ProtocolViolation(f"{self.id}: a machine needs a workcell, not {body!r}")
        self._stock = dict(body.stock)
        self._problem = body.broken
        self._out.extend(Subscribe(self._keys.goals(product)) for product in self._products)
        self._timers.set(BEAT, now_s)
        self._pursue(now_s)

    def _wake(self, body: BodyState | None, now_s: float) -> None:
        if isinstance(body, WorkcellState):
            self._stock = body.stock
        for name in self._timers.due(now_s):
            if name == BEAT:
                self._beat(now_s)
            else:
                kind, task = cast(tuple[str, str], name)
                if kind not in TIMER_KINDS:
                    raise ProtocolViolation(f"{self.id}: no such alarm: {name}")
                self._tasks.wake(kind, task, now_s)

    def _beat(self, now_s: float) -> None:
        self._seq += 1
        heartbeat = MachineHeartbeat(
            machine=self.id,
            incarnation=self.incarnation,
            seq=self._seq,
            at_s=now_s,
            status=self._status,
            product=self._cycling.work.product if self._cycling else "",
            goals=self._goals.briefs(),
            tasks=tuple(_brief(task) for task in self._tasks),
            buffers=self._buffer_levels(),
            goods=tuple(
                BufferLevel(item=product, level=self._stock.get(product, 0), capacity=self._spec.goods_capacity)
                for product in self._products
            ),
            problem=self._problem,
            software=self._software,
        )
        self._out.append(Publish(self._beat_key, heartbeat))
        interval_s = WORKING_INTERVAL_S if self._goals.unfinished else IDLE_INTERVAL_S
        if self._seq == 1:
            # Agents that start together must not beat together for ever.
            interval_s *= 0.5 + crc32(self.id.encode()) % 1000 / 2000
        self._timers.set(BEAT, now_s + interval_s)

    # --- the workcell reports ---

    def _cycle_done(self, report: CycleDone, now_s: float) -> None:
        goal, self._cycling = self._cycling, None
        self._stock[report.product] = self._stock.get(report.product, 0) + 1
        if goal is None or goal.work.product != report.product:
            raise ProtocolViolation(f"{self.id}: a cycle of {report.product} ended that was never begun")
        goal.made += 1
        fact = PieceMade(goal=goal.id, product=report.product, made=goal.made)
        self._out.append(Record(fact))
        self._pursue(now_s)

    def _cycle_failed(self, report: CycleFailed, now_s: float) -> None:
        # The senses will put the stock right at the next beat; then it is tried again.
        self._cycling = None
        self._timers.set(BEAT, now_s)

    def _stock_changed(self, report: StockChanged, now_s: float) -> None:
        self._stock[report.item] = self._stock.get(report.item, 0) + report.change
        self._pursue(now_s)

    def _broken(self, report: Broken, now_s: float) -> None:
        self._problem = report.reason
        self._update_status(now_s)

    def _repaired(self, _report: Repaired, now_s: float) -> None:
        self._problem = ""
        self._pursue(now_s)

    # --- deciding ---

    def _pursue(self, now_s: float) -> None:
        """Do whatever the present state asks for."""
        self._start_cycle()
        for material in self._materials:
            self._replenish(material, now_s)
        for goal in self._goals:
            self._send_goods(goal, now_s)
        self._update_status(now_s)

    def _start_cycle(self) -> None:
        if self._cycling is not None or self._problem or self._goods_full():
            return
        goal = self._goals.next_to_make(self._stock)
        if goal is None:
            return
        self._cycling = goal
        for line in self._plant.products[goal.work.product].bill:
            self._stock[line.material] -= line.quantity
        self._out.append(Instruct(StartCycle(product=goal.work.product)))

    def _goods_full(self) -> bool:
        return sum(self._stock.get(product, 0) for product in self._products) >= self._spec.goods_capacity

    def _replenish(self, material: str, now_s: float) -> None:
        need = self._goals.need(material, self._cycling.work.product if self._cycling else "")
        use_per_s = self._goals.use_per_s(material)
        if not need or not use_per_s:
            return
        level, on_order = self._stock.get(material, 0), self._on_order(material)
        spec = self._plant.materials[material]
        quantity = order_quantity(
            level=level,
            on_order=on_order,
            need=need,
            point=self._reorder_point(material),
            lot=spec.lot,
            capacity=spec.buffer,
        )
        if not quantity:
            return
        work = Transport(
            item=material,
            quantity=quantity,
            sources=self._plant.storages_of(material),
            destination=self.id,
            ability=spec.ability,
        )
        deadline_s = max(
            runs_out_at_s(now_s, level + on_order, use_per_s), now_s + self._lead[material].mean_s
        )
        self._open(work, deadline_s, now_s)

    def _send_goods(self, goal: Goal, now_s: float) -> None:
        product = self._plant.products[goal.work.product]
        while goal.ready >= product.lot or (goal.ready > 0 and goal.to_make == 0):
            quantity = min(goal.ready, product.lot)
            goal.committed += quantity
            work = Transport(
                item=product.id,
                quantity=quantity,
                sources=(self.id,),
                destination=self._plant.delivery_warehouses[0],
                ability=product.ability,
                goal=goal.id,
            )
            patience_s = 2.0 * max(lead.mean_s for lead in self._lead.values())
            self._open(work, max(goal.deadline_s, now_s + patience_s), now_s)

    def _open(self, work: Transport, deadline_s: float, now_s: float) -> None:
        self._task_count += 1
        life = "" if self.incarnation == 1 else f".{self.incarnation}"
        self._tasks.open(f"{self.id}{life}-{self._task_count}", work, deadline_s, now_s)
        self._timers.set(BEAT, now_s)

    def _update_status(self, now_s: float) -> None:
        status, reason = self._present_status()
        if status is self._status:
            return
        self._status = status
        product = self._cycling.work.product if self._cycling else ""
        self._out.append(Record(MachineStatusChanged(status=status, product=product, reason=reason)))
        self._timers.set(BEAT, now_s)

    def _present_status(self) -> tuple[MachineStatus, str]:
        if self._problem:
            return MachineStatus.ERROR, self._problem
        if self._cycling is not None:
            return MachineStatus.PRODUCING, ""
        if not self._goals.unfinished:
            return MachineStatus.IDLE, ""
        if self._goods_full():
            return MachineStatus.BLOCKED, "the goods are not fetched"
        return MachineStatus.STARVED, "material is missing"

    # --- transports ---

    def _audience(self, _work: Work, radius_m: float) -> tuple[str, ...]:
        x_m, y_m = self._plant.position_of(self.id)
        return tuple(self._keys.transports(cell) for cell in self._plant.cells_within(x_m, y_m, radius_m))

    def _on_contracted(self, _task: OpenTask, now_s: float) -> None:
        self._timers.set(BEAT, now_s)

    def _hear_docked(self, sender: str, message: Docked, _now_s: float) -> None:
        """Grant a transfer to the carrier of the present epoch, and to nobody else."""
        task = self._tasks.get(message.task)
        if task is None or message.epoch != task.epoch or sender != task.primary:
            self._supersede(sender, message.task)
            return
        work = cast(Transport, task.work)
        held = self._why_dock_is_held(work) if message.station == self.id else ""
        if held:
            answer: Message = DockHeld(
                task=task.id, epoch=task.epoch, station=message.station, reason=held
            )
        else:
            answer = DockOpened(task=task.id, epoch=task.epoch, station=message.station)
            if message.station == self.id:
                opening = OpenDock(vehicle=sender, item=work.item, quantity=work.quantity)
                self._out.append(Instruct(opening))
        self._out.append(Send(sender, answer))

    def _why_dock_is_held(self, work: Transport) -> str:
        level = self._stock.get(work.item, 0)
        if work.goal:
            return "" if level >= work.quantity else "the goods are not ready"
        room = self._plant.materials[work.item].buffer - level
        return "" if room >= work.quantity else "the buffer is full"

    def _hear_handover(self, sender: str, message: Handover, now_s: float) -> None:
        """The load has arrived: once per task, however often it is said."""
        task = self._tasks.get(message.task)
        if task is None:
            closed = self._tasks.closed(message.task)
            if closed is not None and closed.carrier == sender and closed.outcome == "delivered":
                self._out.append(Send(sender, HandoverAccepted(task=message.task, epoch=message.epoch)))
            else:
                self._supersede(sender, message.task)
        elif message.epoch != task.epoch or sender != task.primary:
            self._supersede(sender, message.task)
        else:
            self._out.append(Send(sender, HandoverAccepted(task=task.id, epoch=task.epoch)))
            self._tasks.close(task, "delivered")
            self._note_delivered(task, now_s)
            self._pursue(now_s)

    def _note_delivered(self, task: OpenTask, now_s: float) -> None:
        work = cast(Transport, task.work)
        if not work.goal:
            self._lead[work.item].note(now_s - task.opened_s)
        elif (goal := self._goals.get(work.goal)) is not None:
            goal.delivered += work.quantity
            fact = GoodsDelivered(
                goal=goal.id,
                order=goal.work.order,
                item=goal.work.item,
                product=goal.work.product,
                quantity=work.quantity,
                delivered=goal.delivered,
            )
            self._out.append(Record(fact))
        self._timers.set(BEAT, now_s)

    def _supersede(self, sender: str, task_id: str) -> None:
        task, closed = self._tasks.get(task_id), self._tasks.closed(task_id)
        known = task.epoch if task is not None else closed.epoch if closed is not None else 0
        self._out.append(Send(sender, Superseded(task=task_id, epoch=known)))

    # --- goals ---

    def _hear_announced(self, sender: str, message: TaskAnnounced, now_s: float) -> None:
        work = message.work
        if not isinstance(work, Production) or work.product not in self._products:
            return
        if self._problem:
            refused = BidRefused(
                task=message.task,
                epoch=message.epoch,
                role=message.role,
                reason=Refusal.NOT_FIT,
                detail=self._problem,
            )
            self._out.append(Record(refused))
            return
        cost = self._goals.quote(work, self._stock, self._longest_lead_s(work.product))
        finish_s = now_s + cost.total_s
        self._quoted_s[message.task] = finish_s
        if len(self._quoted_s) > QUOTES_KEPT:
            del self._quoted_s[next(iter(self._quoted_s))]
        bid = Bid(
            task=message.task,
            epoch=message.epoch,
            role=message.role,
            round=message.round,
            cost=cost,
            finish_s=finish_s,
        )
        sent = BidSent(task=message.task, epoch=message.epoch, role=message.role, total_s=cost.total_s)
        self._out += (Send(message.coordinator, bid), Record(sent))

    def _hear_award(self, sender: str, message: Award, now_s: float) -> None:
        work = message.work
        if not isinstance(work, Production):
            return
        if self._goals.get(message.task) is not None:
            self._accept(sender, message, now_s)
            return
        reason = self._why_not_take(message.task, work, now_s)
        if reason is not None:
            declined = Declined(task=message.task, epoch=message.epoch, role=message.role, reason=reason)
            self._out.append(Send(sender, declined))
            return
        self._goals.add(Goal(message.task, work, message.deadline_s))
        self._accept(sender, message, now_s)
        taken = ContractTaken(
            task=message.task, epoch=message.epoch, role=message.role, coordinator=sender
        )
        self._out.append(Record(taken))
        self._pursue(now_s)
        self._timers.set(BEAT, now_s)

    def _accept(self, sender: str, message: Award, now_s: float) -> None:
        finish_s = self._quoted_s.get(message.task, now_s)
        accepted = Accepted(
            task=message.task, epoch=message.epoch, role=message.role, finish_s=finish_s
        )
        self._out.append(Send(sender, accepted))

    def _why_not_take(self, goal: str, work: Production, now_s: float) -> Refusal | None:
        """A goal taken since the bid may have made the promise empty."""
        if self._problem:
            return Refusal.NOT_FIT
        cost = self._goals.quote(work, self._stock, self._longest_lead_s(work.product))
        promised_s = self._quoted_s.get(goal, now_s + cost.total_s)
        late_s = now_s + cost.total_s - promised_s
        return Refusal.BUSY if late_s > QUOTE_TOLERANCE_S else None

    def _hear_goal_over(self, _sender: str, message: Release | Withdrawn, now_s: float) -> None:
        """Give a goal back, as long as nothing of it was begun."""
        goal = self._goals.get(message.task)
        if goal is None or goal.made or goal is self._cycling:
            return
        self._goals.remove(goal.id)
        ended = ContractEnded(
            task=goal.id, epoch=message.epoch, role=Role.PRIMARY, reason=message.reason
        )
        self._out.append(Record(ended))
        self._pursue(now_s)

    def _hear_goal_closed(self, _sender: str, message: GoalClosed, now_s: float) -> None:
        goal = self._goals.get(message.goal)
        if goal is not None and goal.delivered >= goal.work.quantity:
            self._goals.remove(goal.id)
            ended = ContractEnded(task=goal.id, epoch=1, role=Role.PRIMARY, reason="delivered")
            self._out.append(Record(ended))
            self._update_status(now_s)

    # --- figures ---

    def _first_lead_time_s(self, material: str) -> float:
        routes = [self._plant.routes(each) for each in self._plant.vehicle_types]
        node = self._plant.node_of(self.id)
        ways_s = [
            route.duration_s(self._plant.node_of(storage), node)
            for storage in self._plant.storages_of(material)
            for route in routes
        ]
        handling_s = max(each.load_s + each.unload_s for each in self._plant.vehicle_types.values())
        return TYPICAL_APPROACH_S + min(ways_s) + handling_s

    def _longest_lead_s(self, product: str) -> float:
        return max(self._lead[line.material].mean_s for line in self._plant.products[product].bill)

    def _reorder_point(self, material: str) -> int:
        spec = self._plant.materials[material]
        per_cycle = max(
            line.quantity
            for product in self._products
            for line in self._plant.products[product].bill
            if line.material == material
        )
        use_per_s = self._goals.use_per_s(material)
        lead_s = self._lead[material].mean_s
        return reorder_point(use_per_s, lead_s, per_cycle, max(per_cycle, spec.buffer - spec.lot))

    def _on_order(self, item: str) -> int:
        return sum(
            task.work.quantity
            for task in self._tasks
            if isinstance(task.work, Transport) and task.work.item == item and not task.work.goal
        )

    def _buffer_levels(self) -> tuple[BufferLevel, ...]:
        return tuple(
            BufferLevel(
                item=material,
                level=self._stock.get(material, 0),
                capacity=self._plant.materials[material].buffer,
                reorder_point=self._reorder_point(material),
                on_order=self._on_order(material),
            )
            for material in self._materials
        )


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
    )
