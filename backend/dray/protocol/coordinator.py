"""The coordinator of tasks: from the first announcement to the end, several at a time.

A machine coordinates its transports, the strategist the production goals; both through this class.
It elects a primary for every task and, where its agent wants a watch, a secondary that it keeps
elected: whenever one leaves, another is sought for as long as the task lasts (protocol, step 4).

When a primary fails, its secondary has GRACE_S to take over; else the task is announced anew. Either
way its epoch rises, and that is the fence: there is one carrier, whoever else believes to be it.

    AUCTION --accepted--> CARRIED --delivered, withdrawn--> closed
       ^                    |  ^
       |                    |  +-- TakenOver: epoch + 1, another carrier
       +--- epoch + 1 ------+ failed and nobody takes over, resigned, restarted without it

Goods that have left their machine exist only once: nobody else can carry them, so their task waits for
its carrier, and is given up after ASTRAY_S.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Literal, cast

from dray.memory import TaskMemory
from dray.messages import (
    Accepted,
    AtvHeartbeat,
    Bid,
    Brief,
    Confirmed,
    Declined,
    Release,
    Resigned,
    Role,
    Superseded,
    TakenOver,
    Transport,
    Withdrawn,
    Work,
)
from dray.messages.fact import CarrierChanged, PrimarySuspected, TaskClosed, WatchLost
from dray.protocol.auction import Auction, AuctionRules, Place, Terms
from dray.protocol.events import NEVER_S, Effect, Ignore, Record, Send
from dray.protocol.supervision import GOODS_ABOARD, Following, Vigil
from dray.protocol.suspicion import IDLE_INTERVAL_S, WORKING_INTERVAL_S
from dray.protocol.timers import Timers

Outcome = Literal["delivered", "withdrawn"]

CLOSED_KEPT = 1024
"""Closed tasks that late questions are still answered for: a day of one machine's work."""

WATCH_RULES = AuctionRules(radius_m=50.0, rest_s=10.0, rest_growth=1.0, rest_max_s=10.0)
"""A missing watch is less urgent than a missing primary, so it asks wider and rests longer."""

GRACE_S = 2.0
"""How long a secondary may take after its primary has failed, beside the delay of one message: both judge
by the same heartbeats, which reach them within each other's lateness."""

ASTRAY_S = 600.0
"""How long goods on board of a silent vehicle are waited for before they are made anew."""

ADOPT_S = 10.0
"""How long a coordinator that was started again listens for vehicles that work for it: many heartbeats."""

UNNAMED_S = 5.0
"""Somebody who is contracted and does not say so for this long has lost the contract: many times the
latency of a good link, so that the contract has reached it and its heartbeat has come back."""

PRIMARY_AUCTION = "primary auction"
WATCH_AUCTION = "watch auction"
PRIMARY_VIGIL = "primary vigil"
SECONDARY_VIGIL = "secondary vigil"


