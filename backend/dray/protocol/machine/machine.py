"""A production machine: makes goals, orders its own material, has its products carried away (paper, 3.2).

It is a contractor of the strategist, for whose goals it bids (`goal_bidding`), and the coordinator of all its
transports (`transports`, `dock`). It watches its buffers (`supply`). After every change `pursue` starts the next
cycle, orders low material, has finished goods fetched, and reports the state.

A machine that is asked to leave takes no goal and opens no new task. It stays while an answer may come, or a
vehicle is at its dock. It keeps its goals if its next life speaks within GOAL_SILENCE_S
(`strategist.machine_monitor`); the body goes on with its cycle meanwhile.
"""

from __future__ import annotations

from typing import cast

from dray.body import (
    BodyState,
    Broken,
    CycleDone,
    CycleFailed,
    DockReady,
    DocumentRead,
    Repaired,
    StockChanged,
    WordTaken,
    WorkcellState,
)
from dray.errors import ProtocolViolation
from dray.memory import WHOLE, MachineMemory, Memory, Note
from dray.messages import (
    Award,
    Confirmed,
    Disbelieved,
    GoalClosed,
    GoalRevised,
    MachineCommand,
    Message,
    Release,
    TaskAnnounced,
    Transport,
    Withdrawn,
    WorkSought,
)
from dray.messages.keys import Keys
from dray.plant import Plant
from dray.protocol.calls.help_calls import NotComing
from dray.protocol.closures.known_floor import KnownFloor
from dray.protocol.contract_net.auction_rules import AuctionRules
from dray.protocol.contract_net.changes import TaskDelivered, TaskLost
from dray.protocol.contract_net.parties import objection
from dray.protocol.contract_net.trust.disbelief import DisbeliefHandling
from dray.protocol.contract_net.trust.probation import Probation
from dray.protocol.liveness.suspicion import interval_s
from dray.protocol.machine.closed_in import ClosedIn, WaysChanged
from dray.protocol.machine.cycle import WORKING_TIME, Cycle
from dray.protocol.machine.documents import GoalDocuments
from dray.protocol.machine.finished_goods import GoodsLost
from dray.protocol.machine.goal_bidding import GoalBidder
from dray.protocol.machine.material_flow import MaterialFlow
from dray.protocol.machine.people.breakdown import PATIENCE_OVER, Breakdown
from dray.protocol.machine.people.command_handling import MachineCommandHandling
from dray.protocol.machine.people.goal_sharing import GoalSharing
from dray.protocol.machine.production import Goal, GoalBook
from dray.protocol.machine.promises import Promises
from dray.protocol.machine.status_report import StatusReport, introduction
from dray.protocol.machine.supply import Supply
from dray.protocol.people.command_authorisation import CommandAuthorisation
from dray.protocol.runtime.agent import AgentBase
from dray.protocol.runtime.events import Leave
from dray.protocol.runtime.life import BEAT
from dray.protocol.runtime.running import ALONE, Running
from dray.protocol.runtime.shutdown import COORDINATOR_LEAVES_WITHIN_S
from dray.protocol.runtime.trust import Trusts, trusts_nobody
from dray.protocol.traffic.reservations.reservation_handling import CarriedAway, ReservationHandling
from dray.protocol.traffic.traffic_map import TrafficMap
from dray.protocol.transports.carrier_waits import docks_heard
from dray.protocol.transports.handovers import CountMissed
from dray.protocol.transports.issuing import ReservationsChanged
from dray.protocol.transports.transport_flow import MaterialChanged


