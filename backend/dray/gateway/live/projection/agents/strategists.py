"""The last heartbeat of each strategist, where a plant has several. A single strategist sends none."""

from __future__ import annotations

from collections.abc import Iterable

from dray.messages import StrategistHeartbeat
from dray.messages.keys import STRATEGISTS
from dray.messages.overtaken import LatestNumbers


class Strategists:
    """The strategists that were heard."""

    def __init__(self) -> None:
        self._last: dict[str, StrategistHeartbeat] = {}
        self._newest: LatestNumbers[str] = LatestNumbers()

    def fold(self, heartbeat: StrategistHeartbeat, now_s: float) -> bool:
        """Take a heartbeat in; False when it is older than the last one, or names no strategist."""
        name = heartbeat.strategist
        if name not in STRATEGISTS:
            return False
        if not self._newest.takes(name, (heartbeat.incarnation, heartbeat.seq), now_s):
            return False
        self._last[name] = heartbeat
        return True

    def heartbeats(self) -> Iterable[StrategistHeartbeat]:
        """The last one of each."""
        return self._last.values()
