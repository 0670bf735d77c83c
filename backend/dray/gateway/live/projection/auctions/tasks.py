"""Tasks as panels see them: every auction, from the announcement to the end.

The coordinator's facts are the truth about a task. A contractor's facts add refusals and the transport's
progress. Facts of different agents may overtake one another, so a contractor's fact about an unopened task is
kept for a while. Facts of an epoch that is over are ignored.
"""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Callable, Iterable
from typing import Any

from msgspec import UNSET

from dray.gateway.live.projection.auctions.bids import add_bid, add_refusal, last_bid, note_award
from dray.gateway.live.projection.auctions.why import why_of
from dray.gateway.live.projection.changes import Changes
from dray.gateway.live.projection.figures.transports import Transports
from dray.gateway.live.reasons import failures_of, trouble_of
from dray.gateway.live.views import CarrierView, StrandedView, TaskView
from dray.messages import (
    Event,
    MachineHeartbeat,
    Production,
    Reason,
    Refusal,
    Role,
    StationHeartbeat,
    TaskBrief,
    Transport,
)
from dray.messages.fact import (
    AwardAnswered,
    AwardGiven,
    BidReceived,
    BidRefused,
    CarrierChanged,
    ContractEnded,
    ContractTaken,
    GoalWaits,
    PhaseEntered,
    RoundFailed,
    TaskClosed,
    TaskOpened,
    TookOver,
    WatchLost,
)
from dray.messages.heartbeat import GOODS_ABOARD
from dray.store.history.clocks import ToWall

CLOSED_KEPT = 50
"""Ended tasks that panels still show; the events have the whole history."""

MAX_OPEN = 5_000
"""Maximum open tasks: five per vehicle of the largest plant. The oldest leaves first."""

MAX_OPEN_EACH = 1_000
"""Maximum open tasks per coordinator: many times what a machine's buffers or a strategist's products can ask
for."""

MAX_BOUND = 10_000
"""Maximum contractors whose contract is remembered: as many as vehicles."""


EARLY_KEPT = 512
"""Facts kept: some seconds of a plant of 1,000 vehicles."""


MAX_CARRIERS = 16
"""Maximum carrier changes kept per task, newest last: more than a person watches happen."""


def reopen_task(task: TaskView) -> None:
    """Mark a task as open for bids again, in a new epoch."""
    task.trouble = None
    task.state, task.primary, task.phase, task.source = "bidding", "", "", ""
    task.contracted_at_s = task.promised_at_s = None


def give_to(task: TaskView, carrier: str, epoch: int) -> None:
    """Give a task to another carrier."""
    if carrier != task.primary:
        # The previous carrier's promise no longer binds anybody.
        task.phase, task.promised_at_s = "", None
    task.epoch, task.primary, task.state = epoch, carrier, "contracted"
    if task.secondary == carrier:
        task.secondary = ""


def add_carrier(task: TaskView, carrier: CarrierView) -> None:
    """Add a line to the list of carriers, which has one per epoch."""
    others = [other for other in task.carriers if other.epoch != carrier.epoch]
    task.carriers = (*others[1 - MAX_CARRIERS :], carrier)


def undo_takeover(task: TaskView, event: Event, fact: ContractEnded) -> bool:
    """Undo a takeover that the coordinator has refused: the carrier before it still carries.

    Returns:
        False when the ended contract is not of that kind.
    """
    last = task.carriers[-1] if task.carriers else None
    if last is None or last.confirmed or (last.carrier, last.epoch) != (event.agent, fact.epoch):
        return False
    if fact.reason == Reason.HANDED_OVER:
        return False
    task.carriers = task.carriers[:-1]
    before = task.carriers[-1] if task.carriers else None
    if before is None or not before.carrier:
        reopen_task(task)
    else:
        task.primary, task.phase = before.carrier, ""
    task.epoch = fact.epoch - 1 if before is None else before.epoch
    return True


def stranded_of(brief: TaskBrief, order: tuple[str, str], to_wall_s: ToWall) -> StrandedView | None:
    """A coordinator's word on goods that wait for a person, with the id and name of their order."""
    goods = brief.stranded
    if goods is UNSET:
        return None
    until_at_s = to_wall_s(goods.until_s)
    return StrandedView(
        atv=goods.atv,
        node=goods.node,
        until_at_s=until_at_s,
        handed_at=goods.handed_at,
        order=order[0],
        order_name=order[1],
    )


class ReorderBuffer:
    """Facts that came before their task, oldest first; when full, the oldest leaves."""

    def __init__(self) -> None:
        self._events: deque[Event] = deque(maxlen=EARLY_KEPT)

    def keep(self, event: Event) -> None:
        """Keep a fact until its task is opened."""
        self._events.append(event)

    def take(self, task: str) -> list[Event]:
        """Remove and return the facts of a task that was just opened."""
        taken = [event for event in self._events if task_of(event) == task]
        if taken:
            self._events = deque((event for event in self._events if event not in taken), maxlen=EARLY_KEPT)
        return taken