class Machine(AgentBase):
    """One production machine.

    Args:
        machine: its id in the plant.
        plant: the plant it stands in.
        incarnation: how often it has been started.
        software: the version it runs, for its heartbeat.
        joining: whether others' plant files lack it: it then publishes its own data and position.
        probation: transports to or from it that must be done well before it takes long goals; 0 for a known good
            machine.
        rules: time-outs and radius of its auctions.
        traffic: of the plant; None if vehicles drive without right of way.
        trusts: the trusted signers of people's removals and commands.
        running: what its operator can do with its agent's process.
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
        traffic: TrafficMap | None = None,
        trusts: Trusts = trusts_nobody,
        running: Running = ALONE,
    ) -> None:
        super().__init__(machine, incarnation, leaves_within_s=COORDINATOR_LEAVES_WITHIN_S)
        self._plant = plant = KnownFloor(plant)
        self._closures = ClosedIn(machine, plant, trusts, self._life)
        self._spec = plant.machines[machine]
        self._keys = Keys(plant.id)
        self._goals = GoalBook(machine, plant)
        self._supply = Supply(machine, plant, self._goals)
        self._probation = Probation(probation)
        self._promises = Promises(self._goals, self._supply, self._life)
        self._bidder = GoalBidder(self._goals, self._supply, self._probation, self._life)
        self._flow = MaterialFlow(
            machine,
            plant,
            self._keys,
            self._goals,
            self._supply,
            rules or AuctionRules(),
            self._life,
            self._shutdown,
            tells_node=joining,
        )
        self._documents = GoalDocuments(self._goals, self._life)
        self._cycle = Cycle(self._goals, self._supply, self._documents, self._life)
        self._breakdown = Breakdown(plant, self._goals, self._life)
        authority, goods = CommandAuthorisation(machine, plant, trusts), self._flow.goods_recovery
        held = self._flow.held
        self._commands = MachineCommandHandling(
            authority, self._breakdown, self, goods, held, running, self._life
        )
        parts = (self._goals, self._supply, self._flow, self._breakdown)
        self._sharing = GoalSharing(*parts, self._commands.service, self._closures)
        self._message_handlers = {
            **self._flow.message_handlers,
            TaskAnnounced: lambda _from, said, now_s: self._bidder.on_announced(
                said, self._unfit(said), now_s
            ),
            Award: self._on_award,
            Confirmed: self._on_confirmed,
            Release: lambda _from, said, now_s: self._end_goal(self._bidder.on_over(said), now_s),
            Withdrawn: lambda _from, said, now_s: self._end_goal(self._bidder.on_over(said), now_s),
            GoalClosed: lambda _from, said, now_s: self._end_goal(self._bidder.on_closed(said), now_s),
            GoalRevised: self._on_revised,
            **self._bidder.message_handlers,
            WorkSought: self._on_sought,
            MachineCommand: self._on_command,
            **self._breakdown.message_handlers,
            **self._closures.message_handlers,
            Disbelieved: DisbeliefHandling(self._life).on_disbelieved,
        }
        self._docks = (
            () if traffic is None else docks_heard(machine, plant.materials_of(machine), plant, self._keys)
        )
        self._reservation_handling = ReservationHandling(
            machine, plant, traffic, trusts, self._flow.subscriptions, self._life
        )
        self._message_handlers = self._reservation_handling.handlers(self._message_handlers)
        self._committers += [*self._reservation_handling.committers, self._flow.called.commits]
        self._report = StatusReport(
            software,
            introduction(self._spec) if joining else None,
            self._keys,
            self._goals,
            self._supply,
            self._flow,
            self._cycle,
            self._documents,
            self._breakdown,
            self._commands,
            self._probation,
            self._reservation_handling,
            self._life,
            self._shutdown,
        )
        self._report_handlers = {
            CycleDone: self._cycle_done,
            CycleFailed: self._cycle_failed,
            StockChanged: self._stock_changed,
            DockReady: self._flow.on_dock_ready,
            Broken: self._broken,
            Repaired: self._repaired,
            WordTaken: self._word_taken,
            DocumentRead: self._document_read,
        }
        self._reactions = {
            **self._flow.reactions,
            TaskLost: self._on_lost,
            TaskDelivered: self._on_delivered,
            CountMissed: self._on_count_missed,
            NotComing: lambda change, _now_s: self._breakdown.not_coming(change.since_s),
            GoodsLost: lambda lost, now_s: self._miss_goods(lost.goal, now_s),
            ReservationsChanged: lambda _change, now_s: self._flow.note_stock(now_s),
            CarriedAway: lambda carried, _now_s: self._flow.on_carried_away(carried.vehicle),
            MaterialChanged: lambda _change, now_s: self.pursue(now_s),
            WaysChanged: lambda _change, now_s: self.pursue(now_s),
        }
        self._alarm_handlers = {
            BEAT: self._beat,
            **dict.fromkeys((PATIENCE_OVER, WORKING_TIME), lambda _about, now_s: self._changed(now_s)),
            **self._breakdown.alarms,
            **self._closures.alarms,
            **self._bidder.alarms,
            **self._documents.alarms,
            **self._flow.alarms,
            **self._reservation_handling.alarms,
        }

    # --- the beginning, and time passing ---

    def _start(self, body: BodyState | None, memory: Memory, now_s: float) -> None:
        if not isinstance(body, WorkcellState):
            raise ProtocolViolation(f"{self.id}: a machine needs a workcell, not {body!r}")
        note = memory.get(WHOLE)
        if isinstance(note, MachineMemory):
            self._goals.products.restore(note.products)
        self._flow.take_count(body)
        self._cycle.product = body.cycling
        self._commands.paces = body.paces
        self._commands.sense(body)
        if isinstance(note, MachineMemory):
            self._restore(note, memory, now_s)
        elif body.let_in is not None and not body.counts:
            self._flow.follow_unnoted(body.let_in, self.incarnation)
        self._flow.shut_unknown(body.opened)
        self._flow.dismiss(body.gone)
        if isinstance(note, MachineMemory):
            self._breakdown.start(body, note.help, note.problem, now_s)
        else:
            self._breakdown.start(body, None, None, now_s)
        self._flow.goods.count()
        for each in (*self._goals.products.own, self.id):
            self._life.subscribe(self._keys.goals(each))
        self._life.subscribe(self._keys.all_free)
        self._life.do(*self._docks)
        self._closures.listen()
        if self.incarnation > 1:
            self._flow.recover(note is None, now_s)
        self._reservation_handling.start(memory, now_s, dock_answers=self._flow.visits.answers)
        self._life.beat_soon(now_s)
        self.pursue(now_s)

    def _restore(self, memory: MachineMemory, notes: Memory, now_s: float) -> None:
        """Continue an earlier life's contracts."""
        for booked in memory.goals:
            # The machine goes on with them: the strategist may be away, and the gate knows what may still
            # come in.
            self._bidder.ask(self._goals.restore(booked), now_s)
        self._supply.goals_changed()
        self._flow.restore(memory, notes, now_s)
        self._commands.restore(memory)
        self._promises.note()
        # Tasks without a carrier have a higher epoch now, which no later life may reuse.
        self._life.commit()

    def _memory(self) -> Note:
        return MachineMemory(
            goals=self._goals.memories(),
            tasks=tuple(task.memory() for task in self._flow.tasks),
            task_count=self._flow.task_count,
            help=self._breakdown.help,
            out_of_service=self._commands.service.out,
            speed_frac=self._goals.speed_frac,
            answered=self._commands.answered,
            products=self._goals.products.memories(self._supply.level),
            put_away=self._flow.put_away.memories(),
            put_away_count=self._flow.put_away.count,
            visits=self._flow.visits.memories(),
            booked=self._flow.bookings.memories(),
            problem=self._breakdown.memory,
            doubts=self._flow.visits.doubts.memories(),
        )

    def _sense(self, body: BodyState | None, now_s: float) -> None:
        if isinstance(body, WorkcellState) and self._commands.sense(body):
            self._life.beat_soon(now_s)
        if not isinstance(body, WorkcellState) or self._cycle.product not in ("", body.cycling):
            return  # The body may not have heard of the cycle yet, whose material is already subtracted here.
        if self._supply.sense(body.stock, body.seq):
            self.pursue(now_s)

    def _beat(self, _about: None, now_s: float) -> None:
        expected = not self._shutdown.begun
        self._flow.goods_recovery.update_calls(self._breakdown.calls, now_s, expected=expected)
        self._life.beat_again(interval_s(self._report.say(now_s)), now_s)

    def _was_deaf(self, span_s: float) -> None:
        self._flow.subscriptions.arrivals.deaf_s += span_s

    # --- the end ---

    def _prepare_to_leave(self, now_s: float) -> None:
        self._flow.drop_needs()
        self._breakdown.update_call(now_s, expected=False)
        self._life.beat_soon(now_s)

    def _is_held(self) -> bool:
        return self._flow.is_held

    def _take_leave(self, now_s: float) -> None:
        self._report.say(now_s)

    def _cycle_done(self, report: CycleDone, now_s: float) -> None:
        self._cycle.done(report.product, report.seq, bad=report.bad)
        self.pursue(now_s)

    def _cycle_failed(self, _report: CycleFailed, now_s: float) -> None:
        # The next heartbeat corrects the stock by the senses; then the cycle is tried again.
        self._cycle.failed()
        self._life.beat_soon(now_s)

    def _stock_changed(self, report: StockChanged, now_s: float) -> None:
        is_news = self._supply.change(report.item, report.change, report.seq)
        word = self._flow.note_booked(report)
        if not self._goals.products.is_goods(report.item):
            self._flow.on_material(report, word, now_s)
        else:
            self._flow.on_goods(report, word, is_news, now_s)
            self._life.commit()
        self.pursue(now_s)

    def _word_taken(self, report: WordTaken, _now_s: float) -> None:
        if (word := self._commands.words.on_taken(report)) is not None:
            self._flow.held.on_word(word)

    def _document_read(self, report: DocumentRead, now_s: float) -> None:
        if self._documents.on_read(report):
            self.pursue(now_s)

    def _broken(self, report: Broken, now_s: float) -> None:
        self._breakdown.on_broken(report, now_s)
        self._changed(now_s)

    def _repaired(self, _report: Repaired, now_s: float) -> None:
        self._breakdown.on_repaired(now_s)
        self._changed(now_s)

    def _on_command(self, sender: str, command: MachineCommand, now_s: float) -> None:
        speed_frac = self.speed_frac
        self._commands.on_command(sender, command, self._plant.position_of(self.id), now_s)
        if self.speed_frac != speed_frac:
            self._promises.review(now_s)
        self._changed(now_s)

    def _changed(self, now_s: float) -> None:
        """Store a new state, act on it, and publish it."""
        self._life.commit()
        self.pursue(now_s)
        self._life.beat_soon(now_s)

    @property
    def speed_frac(self) -> float:
        """Speed as a fraction of its full speed."""
        return self._goals.speed_frac

    @speed_frac.setter
    def speed_frac(self, speed_frac: float) -> None:
        self._goals.speed_frac = speed_frac
        self._supply.goals_changed()

    def leave(self, now_s: float, *, update: bool) -> None:
        """Shut down gracefully for a restart."""
        self._last_word = Leave(again=True, update=update)
        self._on_leaving(now_s)

    def pursue(self, now_s: float) -> None:
        """Do what the present state requires."""
        shared = self._sharing.decide(now_s)
        in_service = self._commands.service.out is None and not self._shutdown.begun
        self._breakdown.update_call(now_s, expected=in_service)
        self._cycle.look(now_s)
        self._cycle.share_spare()
        self._flow.cycling = self._cycle.product
        self._flow.note_stock(now_s)
        self._documents.update(now_s)
        if not self._breakdown.problem:
            self._cycle.start(self._flow.goods.has_room_for)
        self._flow.cycling = self._cycle.product
        if not self._shutdown.begun:
            self._flow.announce_needs(self._cycle.product, now_s)
        if shared:
            self._promises.review(now_s)
        self._report.update(now_s)

    # --- what follows from changes ---

    def _on_lost(self, lost: TaskLost, now_s: float) -> None:
        work = cast(Transport, lost.task.work)
        if work.destination == self.id:
            self._supply.settled(work, None)
        else:
            self._miss_goods(self._flow.goods.lost(lost.task), now_s)
        self._flow.on_lost(lost, now_s)
        self.pursue(now_s)

    def _on_delivered(self, delivered: TaskDelivered, now_s: float) -> None:
        self._probation.note_done()
        if (short := self._flow.book_delivered(delivered, now_s)) is not None:
            self._miss_goods(short, now_s)
        self._flow.on_delivered(delivered, now_s)
        self.pursue(now_s)

    def _on_count_missed(self, missed: CountMissed, now_s: float) -> None:
        goal = self._goals.get(missed.goal)
        if goal is not None:
            self._bidder.ask(goal, now_s)

    def _miss_goods(self, goal: Goal | None, now_s: float) -> None:
        """Pieces of a goal are lost or missing."""
        if goal is not None:
            # They may have arrived all the same: the gate decides.
            self._bidder.ask(goal, now_s)
        self._goals_changed(now_s)
        self._life.commit()

    def _on_sought(self, sender: str, message: WorkSought, now_s: float) -> None:
        if not self._shutdown.begun:
            self._flow.offer(sender, message, now_s)

    # --- goals ---

    def _objection(self, sender: str, message: Message) -> str:
        return objection(sender, message, self._bidder.coordinator_of)

    def _unfit(self, asked: TaskAnnounced | Award) -> str:
        """Why it takes no goals; empty if it does."""
        out = "out of service" if self._commands.service.out is not None else ""
        why = self._breakdown.problem or out or ("draining" if self._shutdown.begun else "")
        return why or self._closures.objection(asked.deadline_s)

    def _on_award(self, sender: str, message: Award, now_s: float) -> None:
        if self._bidder.on_award(sender, message, self._unfit(message), now_s):
            self._goals_changed(now_s)

    def _on_confirmed(self, _sender: str, message: Confirmed, now_s: float) -> None:
        if self._bidder.on_confirmed(message, now_s):
            self._goals_changed(now_s)
        else:
            self._life.ignore("a second confirmation of one contract")
        self._flow.on_goal_counted(message.task, now_s)

    def _on_revised(self, sender: str, message: GoalRevised, now_s: float) -> None:
        if self._bidder.on_revised(sender, message, self._cycle.goal):
            self._goals_changed(now_s)

    def _end_goal(self, goal: Goal | None, now_s: float) -> None:
        if goal is None:
            self._life.ignore("a second end of one goal")
            return
        self._flow.goods.keep_unwanted()
        self._goals_changed(now_s)
        self._flow.on_goal_counted(goal.id, now_s)

    def _goals_changed(self, now_s: float) -> None:
        self._supply.goals_changed()
        self.pursue(now_s)
        # Ended goals' spare pieces belong to the next ones by now.
        self._promises.review(now_s)
        self._life.beat_soon(now_s)
