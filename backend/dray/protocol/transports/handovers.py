"""The handovers of a coordinator's transports: carriers' reports, counts, and their differences."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import cast

from dray.body import StockChanged
from dray.memory import DepartureMemory
from dray.messages import AtvHeartbeat, Handover, Reason, Transport
from dray.messages.fact import HandoverDisputed
from dray.messages.heartbeat import GOODS_ABOARD
from dray.protocol.contract_net.changes import TaskDelivered
from dray.protocol.contract_net.task import OpenTask
from dray.protocol.contract_net.task_state import TaskState
from dray.protocol.runtime.events import NEVER_S
from dray.protocol.runtime.life import Change, Life
from dray.protocol.transports.bookings import Bookings
from dray.protocol.transports.dock import Dock
from dray.protocol.transports.receiving import GateCount, Verdict, verdict_on
from dray.protocol.transports.transports import Transports

DISPUTES_MAX = 2
"""Maximum disputed handovers of one load. One may be a lie or a dirty sensor; after two another load would be lost too."""


@dataclass(frozen=True, slots=True)
class CountMissed(Change):
    """A carrier's report is newer than the gate's count of its goal, which may have grown."""

    goal: str


class Handovers:
    """Compares carriers' reports with the counts (`receiving`), and ends their transports.

    Args:
        place: the coordinator's place.
        tasks: its open transports.
        goal_of: the gate's count of a goal, by its name; None if no goal wants it.
        dock: the coordinator's dock.
        bookings: reports to a body that does not count.

    Attributes:
        counts: whether the coordinator's body counts loads; otherwise it is told the carriers' reports.
    """

    def __init__(
        self,
        place: str,
        tasks: Transports,
        goal_of: Callable[[str], GateCount | None],
        dock: Dock,
        bookings: Bookings,
        life: Life,
    ) -> None:
        self._place = place
        self._tasks = tasks
        self._goal_of = goal_of
        self._dock, self._bookings = dock, bookings
        self._life = life
        self.counts = True

    def on_handover(self, sender: str, message: Handover, now_s: float) -> None:
        """A carrier reports its load as down."""
        task = self._dock.on_handover(sender, message)
        if task is None:
            return
        if task.contract.receipt.said_s == NEVER_S:
            task.contract.receipt.said_s = now_s
        task.contract.receipt.said = message.quantity
        # That it carries a recovered task is known from its carrier alone.
        if not self.counts and (not task.recovered or self._dock.may_have_brought(task)):
            self._book(task)
        self._judge(task, now_s)

    def on_stock_changed(self, report: StockChanged, word: DepartureMemory | None, now_s: float) -> None:
        """The body has counted or booked a vehicle's material.

        Args:
            report: the body's report.
            word: the report that the body answers. A body that does not count knows of no other load.
            now_s: the present time.
        """
        for task in list(self._tasks):
            if not self.counts and (word is None or (word.task, word.epoch) != (task.id, task.epoch)):
                if word is not None and self._has_come(task, word):
                    self._tasks.conclude_for(task, word.vehicle)
                    self._life.settle(now_s)
                continue
            if report.vehicle and task.primary == report.vehicle and task.work_item == report.item:
                task.contract.receipt.counted += max(report.change, 0)
                if task.contract.receipt.counted and not task.is_counted:
                    task.states.enter(TaskState.COUNTED)
                self._judge(task, now_s)
                self._life.settle(now_s)

    def on_carrier_heard(self, heartbeat: AtvHeartbeat) -> None:
        """A vehicle may have left with goods: tell a body that does not count."""
        carries = heartbeat.task
        if self.counts or carries is None or carries.phase not in GOODS_ABOARD:
            return
        for task in self._tasks:
            if (task.id, task.primary) == (carries.task, heartbeat.atv) and not self._comes(task):
                self._book(task)

    def on_goal_counted(self, goal: str, now_s: float) -> None:
        """The gate's count of a goal was updated: carriers may wait for it."""
        for task in list(self._tasks):
            if cast(Transport, task.work).goal == goal:
                self._judge(task, now_s)
                self._life.settle(now_s)

    # --- internals ---

    def _judge(self, task: OpenTask, now_s: float) -> None:
        """Compare the count of a load with its carrier's report."""
        receipt = task.contract.receipt
        if receipt.said_s == NEVER_S:
            return
        name = cast(Transport, task.work).goal
        goal = self._goal_of(name)
        verdict, counted = verdict_on(task, goal, self._place, now_s)
        if verdict is Verdict.WAITS:
            self._life.ignore("a handover of a load that was not counted yet")
            if goal is not None and goal.heard_s < receipt.said_s:
                self._life.note(CountMissed(name))
            return
        carrier, work = task.primary, cast(Transport, task.work)
        if verdict is Verdict.SHORT or counted != receipt.said:
            self._dispute(task, counted)
        if not counted:
            self._count_dispute(task, goal, now_s)
            return
        if goal is not None:
            goal.disputes = 0
        self._dock.accept(task)
        if counted < work.quantity:
            self._tasks.reliability.note_dropped(carrier, task.id, Reason.NOT_COUNTED, now_s)
        self._life.note(TaskDelivered(task, carrier, counted))

    def _count_dispute(self, task: OpenTask, goal: GateCount | None, now_s: float) -> None:
        """No piece of a load was counted: seek another carrier, or a person to look."""
        task.disputes += 1
        task.disputed_by += (task.primary,)
        disputes = task.disputes
        if goal is not None and task.is_loaded:
            # Its next load is another task.
            goal.disputes += 1
            disputes = max(disputes, goal.disputes)
        if disputes < DISPUTES_MAX:
            self._tasks.failover.replace(task, Reason.NOT_COUNTED, now_s)
            return
        self._tasks.failover.blame(task, Reason.NOT_COUNTED, now_s)
        self._tasks.hold(task, now_s)

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
        self._life.record(disputed)

    def _has_come(self, task: OpenTask, word: DepartureMemory) -> bool:
        """Whether an earlier carrier has brought a task's load, and the present one has no other on board.

        A second load comes as surplus: it is booked if there is room, and taken back if there is none.
        """
        is_it = (word.task, word.item) == (task.id, task.work_item) and word.epoch < task.epoch
        is_it &= self._comes(task)
        is_whole = word.change >= cast(Transport, task.work).quantity
        other = task.contract.phase in GOODS_ABOARD or task.is_loaded or task.is_counted
        is_disputed = task.is_held and task.perhaps_down is None and not task.fails_at
        return is_it and is_whole and not other and not is_disputed

    def _comes(self, task: OpenTask) -> bool:
        return cast(Transport, task.work).destination == self._place

    def _book(self, task: OpenTask) -> None:
        """Tell a body that does not count of the carrier's report, once."""
        work, comes = cast(Transport, task.work), self._comes(task)
        # Goods that a person has handed over were booked out before, with their first carrier.
        if not task.contract.receipt.booked and (comes or not work.handed_at):
            task.contract.receipt.booked = True
            # A vehicle brings at most what it was given: more is disputed.
            change = min(task.contract.receipt.said, work.quantity) if comes else -work.quantity
            self._bookings.say(DepartureMemory(task.primary, task.id, task.epoch, work.item, change))
