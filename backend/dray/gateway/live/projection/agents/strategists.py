"""The last heartbeat of each strategist, where a plant has several. A single strategist sends none."""

from __future__ import annotations

from collections.abc import Iterable

from dray.messages import StrategistHeartbeat
from dray.messages.keys import STRATEGISTS
from dray.protocol.liveness.overtaken import is_overtaken


class Strategists:
    """The strategists that were heard."""

    def __init__(self) -> None:
        self._last: dict[str, tuple[StrategistHeartbeat, float]] = {}
        """Each with the time at which it came."""

    def fold(self, heartbeat: StrategistHeartbeat, now_s: float) -> bool:
        """Take a heartbeat in; False when it is older than the last one, or names no strategist."""
        name = heartbeat.strategist
        if name not in STRATEGISTS:
            return False
        if name in self._last:
            last, heard_s = self._last[name]
            said, newest = (heartbeat.incarnation, heartbeat.seq), (last.incarnation, last.seq)
            if is_overtaken(said, newest, heard_s, now_s):
                return False
        self._last[name] = heartbeat, now_s
        return True

    def heartbeats(self) -> Iterable[StrategistHeartbeat]:
        """The last one of each."""
        return (heartbeat for heartbeat, _ in self._last.values())
