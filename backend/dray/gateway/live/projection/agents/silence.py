"""When silence of one agent means that what is shown of it is a memory: by the rule of the agents themselves.

The rule is `dray.protocol.liveness.suspicion`, applied to heartbeats as they arrive here. Panels are told what it gives and
have no rule of their own.

It is judged against the newest that was heard of the plant, and not against the gateway's clock alone. A simulation that
runs slower than was asked for, a gateway with more to read than it can, a network that holds everything up: all of
them make everybody's words old alike, and nobody is suspected for that. It is said once, of the plant.
"""

from __future__ import annotations

from collections.abc import Iterable
from heapq import nlargest

from dray.gateway.live.views import SilenceView
from dray.protocol.liveness.suspicion import (
    IDLE_INTERVAL_S,
    JITTER_S,
    AnyHeartbeat,
    ArrivalStatistics,
    bound_s,
    interval_s,
    silence_bound_s,
)

LEAST_AGENTS = 4
"""Of fewer agents it cannot be told whether they are silent or nobody can be heard."""

WITNESSES = 2
"""The plant is as far as so many say: one whose clock is ahead must not make all others look silent."""

LEAST_S = 2.0
"""Wall seconds, however fast the factory runs: what is on its way to the gateway is not lost yet."""

LEAST_OVERDUE_S = 1.2
"""Wall seconds before anything is overdue: browsers are told ten times a second at most, and a page may be busy."""


class _Heard:
    """What was heard of one agent."""

    __slots__ = ("arrivals", "beat_s", "incarnation", "lost_after_s", "seq", "view")

    def __init__(self) -> None:
        self.arrivals = ArrivalStatistics()
        self.incarnation = self.seq = 0
        """Of its newest heartbeat."""
        self.beat_s = self.lost_after_s = 0.0
        """What `view` was made of: on a clean link the same from one heartbeat to the next."""
        self.view: SilenceView | None = None


class Silence:
    """How the heartbeats of each agent arrive, and how long it may be silent.

    Args:
        speed: factory seconds per real second.
    """

    def __init__(self, speed: float) -> None:
        self._speed, self._least_s = speed, LEAST_S * speed
        self._heard: dict[str, _Heard] = {}
        """By agent: bounded by whoever lets agents in."""
        self._nobody = _Heard()
        """Instead of one that was never heard."""

    def note(self, agent: str, heartbeat: AnyHeartbeat, delay_s: float) -> None:
        """A heartbeat has come, newer than those before.

        Args:
            agent: whose.
            heartbeat: what it says.
            delay_s: how long it was under way, by the plant's clock; 0 where nobody knows.
        """
        heard = self._heard.get(agent)
        if heard is None:
            heard = self._heard[agent] = _Heard()
        incarnation, seq = heartbeat.incarnation, heartbeat.seq
        heard.arrivals.note(seq - heard.seq - 1 if incarnation == heard.incarnation else 0, delay_s)
        heard.incarnation, heard.seq = incarnation, seq

    def bound_s(self, agent: str, heartbeat: AnyHeartbeat) -> float:
        """After how much silence an agent counts as lost, in factory seconds."""
        arrivals = self._heard.get(agent, self._nobody).arrivals
        return max(self._least_s, silence_bound_s(heartbeat, arrivals))

    def view(self, agent: str, heartbeat: AnyHeartbeat) -> SilenceView:
        """The same as panels are told it."""
        heard = self._heard.get(agent, self._nobody)
        beat_s, lost_after_s = interval_s(heartbeat), silence_bound_s(heartbeat, heard.arrivals)
        if heard.view is None or heard.lost_after_s != lost_after_s or heard.beat_s != beat_s:
            heard.beat_s, heard.lost_after_s = beat_s, lost_after_s
            heard.view = SilenceView(
                beat_s=beat_s,
                overdue_after_s=max(LEAST_OVERDUE_S * self._speed, beat_s + JITTER_S),
                lost_after_s=round(max(self._least_s, lost_after_s), 1),
            )
        return heard.view


def plant_bound_s(speed: float) -> float:
    """How old the newest may be that is heard of the plant, in factory seconds.

    Args:
        speed: factory seconds per real second.
    """
    return max(LEAST_S * speed, bound_s(IDLE_INTERVAL_S))


def heard_until_s(told_s: Iterable[float], now_s: float) -> float:
    """How far the plant was heard, on its own clock; never beyond now.

    Args:
        told_s: of every agent, the time of its newest heartbeat.
        now_s: the present time on the plant's clock.
    """
    newest = nlargest(LEAST_AGENTS, told_s)
    if len(newest) < LEAST_AGENTS:
        return now_s
    return min(newest[WITNESSES - 1], now_s)
