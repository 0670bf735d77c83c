"""What comes to a machine and what leaves it: its needs, its transports, its dock, its goods.

A machine coordinates all of its transports itself (paper, 3.2). Here its parts are put together: material that runs low is
set aside (`sourcing`) and fetched, finished goods are carried away (`finished_goods`), vehicles are hired and watched
(`transports`), let in (`dock`) and let go when their load was counted (`handovers`); and after a restart all of that goes
on (`recovery`). What the machine makes of it, it is told by whoever holds this (`Owner`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Protocol, cast

from msgspec.structs import replace

from dray.body import StockChanged, WorkcellState
from dray.memory import MachineMemory
from dray.messages import (
    Accepted,
    AtvHeartbeat,
    Bid,
    Declined,
    Docked,
    DockExpected,
    Handover,
    Message,
    Resigned,
    StockReserved,
    StockShort,
    TakenOver,
    Transport,
    Work,
    WorkSought,
)
from dray.messages.fact import Outcome
from dray.messages.keys import Keys
from dray.plant import Plant
from dray.protocol.contract_net.auction_rules import AuctionRules
from dray.protocol.contract_net.task import OpenTask
from dray.protocol.contract_net.terms import Place
from dray.protocol.contract_net.trust.assessment import Assessor
from dray.protocol.liveness.failure_detector import HeartbeatSubscriptions
from dray.protocol.machine.dock import Dock
from dray.protocol.machine.finished_goods import FinishedGoods
from dray.protocol.machine.production import Goal, GoalBook
from dray.protocol.machine.sourcing import Need, Sourcing
from dray.protocol.machine.supply import Supply
from dray.protocol.machine.transports.backlog import unneeded
from dray.protocol.machine.transports.handovers import Handovers
from dray.protocol.machine.transports.recovery import RECOVERY_WAIT, Recovery
from dray.protocol.machine.transports.transports import Transports
from dray.protocol.runtime.events import Effect, Ignore
from dray.protocol.runtime.timers import Timers

NOT_REMEMBERED = "about a task that may be of a life that has left no notes"

HELD_MAX_S = 60.0
"""How long a vehicle may wait for room: two or three cycles, if the machine can work at all."""


class Owner(Protocol):
    """What a machine does when its material moves."""

    def pursue(self, now_s: float) -> None:
        """Something has come or gone: go on with what can be done now."""

    def note_done(self) -> None:
        """A transport came to its good end."""

    def ask_for_count(self, goal: Goal, now_s: float) -> None:
        """The gate may have counted more of a goal than is known."""

    def miss_goods(self, goal: Goal | None, now_s: float) -> None:
        """Pieces of a goal are lost, or nobody knows where they are."""

    def commit(self) -> None:
        """The next life must know of something else."""

    def beat_soon(self, now_s: float) -> None:
        """The heartbeat tells something new."""


class MaterialFlow:
    """The material flow of one machine.

    Args:
        machine: its id in the plant.
        plant: the plant it stands in.
        keys: the plant's bus keys.
        goals: what it makes.
        supply: its buffers and goods.
        rules: patience and reach of its auctions.
        timers: its alarms; this class and what it consists of use names ``(kind, task)``, and `RECOVERY_WAIT`.
        out: where effects go.
        owner: the machine.
        incarnation: how often it has been started.
        tells_node: others' plant files do not know where it stands: every transport says so.

    Attributes:
        tasks: its open transports.
        task_count: how many were named, over all lives.
        sourcing: the material that is waited for.
        goods: those that wait to be fetched.
        message_handlers: by the type of a message, what to call with (sender, message, now_s).
        alarms: what to call when an alarm of these names has come.
        subscriptions: which heartbeats it hears.
    """

    def __init__(
        self,
        machine: str,
        plant: Plant,
        keys: Keys,
        goals: GoalBook,
        supply: Supply,
        rules: AuctionRules,
        timers: Timers,
        out: list[Effect],
        owner: Owner,
        *,
        incarnation: int,
        tells_node: bool,
    ) -> None:
        self._machine = machine
        self._plant = plant
        self._keys = keys
        self._goals = goals
        self._supply = supply
        self._out = out
        self._owner = owner
        self._life = "" if incarnation == 1 else f".{incarnation}"
        self._node = plant.node_of(machine) if tells_node else ""
        self.task_count = 0
        x_m, y_m = plant.position_of(machine)
        self.subscriptions = HeartbeatSubscriptions(keys.atv_heartbeat, out)
        self.tasks = Transports(
            machine,
            Place(x_m=x_m, y_m=y_m, reach_m=plant.diameter_m),
            self._audience,
            rules,
            timers,
            self.subscriptions,
            Assessor(plant, out),
            out,
            contracted=self._on_carrier_changed,
            lost=self._on_task_lost,
            is_missing=lambda task: self.goods.lack(task),  # noqa: PLW0108 - made below
            source_answers=lambda task, now_s: self.sourcing.answers(task, now_s),  # noqa: PLW0108 - made below
            left=lambda atv: self._dock.shut(atv),  # noqa: PLW0108 - made below
            unloaded=self._settle,
            commit=owner.commit,
            ended=self._on_task_ended,
            incarnation=incarnation,
        )
        self.sourcing = Sourcing(
            machine,
            plant,
            timers,
            out,
            announce=self._announce_sourced,
            task_of=self.tasks.get,
            starve=self.withdraw,
            changed=owner.beat_soon,
        )
        self._dock = Dock(machine, self.tasks, supply, out)
        self.goods = FinishedGoods(
            machine, plant, goals, supply, self.tasks, send=self._send_goods, lose=owner.miss_goods
        )
        self._handovers = Handovers(
            machine,
            self.tasks,
            goals,
            self._dock,
            out,
            ask=owner.ask_for_count,
            settled=self._settle_counted,
        )
        self._recovery = Recovery(machine, plant, self.subscriptions, self.tasks, supply, timers)
        self.message_handlers: dict[type[Message], Callable[..., None]] = {
            AtvHeartbeat: self._on_vehicle,
            Bid: self.tasks.on_bid,
            Accepted: self._on_accepted,
            Declined: self.tasks.on_declined,
            Resigned: self._on_resigned,
            StockReserved: self.sourcing.on_reserved,
            StockShort: self.sourcing.on_short,
            TakenOver: self._on_taken_over,
            Docked: self._on_docked,
            DockExpected: self.tasks.docks.on_expected,
            Handover: self._handovers.on_handover,
        }
        self.alarms: Mapping[str, Callable[[Any, float], None]] = {
            RECOVERY_WAIT: self._end_recovery,
            **self.tasks.alarms,
            **self.sourcing.alarms,
        }

    # --- the beginning ---

    def take_count(self, body: WorkcellState) -> None:
        """Take over what the body has counted."""
        self._supply.take_count(body.stock, body.seq)
        self._handovers.counts = body.counts

    def restore(self, memory: MachineMemory, now_s: float) -> None:
        """Go on with the transports of an earlier life."""
        self.task_count = memory.task_count
        for kept in memory.tasks:
            work, goal = kept.work, self._goals.get(kept.work.goal)
            self.sourcing.follow(self.tasks.restore(kept, now_s), now_s)
            if goal is not None:
                goal.committed += work.quantity
            elif work.destination == self._machine:
                self._supply.ordered(work)

    def recover(self, forgetful: bool, now_s: float) -> None:
        """Listen for vehicles that work for this machine, and that it does not know of."""
        self._recovery.listen(forgetful, now_s)

    def _end_recovery(self, _about: None, now_s: float) -> None:
        self._recovery.stop_listening()
        # What had left before this life began, its carrier has told by now.
        self.goods.recount(now_s)
        self._owner.pursue(now_s)

    # --- what the machine asks and tells ---

    @property
    def is_held(self) -> bool:
        """Whether somebody may be about to answer, or is at the dock."""
        return self.tasks.awaits_answers or any(task.is_changing_hands for task in self.tasks)

    def announce_needs(self, product: str, now_s: float) -> None:
        """Have material brought for what is made and for what is to come, and goods fetched."""
        for need in list(self.sourcing):
            if not self._supply.needs(need.work.item, product):
                self._drop(need)
        while (order := self._supply.next_order(product, now_s)) is not None:
            work, deadline_s = order
            self._supply.ordered(work)
            self.sourcing.seek(self._next_task(), self._docked_here(work), deadline_s, now_s)
        self.goods.dispatch(now_s)

    def give_back(self, now_s: float) -> None:
        """Nothing is to be brought any more for what is not made here, unless it is on board."""
        for task in unneeded(self.tasks, self._supply):
            self.withdraw(task, now_s)

    def drop_needs(self) -> None:
        """Nothing is to be hired any more for what nobody was hired for yet."""
        for need in list(self.sourcing):
            self._drop(need)

    def offer(self, sender: str, message: WorkSought, now_s: float) -> None:
        """Offer what waits to a vehicle that asks for work."""
        if not self.tasks.offer(sender, message.abilities, now_s):
            self._out.append(Ignore("asked for work, and none waits"))

    def on_material(self, report: StockChanged, now_s: float) -> None:
        """Material has come, or was taken."""
        self._handovers.on_stock_changed(report, now_s)

    def on_goods(self, report: StockChanged, is_news: bool, now_s: float) -> None:
        """Goods were made, or have left."""
        self.goods.moved(report, now_s)
        if not is_news:
            self.goods.recount(now_s)

    def on_goal_counted(self, goal: str, now_s: float) -> None:
        """The gate's count of a goal is known anew."""
        self._handovers.on_goal_counted(goal, now_s)

    # --- announcing ---

    def _announce_sourced(self, need: Need, now_s: float) -> None:
        """Material is set aside: have it fetched."""
        deadline_s = self._supply.latest_s(need.work, need.deadline_s, now_s)
        self._announce(need.task, need.work, deadline_s, now_s)

    def _send_goods(self, work: Transport, deadline_s: float, now_s: float) -> None:
        """Have goods fetched."""
        self._announce(self._next_task(), self._docked_here(work), deadline_s, now_s)

    def _announce(self, task: str, work: Transport, deadline_s: float, now_s: float) -> None:
        self.tasks.open(task, work, deadline_s, now_s)
        self._owner.commit()
        self._owner.beat_soon(now_s)

    def _drop(self, need: Need) -> None:
        """Material is not needed any more, for which nobody was hired yet."""
        self.sourcing.drop(need)
        self._supply.settled(need.work, None)

    def _docked_here(self, work: Transport) -> Transport:
        """A transport as others need it to be told: where this machine stands, if they do not know."""
        return replace(work, node=self._node) if self._node else work

    def _next_task(self) -> str:
        self.task_count += 1
        return f"{self._machine}{self._life}-{self.task_count}"

    def _audience(self, _work: Work, radius_m: float) -> tuple[str, ...]:
        x_m, y_m = self._plant.position_of(self._machine)
        return tuple(self._keys.transports(cell) for cell in self._plant.cells_within(x_m, y_m, radius_m))

    # --- what vehicles say ---

    def _on_vehicle(self, _sender: str, heartbeat: AtvHeartbeat, now_s: float) -> None:
        self.tasks.on_heartbeat(heartbeat, now_s)
        self._handovers.on_carrier_heard(heartbeat.atv)
        self._recovery.on_heartbeat(heartbeat, now_s)

    def _on_accepted(self, sender: str, answer: Accepted, now_s: float) -> None:
        if self._is_remembered(answer.task):
            self.tasks.on_accepted(sender, answer, now_s)

    def _on_taken_over(self, sender: str, message: TakenOver, now_s: float) -> None:
        if self._is_remembered(message.task):
            self.tasks.on_taken_over(sender, message, now_s)

    def _on_docked(self, sender: str, message: Docked, now_s: float) -> None:
        if not self._is_remembered(message.task):
            return
        task = self.tasks.get(message.task)
        if task is not None and self.goods.lack(task):
            # Nothing would ever make them come: they are lost, and the books do not know.
            self.goods.recount(now_s)
        self._dock.on_docked(sender, message, now_s)
        task = self.tasks.get(message.task)
        if task is not None and now_s - task.contract.held_s > HELD_MAX_S:
            self.withdraw(task, now_s)

    def _on_resigned(self, sender: str, message: Resigned, now_s: float) -> None:
        task = self.tasks.get(message.task)
        gives_back = task is not None and (sender, message.epoch) == (task.primary, task.epoch)
        if task is None or not gives_back or not message.short or task.is_of_goods or task.is_counted:
            self.tasks.on_resigned(sender, message, now_s)
            return
        if self.sourcing.holds(task.id, message.short):
            # Its station says otherwise, as far as is known.
            self.tasks.failover.note_given_back(task, message.reason, now_s)
        # Nobody else would find more there: nobody is hired before a station has it.
        self.withdraw(task, now_s)

    def _is_remembered(self, task: str) -> bool:
        """Whether a word about a task can be answered yet; else it is said again."""
        if self._recovery.waits_for_word_on(task):
            self._out.append(Ignore(NOT_REMEMBERED))
            return False
        return True

    # --- what becomes of a transport ---

    def _on_carrier_changed(self, task: OpenTask, now_s: float) -> None:
        self._owner.commit()
        self._owner.beat_soon(now_s)
        self.sourcing.follow(task, now_s)
        self.goods.keep_unwanted()

    def _on_task_ended(self, task: OpenTask, outcome: Outcome) -> None:
        self.sourcing.on_task_closed(task, fetched=outcome == "delivered")

    def _on_task_lost(self, task: OpenTask, now_s: float) -> None:
        """A task was withdrawn; what is needed in its place is made, or ordered, anew."""
        work = cast(Transport, task.work)
        if work.destination != self._machine:
            self.goods.lost(task, now_s)
        else:
            self._supply.settled(work, None)
        self._owner.commit()
        self._owner.beat_soon(now_s)
        self._owner.pursue(now_s)

    def withdraw(self, task: OpenTask, now_s: float) -> None:
        """End a transport. Material that finds no room, or goods that are not there, keep a vehicle from whatever would help."""
        self.tasks.close(task, "withdrawn")
        self._on_task_lost(task, now_s)

    def _settle(self, task: OpenTask, now_s: float) -> None:
        """A transport was delivered, though its carrier has not said so."""
        self._settle_counted(task, "", cast(Transport, task.work).quantity, now_s)

    def _settle_counted(self, task: OpenTask, carrier: str, counted: int, now_s: float) -> None:
        """A transport was delivered, so many pieces of it."""
        self._owner.note_done()
        self._owner.commit()
        work = cast(Transport, task.work)
        goal = self._goals.get(work.goal)
        if goal is not None:
            goal.deliver(carrier, work.quantity, min(counted, work.quantity))
            if counted < work.quantity:
                self._owner.miss_goods(goal, now_s)
        elif work.destination == self._machine:
            self._supply.settled(work, now_s - task.opened_s)
        self._owner.beat_soon(now_s)
        self._owner.pursue(now_s)
