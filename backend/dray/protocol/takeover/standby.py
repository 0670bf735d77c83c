"""A secondary's watches: its primaries, their tasks, and when their failure is noticed.

A watch reserves nothing. The vehicle goes on bidding, and resigns from every watch when it wins its own work
(protocol, step 4).
"""

from __future__ import annotations

from msgspec.structs import replace

from dray.messages import THING, AtvHeartbeat, Award, Brief, Reason, Release, Resigned, Role, Transport
from dray.messages.fact import ContractEnded, ContractTaken, PrimarySuspected
from dray.messages.heartbeat import GOODS_ABOARD
from dray.protocol.liveness.failure_detector import FailureDetector, HeartbeatSubscriptions
from dray.protocol.liveness.suspicion import WORKING_INTERVAL_S
from dray.protocol.runtime.life import Life

WATCHED_SILENCE = "watched silence"

OVER_AFTER_S = 15.0
"""A primary that has named another task, or none, for this long has finished the watched one (s). The coordinator's release
was lost."""


class Watch:
    """One task that this vehicle is secondary of."""

    __slots__ = ("award", "coordinator", "detector", "named_s", "reported")

    def __init__(self, award: Award, coordinator: str, detector: FailureDetector, now_s: float) -> None:
        self.award = award
        self.coordinator = coordinator
        self.detector = detector
        self.named_s = now_s
        """When the primary last named this task as its own."""
        self.reported = False
        """Whether the primary's present failure is recorded."""

    @property
    def can_be_taken_over(self) -> bool:
        """Whether the load can still be fetched: goods that have left their machine exist only once, and so do things."""
        work, last = self.award.work, self.detector.last
        if not isinstance(work, Transport) or not (work.goal or work.item == THING):
            return True
        brief = last.task if last is not None else None
        return brief is None or brief.task != self.award.task or brief.phase not in GOODS_ABOARD

    def brief(self) -> Brief:
        work = self.award.work
        item, quantity = (work.item, work.quantity) if isinstance(work, Transport) else ("", 0)
        return Brief(
            task=self.award.task,
            epoch=self.award.epoch,
            role=Role.SECONDARY,
            coordinator=self.coordinator,
            item=item,
            quantity=quantity,
        )


class Standby:
    """All watches of one vehicle.

    Args:
        subscriptions: the vehicle's heartbeat subscriptions.
        life: the agent's life; alarms are named ``(WATCHED_SILENCE, task)``.
    """

    def __init__(self, subscriptions: HeartbeatSubscriptions, life: Life) -> None:
        self._subscriptions = subscriptions
        self._life = life
        self._watches: dict[str, Watch] = {}

    def __len__(self) -> int:
        return len(self._watches)

    def __contains__(self, task: str) -> bool:
        return task in self._watches

    def holds(self, task: str, epoch: int) -> bool:
        """Whether this vehicle has the watch in exactly this epoch."""
        watch = self._watches.get(task)
        return watch is not None and watch.award.epoch == epoch

    def coordinator_of(self, task: str) -> str:
        """The coordinator of a watch; empty without that watch."""
        watch = self._watches.get(task)
        return "" if watch is None else watch.coordinator

    def last_heard(self, task: str) -> AtvHeartbeat | None:
        """The last heartbeat of a watched task's primary; None if there was none."""
        watch = self._watches.get(task)
        return None if watch is None else watch.detector.last

    def briefs(self) -> tuple[Brief, ...]:
        return tuple(watch.brief() for watch in self._watches.values())

    def watch(self, award: Award, coordinator: str, now_s: float) -> None:
        """Watch the primary of an award; a newer epoch of the same task replaces the older one."""
        if award.task in self._watches:
            self.unwatch(award.task, Reason.RENEWED)
        detector = FailureDetector(award.primary, WORKING_INTERVAL_S, now_s, self._subscriptions.arrivals)
        self._watches[award.task] = Watch(award, coordinator, detector, now_s)
        self._subscriptions.follow(award.primary)
        self._life.alarm((WATCHED_SILENCE, award.task), detector.fails_at_s)
        taken = ContractTaken(
            task=award.task, epoch=award.epoch, role=Role.SECONDARY, coordinator=coordinator
        )
        self._life.record(taken)

    def renew(self, award: Award) -> None:
        """Renew a watch with a repeated award; a release of the earlier award does not end it."""
        watch = self._watches[award.task]
        watch.award = replace(award, primary=watch.award.primary)

    def release(self, message: Release) -> bool:
        """The coordinator releases a watch; False if the watch has another award."""
        watch = self._watches.get(message.task)
        if watch is None or watch.award.number != message.number:
            return False
        self.unwatch(message.task, message.reason)
        return True

    def unwatch(self, task: str, reason: Reason) -> None:
        """End a watch; ignored if there is none for this task."""
        watch = self._watches.pop(task, None)
        if watch is None:
            return
        self._subscriptions.unfollow(watch.award.primary)
        self._life.cancel((WATCHED_SILENCE, task))
        ended = ContractEnded(task=task, epoch=watch.award.epoch, role=Role.SECONDARY, reason=reason)
        self._life.record(ended)

    def resign(self, reason: Reason) -> None:
        """Resign from every watch; each coordinator elects another secondary."""
        for task in list(self._watches):
            self.resign_from(task, reason)

    def resign_from(self, task: str, reason: Reason, detail: str = "") -> None:
        """Resign from one watch; `detail` tells people more."""
        watch = self._watches[task]
        resigned = Resigned(
            task=task, epoch=watch.award.epoch, role=Role.SECONDARY, reason=reason, detail=detail
        )
        self._life.send(watch.coordinator, resigned)
        self.unwatch(task, Reason.RESIGNED)

    def on_heartbeat(self, heartbeat: AtvHeartbeat, now_s: float) -> None:
        """Note a heartbeat of a watched primary."""
        for task, watch in list(self._watches.items()):
            if watch.award.primary != heartbeat.atv or not watch.detector.on_heartbeat(heartbeat, now_s):
                continue
            watch.reported = False
            # A heartbeat may advance the failure: the time for help is over, or was shortened.
            self._life.alarm((WATCHED_SILENCE, task), watch.detector.fails_at_s)
            if heartbeat.task is not None and heartbeat.task.task == task:
                watch.named_s = now_s
            elif now_s - watch.named_s > OVER_AFTER_S:
                self.unwatch(task, Reason.OVER)

    def failed(self, task: str, now_s: float) -> Watch | None:
        """Check a primary whose alarm is due.

        Returns:
            The watch if its primary has failed and the task can be taken over; None otherwise.
        """
        watch = self._watches.get(task)
        if watch is None:
            return None
        detector = watch.detector
        reason = detector.failure(now_s)
        if not reason:
            self._life.alarm((WATCHED_SILENCE, task), detector.fails_at_s)
            return None
        if not watch.reported:
            watch.reported = True
            suspected = PrimarySuspected(
                task=task,
                epoch=watch.award.epoch,
                primary=watch.award.primary,
                silent_s=now_s - detector.heard_s,
            )
            self._life.record(suspected)
        if watch.can_be_taken_over:
            return watch
        # The coordinator waits for the primary too. A new heartbeat sets the alarm again.
        self._life.cancel((WATCHED_SILENCE, task))
        return None
