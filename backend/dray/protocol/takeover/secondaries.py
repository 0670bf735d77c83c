"""The secondaries of a coordinator's tasks: one is elected as long as its task can be taken over.

A secondary is not reserved (protocol, step 4). It resigns when it wins its own work, it may fail, or its
resignation may be lost. A task without a secondary seeks another.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import cast

from dray.messages import Accepted, AtvHeartbeat, Bid, Declined, Reason, Release, Role, Transport
from dray.messages.fact import WatchLost
from dray.protocol.contract_net.auction import Auction
from dray.protocol.contract_net.auction_rules import AuctionRules
from dray.protocol.contract_net.auctions import Auctions
from dray.protocol.contract_net.task import OpenTask, StandbyContract
from dray.protocol.contract_net.terms import Terms
from dray.protocol.liveness.failure_detector import UNNAMED_S, FailureDetector, HeartbeatSubscriptions
from dray.protocol.liveness.suspicion import IDLE_INTERVAL_S
from dray.protocol.runtime.events import NEVER_S
from dray.protocol.runtime.life import Life

WATCH_RULES = AuctionRules(radius_m=50.0, rest_s=10.0, rest_growth=1.0, rest_max_s=10.0, rest_aged_max_s=60.0)
"""A missing secondary is less urgent than a missing primary, so it asks wider and rests longer. While all vehicles work, no
vehicle watches, so the rest grows."""

WATCH_AUCTION = "watch auction"
SECONDARY_SILENCE = "secondary silence"


class Secondaries:
    """The secondaries that watch one coordinator's primaries.

    Args:
        tasks: the coordinator's open tasks, by id.
        auctions: the set-up of its auctions.
        subscriptions: its heartbeat subscriptions.
        life: the agent's life; alarms are named ``(WATCH_AUCTION, task)`` and ``(SECONDARY_SILENCE, task)``.

    Attributes:
        alarms: handlers of this class's alarms, called with (task, now_s).
    """

    def __init__(
        self,
        tasks: Mapping[str, OpenTask],
        auctions: Auctions,
        subscriptions: HeartbeatSubscriptions,
        life: Life,
    ) -> None:
        self._tasks = tasks
        self._auctions = auctions
        self._subscriptions = subscriptions
        self._life = life
        self.alarms = {WATCH_AUCTION: self._wake_auction, SECONDARY_SILENCE: self._check}

    def restore(self, task: OpenTask, atv: str, number: int, now_s: float) -> None:
        """Continue with a secondary that an earlier life has elected."""
        self._follow(task, atv, number, None, now_s)

    def seek(self, task: OpenTask, candidates: tuple[tuple[str, Bid], ...], now_s: float) -> None:
        """Elect a secondary, from these candidates first; a task that cannot be taken over needs none."""
        if task.is_loaded or task.recovered or cast(Transport, task.work).vehicle:
            return
        terms = Terms(
            task=task.id,
            epoch=task.epoch,
            role=Role.SECONDARY,
            work=task.work,
            deadline_s=task.deadline_s,
            primary=task.primary,
        )
        task.watch = self._auctions.prepare(terms, WATCH_RULES, candidates)
        if not candidates and self._all_are_busy:
            task.watch.stand_behind(now_s)
        else:
            task.watch.open(now_s)
        self._auctions.arm(WATCH_AUCTION, task.watch)

    def drop(self, task: OpenTask, reason: Reason) -> None:
        """A task needs no secondary any more."""
        self.seek_no_more(task)
        if task.secondary:
            self._release(task, task.secondary, task.standby.number, reason)
            self.unfollow(task)

    def seek_no_more(self, task: OpenTask) -> None:
        """Stop the election; an elected secondary keeps watching."""
        if task.watch is not None:
            task.watch.cancel()
            task.watch = None
            self._life.cancel((WATCH_AUCTION, task.id))

    def lose(self, task: OpenTask, reason: Reason, now_s: float) -> None:
        """A secondary has resigned or failed: elect another."""
        fact = WatchLost(task=task.id, epoch=task.epoch, secondary=task.secondary, reason=reason)
        self._life.record(fact)
        self.unfollow(task)
        self.seek(task, (), now_s)

    def standby_candidate(self, task: OpenTask) -> tuple[tuple[str, Bid], ...]:
        """The candidate to ask first when the primary gives a task back: the secondary with its bid."""
        bid = task.standby.bid
        return () if bid is None else ((task.secondary, bid),)

    def unfollow(self, task: OpenTask) -> None:
        """Unsubscribe from a task's secondary, without a message: the secondary knows that its watch is over."""
        self._subscriptions.unfollow(task.secondary)
        self._life.cancel((SECONDARY_SILENCE, task.id))
        task.standby = StandbyContract()

    # --- messages ---

    def on_bid(self, task: OpenTask, sender: str, bid: Bid, now_s: float) -> None:
        if task.watch is not None and sender != task.primary:
            task.watch.on_bid(sender, bid, now_s)
            self._auctions.arm(WATCH_AUCTION, task.watch)

    def on_accepted(self, task: OpenTask, sender: str, answer: Accepted, now_s: float) -> None:
        if task.watch is not None:
            task.watch.on_accepted(sender, answer)
            if task.watch.winner == sender:
                self._bind(task, task.watch, now_s)
        elif sender != task.secondary:
            self._release(task, sender, answer.number, Reason.ANOTHER_WATCHES)

    def on_declined(self, task: OpenTask, sender: str, answer: Declined, now_s: float) -> None:
        if task.watch is not None:
            task.watch.on_declined(sender, answer, now_s)
            self._auctions.arm(WATCH_AUCTION, task.watch)

    def on_heartbeat(self, task: OpenTask, heartbeat: AtvHeartbeat, now_s: float) -> None:
        """Handle a heartbeat of the secondary, which may have forgotten its watch."""
        detector = task.standby.detector
        if detector is None or not detector.on_heartbeat(heartbeat, now_s):
            return
        self._life.alarm((SECONDARY_SILENCE, task.id), detector.fails_at_s)
        if any(brief.task == task.id and brief.epoch == task.epoch for brief in heartbeat.watches):
            task.standby.unnamed_s = NEVER_S
        elif task.standby.unnamed_s == NEVER_S:
            task.standby.unnamed_s = now_s
        elif now_s - task.standby.unnamed_s > UNNAMED_S:
            self.lose(task, Reason.FORGOTTEN, now_s)

    # --- time passes ---

    def _wake_auction(self, task_id: str, now_s: float) -> None:
        task = self._tasks.get(task_id)
        if task is None or task.watch is None:
            return
        if task.watch.is_due(now_s) and self._all_are_busy:
            task.watch.stand_behind(now_s)
        else:
            task.watch.wake(now_s)
        self._auctions.arm(WATCH_AUCTION, task.watch)

    @property
    def _all_are_busy(self) -> bool:
        """Whether transports wait for a vehicle: then no vehicle has time to watch either."""
        return any(task.auction.waits for task in self._tasks.values())

    def _check(self, task_id: str, now_s: float) -> None:
        task = self._tasks.get(task_id)
        if task is None or task.standby.detector is None:
            return
        failure = task.standby.detector.failure(now_s)
        if failure:
            self._release(task, task.secondary, task.standby.number, failure)
            self.lose(task, failure, now_s)
        else:
            self._life.alarm((SECONDARY_SILENCE, task.id), task.standby.detector.fails_at_s)

    # --- internals ---

    def _bind(self, task: OpenTask, watch: Auction, now_s: float) -> None:
        task.watch = None
        self._life.cancel((WATCH_AUCTION, task.id))
        self._follow(task, watch.winner, watch.number, watch.winning_bid, now_s)

    def _follow(self, task: OpenTask, atv: str, number: int, bid: Bid | None, now_s: float) -> None:
        self._subscriptions.follow(atv)
        detector = FailureDetector(atv, IDLE_INTERVAL_S, now_s, self._subscriptions.arrivals)
        task.standby = StandbyContract(atv, number, bid, detector)
        self._life.alarm((SECONDARY_SILENCE, task.id), detector.fails_at_s)

    def _release(self, task: OpenTask, atv: str, number: int, reason: Reason) -> None:
        release = Release(task=task.id, epoch=task.epoch, role=Role.SECONDARY, reason=reason, number=number)
        self._life.send(atv, release)