class OpenTask:
    """A task that has not ended, as its coordinator knows it."""

    __slots__ = (
        "auction",
        "due_s",
        "epoch",
        "grace",
        "guard",
        "id",
        "loaded",
        "opened_s",
        "primary",
        "promised_s",
        "secondary",
        "source",
        "trouble",
        "unloaded",
        "unnamed_s",
        "unwatched_s",
        "vigil",
        "watch",
        "work",
    )

    def __init__(self, task: str, work: Work, auction: Auction, opened_s: float) -> None:
        self.id = task
        self.work = work
        self.epoch = auction.terms.epoch
        """Rises whenever the carrier changes; whatever comes with a lower one is refused."""
        self.auction = auction
        self.watch: Auction | None = None
        """The auction for a secondary, while one is sought."""
        self.primary = ""
        self.secondary = ""
        self.source = ""
        self.promised_s = 0.0
        """When the primary has promised to be done."""
        self.vigil: Vigil | None = None
        """The watch over the primary."""
        self.guard: Vigil | None = None
        """The watch over the secondary."""
        self.opened_s = opened_s
        self.due_s = auction.terms.deadline_s
        """The first deadline; that of the auction moves when nobody could keep it."""
        self.loaded = False
        """Goods that have left this machine: nobody else can fetch them again."""
        self.unloaded = False
        """The coordinator has seen the load put down in its own buffer; the handover is still to come."""
        self.trouble = ""
        """Why it does not go on, in words."""
        self.grace = False
        """The primary has failed, and the secondary may still take over."""
        self.unnamed_s = NEVER_S
        """Since when the primary does not name this task in its heartbeat."""
        self.unwatched_s = NEVER_S
        """Since when the secondary does not."""

    @property
    def deadline_s(self) -> float:
        return self.auction.terms.deadline_s

    @property
    def is_of_goods(self) -> bool:
        """Whether products are carried away, of which each piece exists once."""
        return isinstance(self.work, Transport) and bool(self.work.goal)

    @property
    def work_item(self) -> str:
        """What is carried, or made."""
        return self.work.item if isinstance(self.work, Transport) else self.work.product

    def memory(self) -> TaskMemory:
        """A transport for its machine's next life."""
        return TaskMemory(
            task=self.id,
            epoch=self.epoch,
            work=cast(Transport, self.work),
            deadline_s=self.due_s,
            opened_s=self.opened_s,
            primary=self.primary,
            source=self.source,
            promised_s=self.promised_s,
            loaded=self.loaded,
        )

    @property
    def round(self) -> int:
        return self.auction.round


class ClosedTask:
    """What must still be known of a task that has ended."""

    __slots__ = ("carrier", "epoch", "outcome")

    def __init__(self, carrier: str, epoch: int, outcome: Outcome) -> None:
        self.carrier, self.epoch, self.outcome = carrier, epoch, outcome


def _do_nothing(*_args: object) -> None:
    """For an owner that has nothing to do then."""


