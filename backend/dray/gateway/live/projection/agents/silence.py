"""The silence after which an agent counts as lost: the rule of the agents themselves.

The rule is `dray.protocol.liveness.suspicion`, applied to heartbeats as they arrive here. Panels get its
result and have no rule of their own.

Silence is judged against the newest message of the plant, not against the gateway's clock alone. A slow
simulation, an overloaded gateway or a network delay makes all messages old alike. Then no agent is suspected,
and the plant as a whole is reported as behind.
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
"""Minimum agents heard: with fewer, silent agents cannot be told from a broken connection."""

WITNESSES = 2
"""Agents that must confirm how far the plant is: one fast clock must not make the others look silent."""

LEAST_S = 2.0
"""Minimum wall seconds of silence at any factory speed: a message on its way is not lost yet."""

LEAST_OVERDUE_S = 1.2
"""Minimum wall seconds before a heartbeat is overdue: browsers get ten frames a second at most, and may be
busy."""


class _Heard:
    """The heartbeats of one agent."""

    __slots__ = ("arrivals", "beat_s", "incarnation", "lost_after_s", "seq", "view")

    def __init__(self) -> None:
        self.arrivals = ArrivalStatistics()
        self.incarnation = self.seq = 0
        """Both of its newest heartbeat."""
        self.beat_s = self.lost_after_s = 0.0
        """Inputs of `view`: on a clean link they are equal from one heartbeat to the next."""
        self.view: SilenceView | None = None


class Silence:
    """The arrival of each agent's heartbeats, and how long it may be silent.

    Args:
        speed: factory seconds per real second.
    """

    def __init__(self, speed: float) -> None:
        self._speed, self._least_s = speed, LEAST_S * speed
        self._heard: dict[str, _Heard] = {}
        """By agent; bounded because only admitted agents are noted."""
        self._nobody = _Heard()
        """Stands in for an agent that was never heard."""

    def note(self, agent: str, heartbeat: AnyHeartbeat, delay_s: float) -> None:
        """Note a heartbeat that is newer than those before.

        Args:
            agent: its sender.
            heartbeat: the message.
            delay_s: time under way by the plant's clock; 0 where unknown.
        """
        heard = self._heard.get(agent)
        if heard is None:
            heard = self._heard[agent] = _Heard()
        incarnation, seq = heartbeat.incarnation, heartbeat.seq
        heard.arrivals.note(seq - heard.seq - 1 if incarnation == heard.incarnation else 0, delay_s)
        heard.incarnation, heard.seq = incarnation, seq

    def bound_s(self, agent: str, heartbeat: AnyHeartbeat) -> float:
        """Factory seconds of silence after which an agent counts as lost."""
        arrivals = self._heard.get(agent, self._nobody).arrivals
        return max(self._least_s, silence_bound_s(heartbeat, arrivals))

    def view(self, agent: str, heartbeat: AnyHeartbeat) -> SilenceView:
        """The same bounds as panels get them."""
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
    """Maximum age of the newest message of the plant, in factory seconds.

    Args:
        speed: factory seconds per real second.
    """
    return max(LEAST_S * speed, bound_s(IDLE_INTERVAL_S))


def heard_until_s(told_s: Iterable[float], now_s: float) -> float:
    """The time up to which the plant was heard, on its own clock; never beyond now.

    Args:
        told_s: per agent, the time of its newest heartbeat.
        now_s: the present time on the plant's clock.
    """
    newest = nlargest(LEAST_AGENTS, told_s)
    if len(newest) < LEAST_AGENTS:
        return now_s
    return min(newest[WITNESSES - 1], now_s)
