"""The strategists of a plant that has several: the last heartbeat of each. One alone has none."""

from __future__ import annotations

from collections.abc import Iterable

from dray.messages import StrategistHeartbeat
from dray.messages.keys import STRATEGISTS


class Strategists:
    """Those that were heard."""

    def __init__(self) -> None:
        self._last: dict[str, StrategistHeartbeat] = {}

    def fold(self, heartbeat: StrategistHeartbeat) -> bool:
        """Take a heartbeat in; returns False when it is older than the last one, or nobody's of that name."""
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
