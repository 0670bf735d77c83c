"""A production machine: makes goals, orders its own material, has its products carried away (paper, 3.2).

It is a contractor towards the strategist, whose goals it bids for (`goal_bidding`), and the coordinator
of all its transports (`transports`, `dock`). It watches its buffers (`supply`); everything else
follows from `_pursue`, which is asked after every change: start the next cycle, order what runs low,
have finished goods fetched, say so.

One that is asked to leave takes no goal and opens no new task. It stays while somebody may be about to answer
it, or is at its dock. Its goals are its own if its next life speaks within GOAL_SILENCE_S (`strategist.machine_monitor`);
the body goes on with its cycle meanwhile.
"""

from __future__ import annotations

from typing import cast

from msgspec.structs import replace

from dray.body import (
    BodyState,
    Book,
    Broken,
    CycleDone,
    CycleFailed,
    Repaired,
    StockChanged,
    WorkcellState,
)
from dray.errors import ProtocolViolation
from dray.memory import WHOLE, MachineMemory, Memory, Note
from dray.messages import (
    Accepted,
    AtvHeartbeat,
    Award,
    Bid,
    Confirmed,
    Declined,
    Disbelieved,
    Docked,
    GoalClosed,
    Handover,
    JoiningMachine,
    MachineHeartbeat,
    MachineStatus,
    Message,
    Release,
    Resigned,
    Role,
    StockReserved,
    StockShort,
    TakenOver,
    TaskAnnounced,
    Transport,
    Withdrawn,
    Work,
    WorkSought,
)
from dray.messages.fact import HandoverDisputed, MachineStatusChanged
from dray.messages.heartbeat import Making
from dray.messages.keys import Keys
from dray.plant import Plant
from dray.plant.model import MachineSpec
from dray.protocol.contract_net.assessment import Assessor
from dray.protocol.contract_net.auction import Place
from dray.protocol.contract_net.auction_rules import AuctionRules
from dray.protocol.contract_net.disbelief import Reproach
from dray.protocol.contract_net.parties import objection
from dray.protocol.contract_net.probation import Probation
from dray.protocol.contract_net.task import OpenTask, Outcome
from dray.protocol.contract_net.task_state import TaskState
from dray.protocol.liveness.failure_detector import HeartbeatSubscriptions
from dray.protocol.liveness.progress import NOT_COUNTED
from dray.protocol.liveness.suspicion import interval_s
from dray.protocol.machine.cycle import Cycle
from dray.protocol.machine.dock import Dock
from dray.protocol.machine.finished_goods import FinishedGoods
from dray.protocol.machine.goal_bidding import GoalBidder
from dray.protocol.machine.production import Goal, GoalBook
from dray.protocol.machine.receiving import Verdict, verdict_on
from dray.protocol.machine.recovery import ADOPT, Recovery
from dray.protocol.machine.sourcing import Need, Sourcing
from dray.protocol.machine.supply import Supply
from dray.protocol.machine.transports import Transports
from dray.protocol.runtime.agent import AgentBase
from dray.protocol.runtime.events import (
    NEVER_S,
    Ignore,
    Instruct,
    Publish,
    Record,
    Subscribe,
)
from dray.protocol.runtime.heartbeat_timer import BEAT, HeartbeatTimer
from dray.protocol.runtime.shutdown import COORDINATOR_LEAVES_WITHIN_S, GRACEFUL_SHUTDOWN

NOT_REMEMBERED = "about a task that may be of a life that has left no notes"

HELD_MAX_S = 60.0
"""How long a vehicle may wait for room: two or three cycles, if the machine can work at all."""