class Coordinator:
    """All open tasks of one coordinating agent.

    Args:
        agent: the coordinator's id.
        place: where it stands.
        audience: for a task's work and a radius (m), the bus keys of those to ask.
        rules: the auction's patience and reach.
        timers: the agent's alarms; this class uses names ``(kind, task)``.
        following: which heartbeats the agent hears; None where contractors are not watched.
        out: where effects go.
        contracted: called when a task has got its primary, another one, or is without one again.
        lost: called when goods are given up with the vehicle that had them on board.
        left: called with a vehicle that does not carry a task any more.
        unloaded: called when a task has ended because its load is down, though nobody has said so.
    """

    def __init__(
        self,
        agent: str,
        place: Place,
        audience: Callable[[Work, float], tuple[str, ...]],
        rules: AuctionRules,
        timers: Timers,
        following: Following | None,
        out: list[Effect],
        contracted: Callable[[OpenTask, float], None],
        *,
        lost: Callable[[OpenTask, float], None] = _do_nothing,
        left: Callable[[str], None] = _do_nothing,
        unloaded: Callable[[OpenTask, float], None] = _do_nothing,
    ) -> None:
        self._agent = agent
        self._place = place
        self._audience = audience
        self._rules = rules
        self._timers = timers
        self._following = following
        self._out = out
        self._contracted = contracted
        self._lost = lost
        self._left = left
        self._unloaded = unloaded
        self.alarms = {
            PRIMARY_AUCTION: self._wake_auction,
            WATCH_AUCTION: self._wake_watch_auction,
            PRIMARY_VIGIL: self._check_primary,
            SECONDARY_VIGIL: self._check_secondary,
        }
        """What its agent calls when an alarm of this class has come, with (task, now_s)."""
        self._open: dict[str, OpenTask] = {}
        self._closed: dict[str, ClosedTask] = {}

    def __iter__(self) -> Iterator[OpenTask]:
        return iter(self._open.values())

    def __len__(self) -> int:
        return len(self._open)

    def get(self, task: str) -> OpenTask | None:
        return self._open.get(task)

    def closed(self, task: str) -> ClosedTask | None:
        return self._closed.get(task)

    # --- the life of a task ---

    def open(self, task: str, work: Work, deadline_s: float, now_s: float, *, epoch: int = 1) -> OpenTask:
        """Put a task up for auction."""
        opened = OpenTask(task, work, self._primary_auction(task, epoch, work, deadline_s), now_s)
        self._open[task] = opened
        self._announce(opened, now_s)
        return opened

    def restore(self, memory: TaskMemory, now_s: float) -> OpenTask:
        """Go on with a task of an earlier life.

        One that had a primary is followed as if nothing had been: the vehicle's own heartbeat shows soon
        enough whether it still carries it. One that had none may have been accepted while nobody listened:
        it is announced after ADOPT_S, with a higher epoch, unless a vehicle has named it by then.
        """
        epoch = memory.epoch if memory.primary else memory.epoch + 1
        deadline_s = _prolonged_s(memory.deadline_s, memory.opened_s, now_s)
        auction = self._primary_auction(memory.task, epoch, memory.work, deadline_s)
        task = OpenTask(memory.task, memory.work, auction, memory.opened_s)
        task.due_s = memory.deadline_s
        self._open[task.id] = task
        if memory.primary:
            auction.cancel()
            task.loaded = memory.loaded
            self._bind(task, memory.primary, memory.source, memory.promised_s, IDLE_INTERVAL_S, now_s)
            self._seek_watch(task, (), now_s)
        else:
            auction.open_later(now_s + ADOPT_S)
            self._arm(PRIMARY_AUCTION, task.id, auction)
        return task

    def adopt(self, atv: str, brief: Brief, work: Work, now_s: float) -> OpenTask | None:
        """Acknowledge the contract of a vehicle that names this coordinator, after a restart.

        Returns:
            The task, when it was without a carrier or not known at all; None when it is in other hands.
        """
        task = self._open.get(brief.task)
        if task is None:
            deadline_s = brief.due_s if brief.due_s is not None else now_s
            auction = self._primary_auction(brief.task, brief.epoch, work, deadline_s)
            task = self._open[brief.task] = OpenTask(brief.task, work, auction, now_s)
        elif task.primary or task.round:
            return None
        task.auction.cancel()
        task.epoch = brief.epoch
        self._timers.clear((PRIMARY_AUCTION, task.id))
        self._bind(task, atv, "", brief.due_s or 0.0, WORKING_INTERVAL_S, now_s)
        self._seek_watch(task, (), now_s)
        self._contracted(task, now_s)
        return task

    def reopen(self, task: OpenTask, reason: str, now_s: float) -> None:
        """Announce a task anew, with a higher epoch; whoever carried it is superseded."""
        replaced, silent_s = task.primary, self._silent_s(task, now_s)
        self._unbind(task, reason)
        task.epoch += 1
        deadline_s = _prolonged_s(task.due_s, task.opened_s, now_s)
        task.auction = self._primary_auction(task.id, task.epoch, task.work, deadline_s)
        self._out.append(Send(replaced, Superseded(task=task.id, epoch=task.epoch)))
        self._note_change(task, replaced, reason, silent_s)
        self._announce(task, now_s)
        self._contracted(task, now_s)

    def close(self, task: OpenTask, outcome: Outcome) -> None:
        """End a task; whoever is bound by it, except a carrier that has delivered, is let go."""
        del self._open[task.id]
        task.auction.cancel()
        self._timers.clear((PRIMARY_AUCTION, task.id))
        self._drop_watch(task, "the task has ended")
        if task.primary:
            self._left(task.primary)
            self._end_vigil(PRIMARY_VIGIL, task.id, task.vigil)
            if outcome == "withdrawn":
                withdrawn = Withdrawn(task=task.id, epoch=task.epoch, reason="not needed any more")
                self._out.append(Send(task.primary, withdrawn))
        fact = TaskClosed(
            task=task.id,
            epoch=task.epoch,
            outcome=outcome,
            carrier=task.primary,
            promised_s=task.promised_s,
        )
        self._out.append(Record(fact))
        self._closed[task.id] = ClosedTask(task.primary, task.epoch, outcome)
        if len(self._closed) > CLOSED_KEPT:
            del self._closed[next(iter(self._closed))]

    # --- what is heard ---

    def hear_bid(self, sender: str, bid: Bid, now_s: float) -> None:
        task = self._open.get(bid.task)
        if task is None or bid.epoch != task.epoch:
            self._out.append(Ignore("a bid for a task that has ended or moved on"))
            return
        if bid.role is Role.PRIMARY:
            task.auction.hear_bid(sender, bid, now_s)
            self._arm(PRIMARY_AUCTION, task.id, task.auction)
        elif task.watch is not None and sender != task.primary:
            task.watch.hear_bid(sender, bid, now_s)
            self._arm(WATCH_AUCTION, task.id, task.watch)

    def hear_accepted(self, sender: str, answer: Accepted, now_s: float) -> None:
        task = self._open.get(answer.task)
        if task is None or answer.epoch != task.epoch:
            self._release(sender, answer.task, answer.epoch, answer.role, "the task has ended")
        elif answer.role is Role.PRIMARY:
            task.auction.hear_accepted(sender, answer)
            if task.auction.winner == sender and not task.primary:
                self._bind_primary(task, sender, answer, now_s)
        elif task.watch is not None:
            task.watch.hear_accepted(sender, answer)
            if task.watch.winner == sender:
                self._bind_secondary(task, sender, now_s)
        elif sender != task.secondary:
            self._release(sender, answer.task, answer.epoch, answer.role, "another one watches")

    def hear_declined(self, sender: str, answer: Declined, now_s: float) -> None:
        task = self._open.get(answer.task)
        if task is None or answer.epoch != task.epoch:
            self._out.append(Ignore("declined a task that has ended or moved on"))
            return
        if answer.role is Role.PRIMARY:
            task.auction.hear_declined(sender, answer, now_s)
            self._arm(PRIMARY_AUCTION, task.id, task.auction)
        elif task.watch is not None:
            task.watch.hear_declined(sender, answer, now_s)
            self._arm(WATCH_AUCTION, task.id, task.watch)

    def hear_resigned(self, sender: str, message: Resigned, now_s: float) -> None:
        """A secondary leaves, or a primary gives its task back: another one is sought at once."""
        task = self._open.get(message.task)
        if task is None or message.epoch != task.epoch:
            self._out.append(Ignore("resigned from a contract that has ended"))
        elif message.role is Role.SECONDARY and sender == task.secondary:
            self._lose_watch(task, message.reason, now_s)
        elif message.role is Role.PRIMARY and sender == task.primary:
            self._without_carrier(task, message.reason, now_s)
        else:
            self._out.append(Ignore("resigned from a contract that it does not have"))

    def hear_taken_over(self, sender: str, message: TakenOver, now_s: float) -> None:
        """A secondary carries a task from now on, because its primary has failed."""
        task = self._open.get(message.task)
        if task is not None and task.primary == sender and task.epoch == message.epoch:
            self._confirm(task)
        elif task is None or message.epoch <= task.epoch:
            closed = self._closed.get(message.task)
            known = task.epoch if task is not None else closed.epoch if closed is not None else 0
            self._out.append(Send(sender, Superseded(task=message.task, epoch=known)))
        elif veto := self._veto(task, message, now_s):
            self._release(sender, task.id, message.epoch, Role.PRIMARY, veto)
        else:
            self._hand_over(task, sender, message, now_s)

    def hear_heartbeat(self, heartbeat: AtvHeartbeat, now_s: float) -> None:
        """Note that a contracted vehicle lives, and whether it knows of its contract."""
        for task in list(self._open.values()):
            if task.primary == heartbeat.atv and task.vigil is not None:
                if task.vigil.hear(heartbeat, now_s):
                    self._hear_primary(task, heartbeat, now_s)
            elif task.secondary == heartbeat.atv and task.guard is not None:
                if task.guard.hear(heartbeat, now_s):
                    self._hear_secondary(task, heartbeat, now_s)

    def note_loaded(self, task: OpenTask) -> None:
        """Goods have left with their carrier: nobody else could fetch them, so nobody needs to watch."""
        if not task.loaded:
            task.loaded = True
            self._drop_watch(task, "the load is on board")

    # --- time passes ---

    def _wake_auction(self, task_id: str, now_s: float) -> None:
        task = self._open.get(task_id)
        if task is not None:
            task.auction.wake(now_s)
            self._arm(PRIMARY_AUCTION, task_id, task.auction)

    def _wake_watch_auction(self, task_id: str, now_s: float) -> None:
        task = self._open.get(task_id)
        if task is not None and task.watch is not None:
            task.watch.wake(now_s)
            self._arm(WATCH_AUCTION, task_id, task.watch)

    def _check_primary(self, task_id: str, now_s: float) -> None:
        task = self._open.get(task_id)
        if task is None or task.vigil is None:
            return
        failure = task.vigil.failure(now_s)
        if not failure:
            task.grace = False
            self._timers.set((PRIMARY_VIGIL, task.id), task.vigil.fails_at_s)
        elif task.grace or not task.secondary:
            self._note_suspicion(task, now_s)
            self._without_carrier(task, failure, now_s)
        else:
            self._note_suspicion(task, now_s)
            task.grace = True
            self._timers.set((PRIMARY_VIGIL, task.id), now_s + GRACE_S + task.vigil.delay_s)

    def _note_suspicion(self, task: OpenTask, now_s: float) -> None:
        if task.grace or task.trouble:
            return
        suspected = PrimarySuspected(
            task=task.id,
            epoch=task.epoch,
            primary=task.primary,
            silent_s=self._silent_s(task, now_s),
        )
        self._out.append(Record(suspected))

    def _check_secondary(self, task_id: str, now_s: float) -> None:
        task = self._open.get(task_id)
        if task is None or task.guard is None:
            return
        failure = task.guard.failure(now_s)
        if failure:
            self._release(task.secondary, task.id, task.epoch, Role.SECONDARY, failure)
            self._lose_watch(task, failure, now_s)
        else:
            self._timers.set((SECONDARY_VIGIL, task.id), task.guard.fails_at_s)

    # --- when somebody fails ---

    def _hear_primary(self, task: OpenTask, heartbeat: AtvHeartbeat, now_s: float) -> None:
        vigil = cast(Vigil, task.vigil)
        task.grace, task.trouble = False, heartbeat.problem
        self._timers.set((PRIMARY_VIGIL, task.id), vigil.fails_at_s)
        brief = heartbeat.task
        if brief is not None and brief.task == task.id and brief.epoch == task.epoch:
            task.unnamed_s = NEVER_S
            if task.is_of_goods and brief.phase in GOODS_ABOARD:
                self.note_loaded(task)  # Also when they left while this coordinator was away.
        elif task.unnamed_s == NEVER_S:
            task.unnamed_s = now_s
        elif now_s - task.unnamed_s > UNNAMED_S:
            self._without_carrier(task, "does not carry it any more", now_s)

    def _hear_secondary(self, task: OpenTask, heartbeat: AtvHeartbeat, now_s: float) -> None:
        guard = cast(Vigil, task.guard)
        self._timers.set((SECONDARY_VIGIL, task.id), guard.fails_at_s)
        if any(brief.task == task.id and brief.epoch == task.epoch for brief in heartbeat.watches):
            task.unwatched_s = NEVER_S
        elif task.unwatched_s == NEVER_S:
            task.unwatched_s = now_s
        elif now_s - task.unwatched_s > UNNAMED_S:
            self._lose_watch(task, "does not watch any more", now_s)

    def _without_carrier(self, task: OpenTask, reason: str, now_s: float) -> None:
        """Nobody carries a task: announce it anew, or wait while its goods are out there."""
        if task.unloaded:
            self.close(task, "delivered")
            self._unloaded(task, now_s)
            return
        if not task.loaded:
            self.reopen(task, reason, now_s)
            return
        vigil = cast(Vigil, task.vigil)
        astray_at_s = vigil.fails_at_s + ASTRAY_S
        if vigil.failure(now_s) and now_s < astray_at_s:
            task.trouble = f"{task.primary} is {reason}, with the load on board"
            self._timers.set((PRIMARY_VIGIL, task.id), astray_at_s)
            self._contracted(task, now_s)
            return
        self.close(task, "withdrawn")
        self._lost(task, now_s)

    def _veto(self, task: OpenTask, message: TakenOver, now_s: float) -> str:
        """Why nobody may take a task over; empty when it is right."""
        if message.primary != task.primary:
            return "another one carries it"
        if task.unloaded:
            return f"{task.primary} has put the load down"
        if task.loaded:
            return f"the load is on board of {task.primary}"
        vigil = task.vigil
        if vigil is not None and vigil.heard_lately(now_s) and not vigil.failure(now_s):
            return f"{task.primary} is heard"
        return ""

    def _hand_over(self, task: OpenTask, atv: str, message: TakenOver, now_s: float) -> None:
        replaced, silent_s = task.primary, self._silent_s(task, now_s)
        failure = task.vigil.failure(now_s) if task.vigil is not None else ""
        if task.secondary == atv:
            self._end_guard(task)
        self._unbind(task, "another one has taken over")
        task.epoch = message.epoch
        self._out.append(Send(replaced, Superseded(task=task.id, epoch=task.epoch)))
        self._bind(task, atv, message.source, message.finish_s, WORKING_INTERVAL_S, now_s)
        self._confirm(task)
        self._note_change(task, replaced, failure or message.reason, silent_s)
        self._seek_watch(task, (), now_s)
        self._contracted(task, now_s)

    def _confirm(self, task: OpenTask) -> None:
        self._out.append(Send(task.primary, Confirmed(task=task.id, epoch=task.epoch)))

    def _note_change(self, task: OpenTask, replaced: str, reason: str, silent_s: float) -> None:
        changed = CarrierChanged(
            task=task.id,
            epoch=task.epoch,
            replaced=replaced,
            carrier=task.primary,
            reason=reason,
            silent_s=silent_s,
        )
        self._out.append(Record(changed))

    @staticmethod
    def _silent_s(task: OpenTask, now_s: float) -> float:
        return max(0.0, now_s - task.vigil.heard_s) if task.vigil is not None else 0.0

    # --- how it is done ---

    def _auction(
        self, terms: Terms, rules: AuctionRules, candidates: tuple[tuple[str, Bid], ...] = ()
    ) -> Auction:
        def audience(radius_m: float) -> tuple[str, ...]:
            return self._audience(terms.work, radius_m)

        return Auction(self._agent, terms, self._place, audience, rules, self._out, candidates)

    def _primary_auction(self, task: str, epoch: int, work: Work, deadline_s: float) -> Auction:
        terms = Terms(task=task, epoch=epoch, role=Role.PRIMARY, work=work, deadline_s=deadline_s)
        return self._auction(terms, self._rules)

    def _announce(self, task: OpenTask, now_s: float) -> None:
        task.auction.open(now_s)
        self._arm(PRIMARY_AUCTION, task.id, task.auction)

    def _arm(self, kind: str, task: str, auction: Auction) -> None:
        if auction.wake_at_s < NEVER_S:
            self._timers.set((kind, task), auction.wake_at_s)
        else:
            self._timers.clear((kind, task))

    def _bind_primary(self, task: OpenTask, atv: str, answer: Accepted, now_s: float) -> None:
        bid = task.auction.winning_bid
        source = bid.source if bid is not None else ""
        self._timers.clear((PRIMARY_AUCTION, task.id))
        self._bind(task, atv, source, answer.finish_s, WORKING_INTERVAL_S, now_s)
        self._seek_watch(task, task.auction.left_over, now_s)
        self._contracted(task, now_s)

    def _bind(
        self,
        task: OpenTask,
        atv: str,
        source: str,
        promised_s: float,
        interval_s: float,
        now_s: float,
    ) -> None:
        task.primary, task.source, task.promised_s = atv, source, promised_s
        task.unnamed_s, task.grace, task.trouble = NEVER_S, False, ""
        if self._following is not None:
            self._following.begin(atv)
            task.vigil = Vigil(atv, interval_s, now_s, self._following.hearing)
            self._timers.set((PRIMARY_VIGIL, task.id), task.vigil.fails_at_s)

    def _unbind(self, task: OpenTask, reason: str) -> None:
        if task.primary:
            self._left(task.primary)
        self._drop_watch(task, reason)
        self._end_vigil(PRIMARY_VIGIL, task.id, task.vigil)
        task.primary, task.vigil, task.source, task.loaded = "", None, "", False
        task.grace, task.trouble = False, ""

    def _seek_watch(self, task: OpenTask, candidates: tuple[tuple[str, Bid], ...], now_s: float) -> None:
        if self._following is None or task.loaded:
            return
        terms = Terms(
            task=task.id,
            epoch=task.epoch,
            role=Role.SECONDARY,
            work=task.work,
            deadline_s=task.deadline_s,
            primary=task.primary,
        )
        task.watch = self._auction(terms, WATCH_RULES, candidates)
        task.watch.open(now_s)
        self._arm(WATCH_AUCTION, task.id, task.watch)

    def _bind_secondary(self, task: OpenTask, atv: str, now_s: float) -> None:
        task.secondary, task.watch = atv, None
        self._timers.clear((WATCH_AUCTION, task.id))
        task.unwatched_s = NEVER_S
        if self._following is not None:
            self._following.begin(atv)
            task.guard = Vigil(atv, IDLE_INTERVAL_S, now_s, self._following.hearing)
            self._timers.set((SECONDARY_VIGIL, task.id), task.guard.fails_at_s)

    def _lose_watch(self, task: OpenTask, reason: str, now_s: float) -> None:
        fact = WatchLost(task=task.id, epoch=task.epoch, secondary=task.secondary, reason=reason)
        self._out.append(Record(fact))
        self._end_guard(task)
        self._seek_watch(task, (), now_s)

    def _drop_watch(self, task: OpenTask, reason: str) -> None:
        if task.watch is not None:
            task.watch.cancel()
            task.watch = None
            self._timers.clear((WATCH_AUCTION, task.id))
        if task.secondary:
            self._release(task.secondary, task.id, task.epoch, Role.SECONDARY, reason)
            self._end_guard(task)

    def _end_guard(self, task: OpenTask) -> None:
        self._end_vigil(SECONDARY_VIGIL, task.id, task.guard)
        task.secondary, task.guard = "", None

    def _end_vigil(self, kind: str, task: str, vigil: Vigil | None) -> None:
        if vigil is not None and self._following is not None:
            self._following.end(vigil.subject)
        self._timers.clear((kind, task))

    def _release(self, to: str, task: str, epoch: int, role: Role, reason: str) -> None:
        self._out.append(Send(to, Release(task=task, epoch=epoch, role=role, reason=reason)))


def _prolonged_s(due_s: float, opened_s: float, now_s: float) -> float:
    """A deadline for who begins now: as much time as the task was given at first, and no earlier than then."""
    return max(due_s, now_s + due_s - opened_s)