def task_of(event: Event) -> str:
    """The task of a fact, if any; a goal is the task that gives it out."""
    fact = event.fact
    name: str = fact.goal if isinstance(fact, GoalWaits) else getattr(fact, "task", "")
    return name


class Tasks:
    """The tasks.

    Args:
        to_wall_s: plant clock to wall clock.
        order_of: the id of a goal's order, and the order's name for people.
    """

    def __init__(self, to_wall_s: ToWall, order_of: Callable[[str], tuple[str, str]]) -> None:
        self._to_wall_s, self._order_of = to_wall_s, order_of
        self._open: dict[str, TaskView] = {}
        self._opened_by: Counter[str] = Counter()
        """Open tasks per coordinator."""
        self._closed: dict[str, TaskView] = {}
        """Oldest first."""
        self._reorder_buffer = ReorderBuffer()
        self._bound: dict[str, tuple[str, str]] = {}
        """Per contractor that carries something, by its own word: the task and its coordinator."""
        self._lives: dict[str, int] = {}
        """Per open task, the incarnation of the coordinator that announced it last."""
        self._unexplained: set[str] = set()
        """Tasks that changed since `why` was computed."""
        self._on: dict[type, Callable[[TaskView, Event, Any], bool]] = {
            BidReceived: lambda task, _event, fact: add_bid(task, fact, to_wall_s),
            BidRefused: add_refusal,
            AwardGiven: note_award,
            AwardAnswered: self._answer,
            RoundFailed: _failed,
            WatchLost: _watch_lost,
            CarrierChanged: self._carrier_changed,
            TookOver: self._took_over,
            ContractTaken: self._taken,
            ContractEnded: undo_takeover,
            PhaseEntered: _phase,
            GoalWaits: _waits,
        }
        self.heeded = (TaskOpened, TaskClosed, *self._on)
        """Kinds of facts about tasks."""
        self.changes, self.transports = Changes("task"), Transports()

    def fold(self, event: Event) -> bool:
        """Take an event in.

        Returns:
            False when it says nothing new about a task.
        """
        fact = event.fact
        if isinstance(fact, ContractTaken | ContractEnded) and fact.role is Role.PRIMARY:
            self._note_bound(event.agent, fact)
        if isinstance(fact, TaskOpened):
            return self._opened(event, fact)
        if isinstance(fact, TaskClosed):
            return self._ended(event, fact)
        handler = self._on.get(type(fact))
        if handler is None:
            return False
        name = task_of(event)
        task = self._open.get(name)
        if task is None:
            if name not in self._closed:
                self._reorder_buffer.keep(event)
            return False
        if not handler(task, event, fact):
            return False
        self._mark(name)
        return True

    def on_heartbeat(self, heartbeat: MachineHeartbeat | StationHeartbeat) -> None:
        """Take in a machine's or station's report of its open tasks."""
        for brief in heartbeat.tasks:
            task = self._open.get(brief.task)
            if task is None:
                continue
            self._recovered(task, brief, heartbeat)
            trouble = trouble_of(brief)
            stranded = stranded_of(brief, self._order_of(task.goal), self._to_wall_s)
            if (trouble, stranded, brief.fails_at) != (task.trouble, task.stranded, task.fails_at):
                task.trouble, task.stranded, task.fails_at = trouble, stranded, brief.fails_at
                self._mark(task.id)

    def view(self, task: str) -> TaskView | None:
        """One task, open or lately ended."""
        view = self._open.get(task) or self._closed.get(task)
        if view is not None and task in self._unexplained:
            # Computed here, not per fact: of twenty bids between two looks only the last counts.
            self._unexplained.discard(task)
            view.why = why_of(view)
            view.goods_aboard = bool(view.goal) and view.phase in GOODS_ABOARD
        return view

    def under_way(self) -> Iterable[TaskView]:
        """The open tasks; their `why` may be out of date."""
        return self._open.values()

    def views(self, most: int | None = None) -> tuple[TaskView, ...]:
        """The open tasks and the last ended ones; only the first `most` if given."""
        return tuple(view for name in self.ids()[:most] if (view := self.view(name)) is not None)

    def ids(self) -> tuple[str, ...]:
        """The ids of the open tasks and the last ended ones."""
        return (*self._open, *self._closed)

    def take_changed(self, most: int | None = None) -> tuple[TaskView, ...]:
        """Tasks that changed since the last call; only the first `most` if given."""
        return tuple(task for name in self.changes.take_changed(most) if (task := self.view(name)))

    def _leave(self, task: TaskView) -> None:
        """Count a task as open no more."""
        self._opened_by[task.coordinator] -= 1
        if not self._opened_by[task.coordinator]:
            del self._opened_by[task.coordinator]

    def _mark(self, task: str) -> None:
        self.changes.mark(task)
        self._unexplained.add(task)

    def _forget(self, task: str) -> None:
        self._unexplained.discard(task)
        self.changes.drop(task)

    def _note_bound(self, agent: str, fact: ContractTaken | ContractEnded) -> None:
        """Remember a contractor's coordinator, to name it when the contractor is busy."""
        if isinstance(fact, ContractTaken):
            if agent in self._bound or len(self._bound) < MAX_BOUND:
                self._bound[agent] = (fact.task, fact.coordinator)
        elif self._bound.get(agent, ("", ""))[0] == fact.task:
            del self._bound[agent]

    # --- the coordinator's facts ---

    def _opened(self, event: Event, fact: TaskOpened) -> bool:
        if fact.task in self._closed:
            return False
        task = self._open.get(fact.task)
        if task is None:
            self._born(event, fact)
            return True
        if fact.role is Role.SECONDARY or fact.epoch < task.epoch:
            return False
        if fact.epoch > task.epoch:
            reopen_task(task)
        elif fact.round <= task.round:
            # A duplicate, or overtaken by its own result.
            return False
        task.epoch, task.round, task.radius_m = fact.epoch, fact.round, fact.radius_m
        task.deadline_at_s = self._to_wall_s(fact.deadline_s)
        self._lives[task.id] = event.incarnation
        self._mark(task.id)
        return True

    def _born(self, event: Event, fact: TaskOpened) -> None:
        is_greedy = self._opened_by[event.agent] >= MAX_OPEN_EACH
        if is_greedy or len(self._open) >= MAX_OPEN:
            # A coordinator with too many open tasks pushes out its own.
            own = (name for name, each in self._open.items() if each.coordinator == event.agent)
            oldest = next(own if is_greedy else iter(self._open))
            self._leave(self._open.pop(oldest))
            self._lives.pop(oldest, None)
            self.transports.forget(oldest)
            self._forget(oldest)
        task = _new_task(event, fact, self._to_wall_s)
        self._open[fact.task] = task
        self._opened_by[task.coordinator] += 1
        self._lives[fact.task] = event.incarnation
        self._mark(task.id)
        if task.kind == "transport":
            self.transports.opened(fact.task, event.at_s)
        for early in self._reorder_buffer.take(fact.task):
            self.fold(early)

    def _answer(self, task: TaskView, event: Event, fact: AwardAnswered) -> bool:
        if fact.epoch < task.epoch:
            return False
        bid = last_bid(task, fact.bidder, fact.role, fact.epoch)
        if bid is not None:
            bid.answer = fact.answer if fact.reason is None else fact.reason.value
            bound = self._bound.get(fact.bidder)
            # A busy machine has other goals, perhaps several, so none is named.
            busy = fact.reason is Refusal.BUSY and task.kind == "transport"
            if busy and bound is not None and bound[0] != task.id:
                bid.taken_for = bound[1]
        if fact.answer != "accepted":
            return True
        if fact.role is Role.SECONDARY:
            task.secondary = fact.bidder
            return True
        task.epoch, task.primary, task.state = fact.epoch, fact.bidder, "contracted"
        task.contracted_at_s = self._to_wall_s(event.at_s)
        task.trouble = None
        if bid is not None:
            task.promised_at_s, task.source = bid.finish_at_s, bid.source
        won = self._carrier(event, fact.bidder, fact.epoch)
        before = task.carriers[-1] if task.carriers else None
        if before is not None and before.epoch == fact.epoch and before.how == "announced_anew":
            # The previous carrier's failure is still part of the answer.
            won.replaced, won.reason, won.silent_s = before.replaced, before.reason, before.silent_s
        add_carrier(task, won)
        return True

    def _recovered(
        self, task: TaskView, brief: TaskBrief, heartbeat: MachineHeartbeat | StationHeartbeat
    ) -> None:
        """A coordinator that was away names a carrier that accepted while it could not hear."""
        if task.state != "bidding" or not brief.primary or brief.epoch < task.epoch:
            return
        if heartbeat.incarnation <= self._lives[task.id]:
            return  # The incarnation that announced it reports acceptance itself, in an event.
        give_to(task, brief.primary, brief.epoch)
        carrier = CarrierView(
            carrier=brief.primary,
            epoch=brief.epoch,
            since_at_s=self._to_wall_s(heartbeat.at_s),
            how="recovered",
        )
        add_carrier(task, carrier)
        self._mark(task.id)

    def _carrier_changed(self, task: TaskView, event: Event, fact: CarrierChanged) -> bool:
        """Take the coordinator's word on the carrier: it overrides the carrier's own."""
        if fact.epoch < task.epoch:
            return False
        if fact.carrier:
            give_to(task, fact.carrier, fact.epoch)
        else:
            reopen_task(task)
            # The next announcement is round 1 of the new epoch.
            task.epoch, task.round = fact.epoch, 0
        changed = self._carrier(event, fact.carrier, fact.epoch)
        changed.how = "took_over" if fact.carrier else "announced_anew"
        changed.replaced, changed.reason, changed.silent_s = fact.replaced, fact.reason, fact.silent_s
        add_carrier(task, changed)
        return True

    def _took_over(self, task: TaskView, event: Event, fact: TookOver) -> bool:
        """Note a secondary's takeover, which it may report before the coordinator does."""
        if fact.epoch < task.epoch or (fact.epoch == task.epoch and task.primary != event.agent):
            return False
        give_to(task, event.agent, fact.epoch)
        taken = self._carrier(event, event.agent, fact.epoch)
        taken.replaced, taken.reason, taken.silent_s = fact.primary, fact.reason, fact.silent_s
        taken.how, taken.confirmed = "took_over", False
        known = task.carriers[-1] if task.carriers else None
        if known is None or (known.carrier, known.epoch) != (taken.carrier, taken.epoch):
            add_carrier(task, taken)
        return True

    def _taken(self, task: TaskView, event: Event, fact: ContractTaken) -> bool:
        """Note a carrier's takeover in a higher epoch, which it may report before the coordinator does."""
        if fact.role is Role.SECONDARY or fact.epoch <= task.epoch:
            return False
        give_to(task, event.agent, fact.epoch)
        return True

    def _carrier(self, event: Event, carrier: str, epoch: int) -> CarrierView:
        return CarrierView(carrier=carrier, epoch=epoch, since_at_s=self._to_wall_s(event.at_s))

    def _ended(self, event: Event, fact: TaskClosed) -> bool:
        task = self._open.pop(fact.task, None)
        if task is None:
            if fact.task not in self._closed:
                # Its announcement was lost and may be fetched again: the task must not stay open then.
                self._reorder_buffer.keep(event)
            return False
        task.epoch = max(task.epoch, fact.epoch)
        task.state = "delivered" if fact.outcome == "delivered" else "withdrawn"
        task.primary = fact.carrier or task.primary
        task.closed_at_s = self._to_wall_s(event.at_s)
        task.phase, task.trouble, task.stranded, task.fails_at = "", None, None, ""
        if fact.promised_s > 0:
            task.promised_at_s = self._to_wall_s(fact.promised_s)
        if task.kind == "transport":
            self.transports.closed(task.id, event.at_s, delivered=task.state == "delivered")
        self._lives.pop(task.id, None)
        self._leave(task)
        self._closed[task.id] = task
        self._mark(task.id)
        if len(self._closed) > CLOSED_KEPT:
            oldest = next(iter(self._closed))
            del self._closed[oldest]
            self._forget(oldest)
        return True


