"""The watch over a contracted vehicle: who is followed, and when silence is noticed.

The machine follows its primary and its secondary, the secondary follows the primary (paper, 4.1 and
Figure 3). What follows from a suspicion is decided by whoever watches.
"""

from __future__ import annotations

from collections.abc import Callable

from dray.messages import AtvHeartbeat
from dray.protocol.events import Effect, Subscribe, Unsubscribe
from dray.protocol.suspicion import atv_interval_s, bound_s


class Vigil:
    """What was last heard of one vehicle, and how long it may still be silent.

    Args:
        subject: the vehicle.
        interval_s: how often it is expected to beat before the first heartbeat is heard.
        now_s: when the vigil begins.
    """

    __slots__ = ("_last", "bound_s", "heard_s", "subject", "suspected")

    def __init__(self, subject: str, interval_s: float, now_s: float) -> None:
        self.subject = subject
        self.heard_s = now_s
        self.bound_s = bound_s(interval_s)
        self.suspected = False
        self._last = (0, 0)

    @property
    def overdue_at_s(self) -> float:
        """When its silence becomes suspicious."""
        return self.heard_s + self.bound_s

    def hear(self, heartbeat: AtvHeartbeat, now_s: float) -> None:
        """Note a heartbeat; one that was overtaken by a newer one tells nothing."""
        order = (heartbeat.incarnation, heartbeat.seq)
        if order <= self._last:
            return
        self._last = order
        self.heard_s = now_s
        self.bound_s = bound_s(atv_interval_s(heartbeat))
        self.suspected = False

    def check(self, now_s: float) -> bool:
        """Whether it has become suspect just now: true once per silence."""
        if self.suspected or now_s < self.overdue_at_s:
            return False
        self.suspected = True
        return True

    def next_look_s(self, now_s: float) -> float:
        """When to look again: a suspect may speak up, so it is not looked at all the time."""
        return now_s + self.bound_s if self.suspected else self.overdue_at_s


class Following:
    """Whose heartbeats an agent listens to, counted, since one may matter for two reasons.

    Args:
        key_of: the bus key of an agent's heartbeats.
        out: where effects go.
    """

    __slots__ = ("_count", "_key_of", "_out")

    def __init__(self, key_of: Callable[[str], str], out: list[Effect]) -> None:
        self._key_of = key_of
        self._out = out
        self._count: dict[str, int] = {}

    def begin(self, agent: str) -> None:
        """Follow this agent for one more reason."""
        count = self._count.get(agent, 0)
        self._count[agent] = count + 1
        if not count:
            self._out.append(Subscribe(self._key_of(agent)))

    def end(self, agent: str) -> None:
        """One reason less."""
        count = self._count.pop(agent)
        if count > 1:
            self._count[agent] = count - 1
        else:
            self._out.append(Unsubscribe(self._key_of(agent)))
