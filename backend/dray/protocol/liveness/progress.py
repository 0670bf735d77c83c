"""The progress deadline of a contract: a carrier that lives without progress has failed too.

Its heartbeats tell its progress. Two conditions must hold:

    STALLED   it moves, or its phase goes on, at least every STALL_S and the longest handling of the plant
    OVERDUE   it is done by its own promise and SLACK_FRAC of the time that it had, at least SLACK_MIN_S

A carrier that only claims progress runs into the second one. Time beyond an honest vehicle's control counts for
neither. Its coordinator may hold the dock, or its source's station may not answer. A person may have stopped it or
limit its speed, or it is in error and asks for help. All excused time is at most EXCUSED_MAX_S per contract,
because the carrier itself reports most of it.
"""

from __future__ import annotations

from dray.messages import AtvHeartbeat, AtvStatus, Phase, Pose, Reason
from dray.messages.people.command import PROMISE_MAX_S
from dray.protocol.runtime.events import NEVER_S

STALL_S = 30.0
"""Time without progress beside the longest handling (s): three repeated questions, or a repeated manoeuvre."""

MOVED_M = 0.5
"""Less movement than this counts as standing (m); at a twelfth of its speed a vehicle moves as far in 5 s."""

SLACK_FRAC = 0.5
SLACK_MIN_S = 60.0
"""Random delays on the way: handshakes on a bad link, a busy dock."""

EXCUSED_MAX_S = PROMISE_MAX_S
"""As long as the system waits for a person who has promised to come (s)."""

_RANK = {phase: rank for rank, phase in enumerate(Phase)}


class Progress:
    """One carrier's progress with one task.

    Args:
        promised_s: its credible finish (plant clock).
        stall_s: how long it may stand.
        now_s: begin of the contract.

    Attributes:
        heard_s: time of its last heartbeat.
        failed_s: since when it has failed; `NEVER_S` if it has not.
        blamed: whether the dropped contract was noted.
    """

    __slots__ = (
        "_due_s",
        "_excused_s",
        "_moved_s",
        "_pose",
        "_promised_s",
        "_rank",
        "_stall_s",
        "blamed",
        "failed_s",
        "heard_s",
    )

    def __init__(self, promised_s: float, stall_s: float, now_s: float) -> None:
        self._promised_s = promised_s
        self._due_s = promised_s + max(SLACK_MIN_S, SLACK_FRAC * (promised_s - now_s))
        self._stall_s = stall_s
        self.heard_s = self._moved_s = now_s
        self._excused_s = 0.0
        self._rank = -1
        self._pose: Pose | None = None
        self.failed_s = NEVER_S
        self.blamed = False

    def on_heartbeat(
        self, heartbeat: AtvHeartbeat, phase: Phase | None, held: bool, now_s: float
    ) -> Reason | None:
        """Note a heartbeat that names the task.

        Args:
            heartbeat: the newest.
            phase: the task's phase.
            held: whether its coordinator, or an unresponsive station, keeps it waiting.
            now_s: the present time.

        Returns:
            `STALLED` or `OVERDUE`; None while it makes progress.
        """
        if held or heartbeat.help is not None or heartbeat.speed_limit_frac < 1.0:
            self._excuse(heartbeat, held, now_s - self.heard_s)
        self.heard_s = now_s
        if self._comes_nearer(heartbeat.pose, phase):
            self._moved_s = now_s
        failure: Reason | None = None
        if now_s > self._moved_s + self._stall_s:
            failure = Reason.STALLED
        elif now_s > self._due_s:
            failure = Reason.OVERDUE
        if not failure:
            self.failed_s = NEVER_S
        elif self.failed_s == NEVER_S:
            self.failed_s = now_s
        return failure

    def allow(self, promised_s: float) -> None:
        """Extend its deadline to a later promise: other vehicles are before it at a dock."""
        later_s = max(promised_s - self._promised_s, 0.0)
        self._promised_s += later_s
        self._due_s += later_s

    def stands_long(self, phase: Phase, now_s: float) -> bool:
        """Whether it has been in this phase without progress for longer than any handling takes."""
        return _RANK[phase] <= self._rank and now_s > self._moved_s + self._stall_s - STALL_S

    @property
    def late_s(self) -> float:
        """How much later than promised it was last heard, without excused time; negative if early."""
        return self.heard_s - self._promised_s

    def _excuse(self, heartbeat: AtvHeartbeat, held: bool, elapsed_s: float) -> None:
        stands = held or (
            heartbeat.help is not None and heartbeat.status in (AtvStatus.STOPPED, AtvStatus.ERROR)
        )
        frac = 1.0 if stands else 1.0 - heartbeat.speed_limit_frac
        excused_s = min(frac * elapsed_s, EXCUSED_MAX_S - self._excused_s)
        if excused_s > 0.0:
            self._excused_s += excused_s
            self._promised_s += excused_s
            self._due_s += excused_s
            self._moved_s += excused_s

    def _comes_nearer(self, pose: Pose, phase: Phase | None) -> bool:
        rank = -1 if phase is None else _RANK[phase]
        before, self._rank = self._rank, max(rank, self._rank)
        moved = self._pose is None or (
            abs(pose.x_m - self._pose.x_m) + abs(pose.y_m - self._pose.y_m) >= MOVED_M
        )
        if moved or rank > before:
            self._pose = pose
            return True
        return False
