"""The last heartbeat of each strategist, where a plant has several. A single strategist sends none."""

from __future__ import annotations

from collections.abc import Iterable

from dray.messages import StrategistHeartbeat
from dray.messages.keys import STRATEGISTS


class Strategists:
    """The strategists that were heard."""

    def __init__(self) -> None:
        self._last: dict[str, StrategistHeartbeat] = {}

    def fold(self, heartbeat: StrategistHeartbeat) -> bool:
        """Take a heartbeat in; False when it is older than the last one, or names no strategist."""
        name, last = heartbeat.strategist, self._last.get(heartbeat.strategist)
        if name not in STRATEGISTS:
            return False
        if last is not None and (heartbeat.incarnation, heartbeat.seq) <= (last.incarnation, last.seq):
            return False
        self._last[name] = heartbeat
        return True

    def heartbeats(self) -> Iterable[StrategistHeartbeat]:
        """The last one of each."""
        return self._last.values()
