"""The stations of storages: the last heartbeat of each, which tells what lies there."""

from __future__ import annotations

from dray.messages import StationHeartbeat, StockLevel
from dray.store.progress import ToWall

MAX_STATIONS = 2_000
"""Stations that are remembered: some times the largest plant. A peer that invents ids ends here."""


class Stations:
    """The stations.

    Args:
        to_wall_s: plant clock to wall clock.
    """

    def __init__(self, to_wall_s: ToWall) -> None:
        self._to_wall_s = to_wall_s
        self._last: dict[str, StationHeartbeat] = {}

    def fold(self, heartbeat: StationHeartbeat) -> bool:
        """Take a heartbeat in.

        Returns:
            False when it is older than the last one, or of one station too many.
        """
        last = self._last.get(heartbeat.station)
        if last is None:
            if len(self._last) >= MAX_STATIONS:
                return False
        elif (heartbeat.incarnation, heartbeat.seq) <= (last.incarnation, last.seq):
            return False
        self._last[heartbeat.station] = heartbeat
        return True

    def stock(self, storage: str, material: str) -> StockLevel | None:
        """What was told last of a material in a storage; None when nothing was."""
        last = self._last.get(storage)
        return next((each for each in last.stocks if each.item == material), None) if last else None

    def seen_at_s(self, storage: str) -> float | None:
        """When a station was heard last (wall clock); None when it never was."""
        last = self._last.get(storage)
        return None if last is None else self._to_wall_s(last.at_s)
