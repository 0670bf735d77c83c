"""The failure detector of a contracted vehicle, and the heartbeats that it goes by.

The machine follows its primary and its secondary, the secondary follows the primary (paper, 4.1 and
Figure 3). A vehicle has failed when nothing is heard of it past the bound, on the WLAN and through the
radio mesh alike, or when it says itself that it cannot go on and the time for help is over (paper,
cases 3 and 4). What follows from that is decided by whoever watches.
"""

from __future__ import annotations

from collections.abc import Callable

from dray.messages import AtvHeartbeat, AtvStatus, Reason
from dray.messages.people.command import PROMISE_MAX_S
from dray.protocol.liveness.suspicion import LATENESS_MAX_S, ArrivalStatistics, bound_s, silence_bound_s
from dray.protocol.runtime.events import NEVER_S
from dray.protocol.runtime.life import Life

UNNAMED_S = 5.0
"""Somebody who is contracted and does not say so for this long has lost the contract: many times the
latency of a good link, so that the contract has reached it and its heartbeat has come back."""


class FailureDetector:
    """What was last heard of one vehicle, and how long it may still go on like this.

    Args:
        subject: the vehicle.
        interval_s: how often it is expected to beat before the first heartbeat is heard.
        now_s: when the detector begins.
        prior: how heartbeats arrive at the agent that watches; it learns from this detector too.
    """

    __slots__ = (
        "_arrivals",
        "_deaf_s",
        "_help_until_s",
        "_last",
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
        # The first heartbeat that can be heard is said only now, and may be under way for as long as others are.
        self.heard_s = now_s + (self._prior.delay_s if self._prior.heard else LATENESS_MAX_S)
        self.last: AtvHeartbeat | None = None
        """The newest heartbeat; None before the first."""
        self._arrivals = ArrivalStatistics(self._prior)
        self.bound_s = bound_s(interval_s, self._arrivals.loss_frac, self._arrivals.deviation_s)
        self._last = (0, 0)
        self._help_until_s = NEVER_S
        self._deaf_s = self._prior.deaf_s
        """How long the agent that watches had been deaf when it heard the subject last."""

    @property
    def _silent_at_s(self) -> float:
        """When it counts as silent: time in which nobody could have been heard is no silence."""
        return self.heard_s + self.bound_s + self._prior.deaf_s - self._deaf_s

    @property
    def delay_s(self) -> float:
        """How long its heartbeats are under way, on average."""
        return self._arrivals.delay_s

    @property
    def fails_at_s(self) -> float:
        """When it counts as failed, if nothing more is heard."""
        return min(self._silent_at_s, self._help_until_s)

    def on_heartbeat(self, heartbeat: AtvHeartbeat, now_s: float) -> bool:
        """Note a heartbeat; False for one that was overtaken by a newer one: it tells nothing."""
        order = (heartbeat.incarnation, heartbeat.seq)
        if order <= self._last:
            return False
        same_life = order[0] == self._last[0]
        missed = order[1] - self._last[1] - 1 if same_life else 0
        delay_s = now_s - heartbeat.at_s
        self._arrivals.note(missed, delay_s)
        self._prior.note(missed, delay_s)
        self._last = order
        self.last = heartbeat
        self.heard_s, self._deaf_s = now_s, self._prior.deaf_s
        self.bound_s = silence_bound_s(heartbeat, self._arrivals)
        if heartbeat.help is not None:
            # By its own clock, which may be another one: what is left of the time counts, not the time.
            left_s = heartbeat.help.until_s - heartbeat.at_s
            self._help_until_s = now_s + min(left_s, PROMISE_MAX_S)
        else:
            self._help_until_s = now_s if heartbeat.status is AtvStatus.ERROR else NEVER_S
        return True

    def failure(self, now_s: float) -> Reason | None:
        """Why it has failed by now: `SILENT` or `IN_ERROR`; None while it has not."""
        if now_s >= self._silent_at_s:
            return Reason.SILENT
        return Reason.IN_ERROR if now_s >= self._help_until_s else None

    def heard_lately(self, now_s: float) -> bool:
        """Whether it was heard in the newer half of the bound: then its silence is somebody else's trouble."""
        return self.last is not None and now_s - self.heard_s < self.bound_s / 2


EVERYBODY = "*"
"""Instead of an agent: whoever beats, of the kind that is followed."""


class HeartbeatSubscriptions:
    """Whose heartbeats an agent listens to, counted, since one may matter for two reasons.

    Args:
        key_of: the bus key of an agent's heartbeats.

    Attributes:
        hearing: how heartbeats have arrived so far, over all that were followed.
    """

    __slots__ = ("_count", "_key_of", "_life", "arrivals")

    def __init__(self, key_of: Callable[[str], str], life: Life) -> None:
        self.arrivals = ArrivalStatistics()
        self._key_of = key_of
        self._life = life
        self._count: dict[str, int] = {}

    def follow(self, agent: str) -> None:
        """Subscribe to this agent's heartbeats, or to those of `EVERYBODY`, and count the reason."""
        count = self._count.get(agent, 0)
        self._count[agent] = count + 1
        if not count:
            self._life.subscribe(self._key_of(agent))

    def unfollow(self, agent: str) -> None:
        """Drop one reason; unsubscribe when it was the last."""
        count = self._count.pop(agent)
        if count > 1:
            self._count[agent] = count - 1
        else:
            self._life.unsubscribe(self._key_of(agent))
