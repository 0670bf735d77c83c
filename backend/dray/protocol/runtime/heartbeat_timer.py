"""An agent's heartbeat timer: when the next heartbeat is due, and the number of the last one."""

from __future__ import annotations

from dray.protocol.runtime.life import BEAT, Life
from dray.protocol.runtime.timers import spread_frac


class HeartbeatTimer:
    """The rhythm of one agent's heartbeats.

    Args:
        agent: whose.
        life: its agent's; its alarms are named `BEAT`.
    """

    __slots__ = ("_agent", "_life", "seq")

    def __init__(self, agent: str, life: Life) -> None:
        self._agent = agent
        self._life = life
        self.seq = 0
        """The number of the newest heartbeat of this life."""

    def count(self) -> int:
        """Count one more heartbeat. Returns its number."""
        self.seq += 1
        return self.seq

    def go_on(self, interval_s: float, now_s: float) -> None:
        """It has beaten: do it again after an interval; the first time earlier, by a part that its name gives."""
        if self.seq == 1:
            interval_s *= 0.5 + spread_frac(self._agent) / 2
        self._life.alarm(BEAT, now_s + interval_s)