def _new_task(event: Event, fact: TaskOpened, to_wall_s: ToWall) -> TaskView:
    work = fact.work
    task = TaskView(
        id=fact.task,
        kind="transport" if isinstance(work, Transport) else "production",
        coordinator=event.agent,
        item="",
        quantity=work.quantity,
        epoch=fact.epoch,
        round=fact.round,
        radius_m=fact.radius_m,
        opened_at_s=to_wall_s(event.at_s),
        deadline_at_s=to_wall_s(fact.deadline_s),
    )
    match work:
        case Transport():
            task.item, task.goal = work.item, work.goal
            task.sources, task.destination = work.sources, work.destination
        case Production():
            # A production goal is named by the task that gives it out.
            task.item, task.goal, task.order = work.product, fact.task, work.order
    return task


def _failed(task: TaskView, _event: Event, fact: RoundFailed) -> bool:
    if fact.epoch < task.epoch or fact.role is Role.SECONDARY:
        return False
    task.round = max(task.round, fact.round)
    return True


def _waits(task: TaskView, _event: Event, fact: GoalWaits) -> bool:
    """Nobody can make this goal, until the next machine takes it."""
    trouble = failures_of(fact)
    if task.state != "bidding" or task.trouble == trouble:
        return False
    task.trouble = trouble
    return True


def _watch_lost(task: TaskView, _event: Event, fact: WatchLost) -> bool:
    if fact.epoch < task.epoch or task.secondary != fact.secondary:
        return False
    task.secondary = ""
    return True


def _phase(task: TaskView, event: Event, fact: PhaseEntered) -> bool:
    if fact.epoch < task.epoch:
        return False
    task.epoch, task.phase, task.primary = fact.epoch, fact.phase.value, event.agent
    return True
