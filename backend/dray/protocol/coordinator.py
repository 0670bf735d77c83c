"""The coordinator of tasks: from the first announcement to the end, several at a time.

A machine coordinates its transports, the strategist the production goals; both through this class.
It elects a primary for every task and, where its agent wants a watch, a secondary that it keeps
elected: whenever one leaves, another is sought for as long as the task lasts (protocol, step 4).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Literal

from dray.messages import (
    Accepted,
    AtvHeartbeat,
    Bid,
    Declined,
    Release,
    Resigned,
    Role,
    Withdrawn,
    Work,
)
from dray.messages.fact import PrimarySuspected, TaskClosed, WatchLost
from dray.protocol.auction import Auction, AuctionRules, Place, Terms
from dray.protocol.events import NEVER_S, Effect, Ignore, Record, Send
from dray.protocol.supervision import Following, Vigil
from dray.protocol.suspicion import IDLE_INTERVAL_S, WORKING_INTERVAL_S
from dray.protocol.timers import Timers

Outcome = Literal["delivered", "withdrawn"]

CLOSED_KEPT = 1024
"""Closed tasks that late questions are still answered for: a day of one machine's work."""

WATCH_RULES = AuctionRules(radius_m=50.0, rest_s=10.0, rest_growth=1.0, rest_max_s=10.0)
"""A missing watch is less urgent than a missing primary, so it asks wider and rests longer."""

PRIMARY_AUCTION = "primary auction"
WATCH_AUCTION = "watch auction"
PRIMARY_VIGIL = "primary vigil"
SECONDARY_VIGIL = "secondary vigil"


class OpenTask:
    """A task that has not ended, as its coordinator knows it."""

    __slots__ = (
        "auction",
        "epoch",
        "guard",
        "id",
        "opened_s",
        "primary",
        "promised_s",
        "secondary",
        "source",
        "vigil",
        "watch",
        "work",
    )

    def __init__(self, task: str, work: Work, auction: Auction, now_s: float) -> None:
        self.id = task
        self.work = work
        self.epoch = 1
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
        self.opened_s = now_s

    @property
    def deadline_s(self) -> float:
        return self.auction.terms.deadline_s

    @property
    def round(self) -> int:
        return self.auction.round