class Machine(AgentBase):
    """One production machine.

    Args:
        machine: its id in the plant.
        plant: the plant it stands in.
        incarnation: how often it has been started.
        software: the version it runs, for its heartbeat.
        joining: the plant files of others do not know it: it says itself what it is and where it stands.
        probation: transports to or from it that have to be done well before it takes long goals; 0 for a
            machine that is known to be good.
        rules: patience and reach of its auctions.
    """

    def __init__(
        self,
        machine: str,
        plant: Plant,
        *,
        incarnation: int = 1,
        software: str = "",
        joining: bool = False,
        probation: int = 0,
        rules: AuctionRules | None = None,
    ) -> None:
        super().__init__(machine, incarnation, leaves_within_s=COORDINATOR_LEAVES_WITHIN_S)
        self._plant = plant
        self._spec = plant.machines[machine]
        self._software = software
        self._heartbeat_timer = HeartbeatTimer(self.id, self._timers)
        self._joining = _introduction(self._spec) if joining else None
        self._keys = Keys(plant.id)
        self._beat_key = self._keys.machine_heartbeat(machine)
        self._products = tuple(making.product for making in self._spec.makes)
        self._goals = GoalBook(machine, plant)
        self._supply = Supply(machine, plant, self._goals)
        self._probation = Probation(probation)
        lots = {product: plant.products[product].lot for product in self._products}
        self._bidder = GoalBidder(
            lots, self._goals, self._supply, self._probation, self._timers, self._out, self._commit
        )
        x_m, y_m = plant.position_of(machine)
        self._subscriptions = HeartbeatSubscriptions(self._keys.atv_heartbeat, self._out)
        self._tasks = Transports(
            machine,
            Place(x_m=x_m, y_m=y_m, reach_m=plant.diameter_m),
            self._audience,
            rules or AuctionRules(),
            self._timers,
            self._subscriptions,
            Assessor(plant, self._out),
            self._out,
            contracted=self._on_carrier_changed,
            lost=self._on_task_lost,
            is_missing=self._is_missing,
            source_answers=self._source_answers,
            left=self._on_left,
            unloaded=self._settle,
            commit=self._commit,
            ended=self._on_task_ended,
            incarnation=incarnation,
        )
        self._sourcing = Sourcing(
            machine,
            plant,
            self._timers,
            self._out,
            announce=self._announce_sourced,
            task_of=self._tasks.get,
            starve=self._withdraw,
            changed=self._heartbeat_timer.at_once,
        )
        self._dock = Dock(machine, self._tasks, self._supply, self._out)
        self._goods = FinishedGoods(
            machine,
            plant,
            self._goals,
            self._supply,
            self._tasks,
            send=self._open,
            lose=self._on_goal_short,
        )
        self._recovery = Recovery(
            machine, plant, self._keys, self._tasks, self._supply, self._timers, self._out
        )
        self._cycle = Cycle(plant, self._goals, self._supply, self._out, self._commit)
        self._problem = ""
        self._status = MachineStatus.IDLE
        self._task_count = 0
        self._counts = True
        """Whether its body counts what vehicles bring and take."""
        self._message_handlers = {
            AtvHeartbeat: self._on_vehicle,
            Bid: self._tasks.on_bid,
            Accepted: self._on_accepted,
            Declined: self._tasks.on_declined,
            Resigned: self._on_resigned,
            StockReserved: self._sourcing.on_reserved,
            StockShort: self._sourcing.on_short,
            TakenOver: self._on_taken_over,
            Docked: self._on_docked,
            Handover: self._on_handover,
            TaskAnnounced: lambda _sender, message, now_s: self._bidder.on_announced(
                message, self._unfit(), now_s
            ),
            Award: self._on_award,
            Confirmed: self._on_confirmed,
            Release: self._on_goal_over,
            Withdrawn: self._on_goal_over,
            GoalClosed: self._on_goal_closed,
            WorkSought: self._on_sought,
            Disbelieved: Reproach(self._out).on_disbelieved,
        }
        self._report_handlers = {
            CycleDone: self._cycle_done,
            CycleFailed: self._cycle_failed,
            StockChanged: self._stock_changed,
            Broken: self._broken,
            Repaired: self._repaired,
        }
        self._alarm_handlers = {
            BEAT: self._beat,
            **self._bidder.alarms,
            ADOPT: self._end_adoption,
            **self._tasks.alarms,
            **self._sourcing.alarms,
        }

    # --- the beginning, and time passing ---

    def _start(self, body: BodyState | None, memory: Memory, now_s: float) -> None:
        if not isinstance(body, WorkcellState):
            raise ProtocolViolation(f"{self.id}: a machine needs a workcell, not {body!r}")
        self._supply.begin(body.stock, body.seq)
        self._counts = body.counts
        self._problem = body.broken
        self._cycle.product = body.cycling
        note = memory.get(WHOLE)
        if isinstance(note, MachineMemory):
            self._recall(note, now_s)
        self._goods.count()
        self._out.extend(Subscribe(self._keys.goals(product)) for product in self._products)
        self._out.append(Subscribe(self._keys.all_free))
        if self.incarnation > 1:
            self._recovery.begin(note is None, now_s)
        self._heartbeat_timer.at_once(now_s)
        self._pursue(now_s)

    def _end_adoption(self, _about: None, now_s: float) -> None:
        self._recovery.end()
        # What had left before this life began, its carrier has told by now.
        self._goods.recount(now_s)
        self._pursue(now_s)

    def _recall(self, memory: MachineMemory, now_s: float) -> None:
        """Go on with what an earlier life was bound by."""
        self._task_count = memory.task_count
        for booked in memory.goals:
            # It goes on with them: the strategist may be away, and the gate knows what may still get in.
            self._bidder.ask(self._goals.restore(booked), now_s)
        for kept in memory.tasks:
            work, goal = kept.work, self._goals.get(kept.work.goal)
            self._sourcing.follow(self._tasks.restore(kept, now_s), now_s)
            if goal is not None:
                goal.committed += work.quantity
            elif work.destination == self.id:
                self._supply.ordered(work)
        # Tasks without a carrier have a higher epoch now: no life may use one that an earlier one has used.
        self._commit()

    def _memory(self) -> Note:
        return MachineMemory(
            goals=self._goals.memories(),
            tasks=tuple(task.memory() for task in self._tasks),
            task_count=self._task_count,
        )

    def _sense(self, body: BodyState | None, now_s: float) -> None:
        if not isinstance(body, WorkcellState) or self._cycle.product not in ("", body.cycling):
            return  # A body elsewhere may not have heard of the cycle yet, whose material is used up here.
        if self._supply.sense(body.stock, body.seq):
            self._pursue(now_s)

    def _beat(self, _about: None, now_s: float) -> None:
        self._heartbeat_timer.go_on(interval_s(self._say_status(now_s)), now_s)

    def _say_status(self, now_s: float) -> MachineHeartbeat:
        heartbeat = MachineHeartbeat(
            machine=self.id,
            incarnation=self.incarnation,
            seq=self._heartbeat_timer.count(),
            at_s=now_s,
            status=self._status,
            product=self._cycle.product,
            goals=self._goals.briefs(),
            tasks=tuple(task.brief() for task in self._tasks),
            buffers=self._supply.levels(),
            goods=self._goods.levels(),
            waits=self._sourcing.waits(),
            problem=self._problem,
            software=self._software,
            draining=self._shutdown.begun,
            probation=self._probation.brief(),
            joining=self._joining,
        )
        self._out.append(Publish(self._beat_key, heartbeat))
        return heartbeat

    def _was_deaf(self, span_s: float) -> None:
        self._subscriptions.arrivals.deaf_s += span_s

    # --- the end ---

    def _prepare_to_leave(self, now_s: float) -> None:
        for need in list(self._sourcing):
            self._drop(need)
        self._heartbeat_timer.at_once(now_s)

    def _is_held(self) -> bool:
        return self._tasks.awaits_answers or any(task.is_changing_hands for task in self._tasks)

    def _take_leave(self, now_s: float) -> None:
        self._say_status(now_s)

    # --- the workcell reports ---

    def _cycle_done(self, report: CycleDone, now_s: float) -> None:
        self._cycle.done(report.product, report.seq)
        self._pursue(now_s)

    def _cycle_failed(self, _report: CycleFailed, now_s: float) -> None:
        # The senses put the stock right at the next beat; then it is tried again.
        self._cycle.failed()
        self._heartbeat_timer.at_once(now_s)

    def _stock_changed(self, report: StockChanged, now_s: float) -> None:
        is_news = self._supply.change(report.item, report.change, report.seq)
        if report.item not in self._products:
            self._material_came(report, now_s)
        else:
            self._goods.moved(report, now_s)
            if not is_news:
                self._goods.recount(now_s)
            self._commit()
        self._pursue(now_s)

    def _material_came(self, report: StockChanged, now_s: float) -> None:
        for task in list(self._tasks):
            if report.vehicle and task.primary == report.vehicle and task.work_item == report.item:
                task.contract.receipt.counted += max(report.change, 0)
                if task.contract.receipt.counted and not task.is_counted:
                    task.states.enter(TaskState.COUNTED)
                self._receive(task, now_s)

    def _broken(self, report: Broken, now_s: float) -> None:
        self._problem = report.reason
        self._update_status(now_s)

    def _repaired(self, _report: Repaired, now_s: float) -> None:
        self._problem = ""
        self._pursue(now_s)

    # --- deciding ---

    def _pursue(self, now_s: float) -> None:
        """Do whatever the present state asks for."""
        self._cycle.share_spare()
        if not self._problem and not self._goods.full:
            self._cycle.start()
        if not self._shutdown.begun:
            self._announce_needs(now_s)
        self._update_status(now_s)

    def _announce_needs(self, now_s: float) -> None:
        """Have material brought, and goods fetched."""
        for need in list(self._sourcing):
            if not self._supply.needs(need.work.item, self._cycle.product):
                self._drop(need)
        while (order := self._supply.next_order(self._cycle.product, now_s)) is not None:
            work, deadline_s = order
            self._supply.ordered(work)
            self._sourcing.seek(self._next_task(), self._docked_here(work), deadline_s, now_s)
        self._goods.dispatch(now_s)

    def _announce_sourced(self, need: Need, now_s: float) -> None:
        """Material is set aside: have it fetched."""
        deadline_s = self._supply.latest_s(need.work, need.deadline_s, now_s)
        self._announce(need.task, need.work, deadline_s, now_s)

    def _drop(self, need: Need) -> None:
        """Material is not needed any more, for which nobody was hired yet."""
        self._sourcing.drop(need)
        self._supply.settled(need.work, None)

    def _open(self, work: Transport, deadline_s: float, now_s: float) -> None:
        """Have goods fetched."""
        self._announce(self._next_task(), self._docked_here(work), deadline_s, now_s)

    def _docked_here(self, work: Transport) -> Transport:
        """A transport as others need it to be told: where a joining machine stands they do not know."""
        return work if self._joining is None else replace(work, node=self._joining.node)

    def _next_task(self) -> str:
        self._task_count += 1
        life = "" if self.incarnation == 1 else f".{self.incarnation}"
        return f"{self.id}{life}-{self._task_count}"

    def _announce(self, task: str, work: Transport, deadline_s: float, now_s: float) -> None:
        self._tasks.open(task, work, deadline_s, now_s)
        self._commit()
        self._heartbeat_timer.at_once(now_s)

    def _update_status(self, now_s: float) -> None:
        status, reason = self._present_status()
        if status is self._status:
            return
        self._status = status
        fact = MachineStatusChanged(status=status, product=self._cycle.product, reason=reason)
        self._out.append(Record(fact))
        self._heartbeat_timer.at_once(now_s)

    def _present_status(self) -> tuple[MachineStatus, str]:
        if self._problem:
            return MachineStatus.ERROR, self._problem
        if self._cycle.product:
            return MachineStatus.PRODUCING, ""
        if not self._goals.unfinished:
            return MachineStatus.IDLE, ""
        if self._goods.full:
            return MachineStatus.BLOCKED, "the goods are not fetched"
        return MachineStatus.STARVED, self._sourcing.told() or "material is missing"

    # --- transports ---

    def _on_vehicle(self, _sender: str, heartbeat: AtvHeartbeat, now_s: float) -> None:
        self._tasks.on_heartbeat(heartbeat, now_s)
        if not self._counts:
            for task in self._tasks:
                if task.is_loaded and task.primary == heartbeat.atv:
                    self._book(task)
        self._recovery.on_heartbeat(heartbeat, now_s)

    def _on_sought(self, sender: str, message: WorkSought, now_s: float) -> None:
        if not self._shutdown.begun and not self._tasks.offer(sender, message.abilities, now_s):
            self._out.append(Ignore("asked for work, and none waits"))

    def _on_accepted(self, sender: str, answer: Accepted, now_s: float) -> None:
        if self._recovery.waits_for_word_on(answer.task):
            self._out.append(Ignore(NOT_REMEMBERED))
        else:
            self._tasks.on_accepted(sender, answer, now_s)

    def _on_taken_over(self, sender: str, message: TakenOver, now_s: float) -> None:
        if self._recovery.waits_for_word_on(message.task):
            self._out.append(Ignore(NOT_REMEMBERED))  # It says so again.
        else:
            self._tasks.on_taken_over(sender, message, now_s)

    def _audience(self, _work: Work, radius_m: float) -> tuple[str, ...]:
        x_m, y_m = self._plant.position_of(self.id)
        return tuple(self._keys.transports(cell) for cell in self._plant.cells_within(x_m, y_m, radius_m))

    def _on_carrier_changed(self, task: OpenTask, now_s: float) -> None:
        self._commit()
        self._heartbeat_timer.at_once(now_s)
        self._sourcing.follow(task, now_s)
        self._goods.keep_unwanted()

    def _on_left(self, atv: str) -> None:
        self._dock.shut(atv)

    def _on_task_ended(self, task: OpenTask, outcome: Outcome) -> None:
        self._sourcing.end(task, fetched=outcome == "delivered")

    def _on_resigned(self, sender: str, message: Resigned, now_s: float) -> None:
        task = self._tasks.get(message.task)
        gives_back = task is not None and (sender, message.epoch) == (task.primary, task.epoch)
        if task is None or not gives_back or not message.short or task.is_of_goods or task.is_counted:
            self._tasks.on_resigned(sender, message, now_s)
            return
        if self._sourcing.holds(task.id, message.short):
            # Its station says otherwise, as far as is known.
            self._tasks.note_given_back(task, message.reason, now_s)
        # Nobody else would find more there: nobody is hired before a station has it.
        self._withdraw(task, now_s)

    def _source_answers(self, task: OpenTask, now_s: float) -> bool:
        return self._sourcing.answers(task, now_s)

    def _is_missing(self, task: OpenTask) -> bool:
        return self._goods.lack(task)

    def _on_task_lost(self, task: OpenTask, now_s: float) -> None:
        """A task was withdrawn; what is needed in its place is made, or ordered, anew."""
        work = cast(Transport, task.work)
        if work.item in self._products:
            self._goods.lost(task, now_s)
        else:
            self._supply.settled(work, None)
        self._commit()
        self._heartbeat_timer.at_once(now_s)
        self._pursue(now_s)

    def _on_goal_short(self, goal: Goal | None, now_s: float) -> None:
        if goal is not None:
            # Its pieces may have arrived all the same: the gate has the last word.
            self._bidder.ask(goal, now_s)
        self._goals_changed(now_s)
        self._commit()

    def _on_docked(self, sender: str, message: Docked, now_s: float) -> None:
        if self._recovery.waits_for_word_on(message.task):
            self._out.append(Ignore(NOT_REMEMBERED))  # It asks again.
            return
        task = self._tasks.get(message.task)
        if task is not None and self._goods.lack(task):
            # Nothing would ever make them come: they are lost, and the books do not know.
            self._goods.recount(now_s)
        self._dock.on_docked(sender, message, now_s)
        task = self._tasks.get(message.task)
        if task is not None and now_s - task.contract.held_s > HELD_MAX_S:
            self._withdraw(task, now_s)

    def _withdraw(self, task: OpenTask, now_s: float) -> None:
        """Material that finds no room, or goods that are not there, keep a vehicle from whatever would help."""
        self._tasks.close(task, "withdrawn")
        self._on_task_lost(task, now_s)

    def _on_handover(self, sender: str, message: Handover, now_s: float) -> None:
        task = self._dock.on_handover(sender, message)
        if task is None:
            return
        if task.contract.receipt.said_s == NEVER_S:
            task.contract.receipt.said_s = now_s
        task.contract.receipt.said = message.quantity
        if not self._counts:
            self._book(task)
        self._receive(task, now_s)

    def _receive(self, task: OpenTask, now_s: float) -> None:
        """See what was counted of a load that its carrier says to be down."""
        if task.contract.receipt.said_s == NEVER_S:
            return
        goal = self._goals.get(cast(Transport, task.work).goal)
        verdict, counted = verdict_on(task, goal, self.id, now_s)
        if verdict is Verdict.WAITS:
            self._out.append(Ignore("a handover of a load that was not counted yet"))
            if goal is not None and goal.heard_s < task.contract.receipt.said_s:
                self._bidder.ask(goal, now_s)
            return
        carrier, work = task.primary, cast(Transport, task.work)
        if verdict is Verdict.SHORT or counted != task.contract.receipt.said:
            self._dispute(task, counted)
        if not counted:
            self._tasks.drop_uncounted(task, NOT_COUNTED, now_s)
            return
        self._dock.accept(task)
        if counted < work.quantity:
            self._tasks.reproach(carrier, task, NOT_COUNTED, now_s)
        self._settle_counted(task, carrier, counted, now_s)

    def _dispute(self, task: OpenTask, counted: int) -> None:
        work = cast(Transport, task.work)
        disputed = HandoverDisputed(
            task=task.id,
            epoch=task.epoch,
            contractor=task.primary,
            item=work.item,
            said=task.contract.receipt.said,
            counted=counted,
            where=work.destination,
        )
        self._out.append(Record(disputed))

    def _book(self, task: OpenTask) -> None:
        """The body does not count: it is told what the carrier says."""
        work = cast(Transport, task.work)
        comes = work.destination == self.id
        if not task.contract.receipt.booked and (comes or task.is_loaded):
            task.contract.receipt.booked = True
            change = task.contract.receipt.said if comes else -work.quantity
            self._out.append(Instruct(Book(vehicle=task.primary, item=work.item, change=change)))

    def _settle(self, task: OpenTask, now_s: float) -> None:
        """A transport was delivered, though its carrier has not said so."""
        self._settle_counted(task, "", cast(Transport, task.work).quantity, now_s)

    def _settle_counted(self, task: OpenTask, carrier: str, counted: int, now_s: float) -> None:
        """A transport was delivered, so many pieces of it."""
        self._probation.note_done()
        self._commit()
        work = cast(Transport, task.work)
        goal = self._goals.get(work.goal)
        if goal is not None:
            goal.deliver(carrier, work.quantity, min(counted, work.quantity))
            if counted < work.quantity:
                self._on_goal_short(goal, now_s)
        elif work.destination == self.id:
            self._supply.settled(work, now_s - task.opened_s)
        self._heartbeat_timer.at_once(now_s)
        self._pursue(now_s)

    # --- goals ---

    def _objection(self, sender: str, message: Message) -> str:
        return objection(sender, message, self._coordinator_of)

    def _coordinator_of(self, task: str, _role: Role) -> str:
        """Who has given it a goal; empty where it has no such goal."""
        goal = self._goals.get(task)
        return "" if goal is None else goal.strategist

    def _unfit(self) -> str:
        """Why it takes no goals at all; empty when it does."""
        return self._problem or (GRACEFUL_SHUTDOWN if self._shutdown.begun else "")

    def _on_award(self, sender: str, message: Award, now_s: float) -> None:
        if self._bidder.on_award(sender, message, self._unfit(), now_s):
            self._goals_changed(now_s)

    def _on_confirmed(self, _sender: str, message: Confirmed, now_s: float) -> None:
        if self._bidder.on_confirmed(message, now_s):
            self._goals_changed(now_s)
        else:
            self._out.append(Ignore("confirmed twice"))
        self._receive_all(message.task, now_s)

    def _receive_all(self, goal: str, now_s: float) -> None:
        """The gate's count of a goal is known anew: carriers may wait for it."""
        for task in list(self._tasks):
            if cast(Transport, task.work).goal == goal:
                self._receive(task, now_s)

    def _on_goal_over(self, _sender: str, message: Release | Withdrawn, now_s: float) -> None:
        self._end_goal(self._bidder.on_over(message), now_s)

    def _on_goal_closed(self, _sender: str, message: GoalClosed, now_s: float) -> None:
        self._end_goal(self._bidder.on_closed(message), now_s)

    def _end_goal(self, goal: Goal | None, now_s: float) -> None:
        if goal is None:
            self._out.append(Ignore("the end of a goal that has ended"))
            return
        self._goods.keep_unwanted()
        self._goals_changed(now_s)
        self._receive_all(goal.id, now_s)

    def _goals_changed(self, now_s: float) -> None:
        self._supply.goals_changed()
        self._pursue(now_s)
        self._heartbeat_timer.at_once(now_s)


def _introduction(spec: MachineSpec) -> JoiningMachine:
    return JoiningMachine(
        name=spec.name,
        station=spec.station,
        node=spec.node,
        x_m=spec.box.x_m,
        y_m=spec.box.y_m,
        width_m=spec.box.width_m,
        depth_m=spec.box.depth_m,
        makes=tuple(Making(making.product, making.cycle_s) for making in spec.makes),
        goods_capacity=spec.goods_capacity,
    )
