"""The failure detector of a contracted vehicle, and the heartbeats it uses.

The machine follows its primary and its secondary, the secondary follows the primary (paper, 4.1 and
Figure 3). A vehicle has failed when it is silent past the bound, on the WLAN and on the radio mesh alike. It has
also failed when it reports an error and the time for help is over (paper, cases 3 and 4). The observer decides what
follows.
"""

from __future__ import annotations

from collections.abc import Callable

from dray.messages import AtvHeartbeat, AtvStatus, Reason
from dray.messages.overtaken import LatestNumber
from dray.messages.people.command import PROMISE_MAX_S
from dray.protocol.liveness.suspicion import LATENESS_MAX_S, ArrivalStatistics, bound_s, silence_bound_s
from dray.protocol.runtime.events import NEVER_S
from dray.protocol.runtime.life import Life

UNNAMED_S = 5.0
"""A contractor that does not name its contract for this long has lost it (s). This is many times the latency of a
good link: the contract has reached it, and its heartbeat has come back."""


class FailureDetector:
    """The last heartbeat of one vehicle, and its time until failure.

    Args:
        subject: the vehicle.
        interval_s: its expected interval before the first heartbeat.
        now_s: begin of the detection.
        prior: arrival statistics of the observing agent; this detector updates them.
    """

    __slots__ = (
        "_arrivals",
        "_deaf_s",
        "_help_until_s",
        "_newest",
        "_prior",
        "begun_s",
        "bound_s",
        "heard_s",
        "last",
        "subject",
    )

    def __init__(
        self, subject: str, interval_s: float, now_s: float, prior: ArrivalStatistics | None = None
    ) -> None:
        self.subject = subject
        self.begun_s = now_s
        self._prior = prior if prior is not None else ArrivalStatistics()
        # The first heartbeat is sent only now, and may take as long as others do.
        self.heard_s = now_s + (self._prior.delay_s if self._prior.heard else LATENESS_MAX_S)
        self.last: AtvHeartbeat | None = None
        """The newest heartbeat; None before the first."""
        self._arrivals = ArrivalStatistics(self._prior)
        self.bound_s = bound_s(interval_s, self._arrivals.loss_frac, self._arrivals.deviation_s)
        self._newest = LatestNumber((0, 0), now_s)
        self._help_until_s = NEVER_S
        self._deaf_s = self._prior.deaf_s
        """Time for which the observer had been deaf when it last heard the subject (s)."""

    @property
    def _silent_at_s(self) -> float:
        """When it counts as silent; time in which the observer was deaf does not count."""
        return self.heard_s + self.bound_s + self._prior.deaf_s - self._deaf_s

    @property
    def delay_s(self) -> float:
        """Mean delay of its heartbeats (s)."""
        return self._arrivals.delay_s

    @property
    def fails_at_s(self) -> float:
        """When it counts as failed without another heartbeat."""
        return min(self._silent_at_s, self._help_until_s)

    def on_heartbeat(self, heartbeat: AtvHeartbeat, now_s: float) -> bool:
        """Note a heartbeat; False if a newer one has overtaken it."""
        life, seq = self._newest.number
        if not self._newest.takes((heartbeat.incarnation, heartbeat.seq), now_s):
            return False
        missed = heartbeat.seq - seq - 1 if heartbeat.incarnation == life else 0
        delay_s = now_s - heartbeat.at_s
        self._arrivals.note(missed, delay_s)
        self._prior.note(missed, delay_s)
        self.last = heartbeat
        self.heard_s, self._deaf_s = now_s, self._prior.deaf_s
        self.bound_s = silence_bound_s(heartbeat, self._arrivals)
        if heartbeat.help is not None:
            # Its clock may differ, so the remaining time counts, not the time of day.
            left_s = heartbeat.help.until_s - heartbeat.at_s
            self._help_until_s = now_s + min(left_s, PROMISE_MAX_S)
        else:
            self._help_until_s = now_s if heartbeat.status is AtvStatus.ERROR else NEVER_S
        return True

    def failure(self, now_s: float) -> Reason | None:
        """Why it has failed: `SILENT` or `IN_ERROR`; None if it has not."""
        if now_s >= self._silent_at_s:
            return Reason.SILENT
        return Reason.IN_ERROR if now_s >= self._help_until_s else None

    def heard_lately(self, now_s: float) -> bool:
        """Whether it was heard within half of the bound: then its silence elsewhere is another agent's problem."""
        return self.last is not None and now_s - self.heard_s < self.bound_s / 2


EVERYBODY = "*"
"""Wildcard for all agents of the followed kind."""


class HeartbeatSubscriptions:
    """The heartbeats that an agent follows, counted, because there may be several reasons for one.

    Args:
        key_of: the bus key of an agent's heartbeats.

    Attributes:
        arrivals: arrival statistics over all followed agents.
    """

    __slots__ = ("_count", "_key_of", "_life", "arrivals")

    def __init__(self, key_of: Callable[[str], str], life: Life) -> None:
        self.arrivals = ArrivalStatistics()
        self._key_of = key_of
        self._life = life
        self._count: dict[str, int] = {}

    def follow(self, agent: str) -> None:
        """Subscribe to an agent's heartbeats, or to those of `EVERYBODY`, and count the reason."""
        count = self._count.get(agent, 0)
        self._count[agent] = count + 1
        if not count:
            self._life.subscribe(self._key_of(agent))

    def unfollow(self, agent: str) -> None:
        """Drop one reason; unsubscribe after the last."""
        count = self._count.pop(agent)
        if count > 1:
            self._count[agent] = count - 1
        else:
            self._life.unsubscribe(self._key_of(agent))