class ClosedTask:
    """What must still be known of a task that has ended."""

    __slots__ = ("carrier", "epoch", "outcome")

    def __init__(self, carrier: str, epoch: int, outcome: Outcome) -> None:
        self.carrier, self.epoch, self.outcome = carrier, epoch, outcome


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
        contracted: called when a task has got its primary.
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
    ) -> None:
        self._agent = agent
        self._place = place
        self._audience = audience
        self._rules = rules
        self._timers = timers
        self._following = following
        self._out = out
        self._contracted = contracted
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

    def open(self, task: str, work: Work, deadline_s: float, now_s: float) -> OpenTask:
        """Put a task up for auction."""
        terms = Terms(task=task, epoch=1, role=Role.PRIMARY, work=work, deadline_s=deadline_s)
        opened = OpenTask(task, work, self._auction(terms, self._rules), now_s)
        self._open[task] = opened
        opened.auction.open(now_s)
        self._arm(PRIMARY_AUCTION, task, opened.auction)
        return opened

    def close(self, task: OpenTask, outcome: Outcome) -> None:
        """End a task; whoever is bound by it, except a carrier that has delivered, is let go."""
        del self._open[task.id]
        task.auction.cancel()
        self._timers.clear((PRIMARY_AUCTION, task.id))
        self._drop_watch(task, "the task has ended")
        if task.primary:
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
        """A secondary leaves: another one is sought at once."""
        task = self._open.get(message.task)
        if task is not None and message.role is Role.SECONDARY and sender == task.secondary:
            self._lose_watch(task, message.reason, now_s)
        else:
            self._out.append(Ignore("resigned from a watch that has ended"))

    def hear_heartbeat(self, heartbeat: AtvHeartbeat, now_s: float) -> None:
        """Note that a contracted vehicle lives."""
        for task in self._open.values():
            if task.primary == heartbeat.atv and task.vigil is not None:
                task.vigil.hear(heartbeat, now_s)
            elif task.secondary == heartbeat.atv and task.guard is not None:
                task.guard.hear(heartbeat, now_s)

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
        if task.vigil.check(now_s):
            suspected = PrimarySuspected(
                task=task.id,
                epoch=task.epoch,
                primary=task.primary,
                silent_s=now_s - task.vigil.heard_s,
            )
            self._out.append(Record(suspected))
        self._timers.set((PRIMARY_VIGIL, task.id), task.vigil.next_look_s(now_s))

    def _check_secondary(self, task_id: str, now_s: float) -> None:
        task = self._open.get(task_id)
        if task is None or task.guard is None:
            return
        if task.guard.check(now_s):
            self._release(task.secondary, task.id, task.epoch, Role.SECONDARY, "silent")
            self._lose_watch(task, "silent", now_s)
        else:
            self._timers.set((SECONDARY_VIGIL, task.id), task.guard.overdue_at_s)

    # --- how it is done ---

    def _auction(
        self, terms: Terms, rules: AuctionRules, candidates: tuple[tuple[str, Bid], ...] = ()
    ) -> Auction:
        def audience(radius_m: float) -> tuple[str, ...]:
            return self._audience(terms.work, radius_m)

        return Auction(self._agent, terms, self._place, audience, rules, self._out, candidates)

    def _arm(self, kind: str, task: str, auction: Auction) -> None:
        if auction.wake_at_s < NEVER_S:
            self._timers.set((kind, task), auction.wake_at_s)
        else:
            self._timers.clear((kind, task))

    def _bind_primary(self, task: OpenTask, atv: str, answer: Accepted, now_s: float) -> None:
        bid = task.auction.winning_bid
        task.primary = atv
        task.source = bid.source if bid is not None else ""
        task.promised_s = answer.finish_s
        self._timers.clear((PRIMARY_AUCTION, task.id))
        if self._following is not None:
            self._following.begin(atv)
            task.vigil = Vigil(atv, WORKING_INTERVAL_S, now_s)
            self._timers.set((PRIMARY_VIGIL, task.id), task.vigil.overdue_at_s)
            self._seek_watch(task, task.auction.left_over, now_s)
        self._contracted(task, now_s)

    def _seek_watch(self, task: OpenTask, candidates: tuple[tuple[str, Bid], ...], now_s: float) -> None:
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
        if self._following is not None:
            self._following.begin(atv)
        task.guard = Vigil(atv, IDLE_INTERVAL_S, now_s)
        self._timers.set((SECONDARY_VIGIL, task.id), task.guard.overdue_at_s)

    def _lose_watch(self, task: OpenTask, reason: str, now_s: float) -> None:
        fact = WatchLost(task=task.id, epoch=task.epoch, secondary=task.secondary, reason=reason)
        self._out.append(Record(fact))
        self._end_vigil(SECONDARY_VIGIL, task.id, task.guard)
        task.secondary, task.guard = "", None
        self._seek_watch(task, (), now_s)

    def _drop_watch(self, task: OpenTask, reason: str) -> None:
        if task.watch is not None:
            task.watch.cancel()
            task.watch = None
            self._timers.clear((WATCH_AUCTION, task.id))
        if task.secondary:
            self._release(task.secondary, task.id, task.epoch, Role.SECONDARY, reason)
            self._end_vigil(SECONDARY_VIGIL, task.id, task.guard)

    def _end_vigil(self, kind: str, task: str, vigil: Vigil | None) -> None:
        if vigil is not None and self._following is not None:
            self._following.end(vigil.subject)
        self._timers.clear((kind, task))

    def _release(self, to: str, task: str, epoch: int, role: Role, reason: str) -> None:
        self._out.append(Send(to, Release(task=task, epoch=epoch, role=role, reason=reason)))
