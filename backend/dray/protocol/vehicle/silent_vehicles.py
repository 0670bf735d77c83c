"""Silent vehicles in the way, remembered by the vehicle that has reported them as obstacles.

The vehicle follows each of them. It reports the way as free when the silent one is heard again and can move, or was
carried away. If that is missed, the obstacle is forgotten after a time like any other.
"""

from __future__ import annotations

from collections.abc import Sequence

from dray.messages import AtvStatus
from dray.messages.keys import Keys
from dray.plant.restrictions import Ends
from dray.protocol.closures.obstacles import Obstacles
from dray.protocol.liveness.failure_detector import HeartbeatSubscriptions
from dray.protocol.runtime.bounded_map import BoundedMap
from dray.protocol.runtime.life import Life
from dray.protocol.traffic.driving.wait import SHUT_OUT_S

STANDS = frozenset({AtvStatus.ERROR, AtvStatus.STOPPED})
"""States in which a vehicle stands until a person has checked it."""

REMEMBERED = 16
"""Maximum remembered vehicles: more than stand silent on one floor."""


class SilentVehicles:
    """The silent vehicles that one vehicle has reported.

    Args:
        obstacles: known obstacles on lanes.
        subscriptions: its heartbeat subscriptions.
        keys: the plant's bus keys.
    """

    def __init__(
        self,
        obstacles: Obstacles,
        subscriptions: HeartbeatSubscriptions,
        life: Life,
        keys: Keys,
    ) -> None:
        self._obstacles = obstacles
        self._subscriptions = subscriptions
        self._life = life
        self._keys = keys
        self._lanes: dict[str, tuple[Ends, ...]] = {}
        """By vehicle: the lanes that it blocks."""
        self._ended_s: BoundedMap[str, float] = BoundedMap(REMEMBERED)
        """By vehicle: when it was last heard again, or carried away."""

    def __contains__(self, atv: str) -> bool:
        return atv in self._lanes

    def was_heard_lately(self, atv: str, now_s: float) -> bool:
        """Whether it was heard or carried away recently: it may soon be gone, even if a reservation table still has it."""
        return now_s - self._ended_s.get(atv, -SHUT_OUT_S) < SHUT_OUT_S

    def meet(self, atv: str, lanes: Sequence[Ends]) -> list[Ends]:
        """Note a vehicle that was waited for without success. Returns its lanes that are not reported yet."""
        if atv not in self._lanes:
            if not self._lanes:
                self._life.subscribe(self._keys.removals)
            self._subscriptions.follow(atv)
        self._lanes[atv] = tuple(dict.fromkeys((*self._lanes.get(atv, ()), *lanes)))
        return [ends for ends in lanes if not self._obstacles.is_on(*ends)]

    def note_gone(self, atv: str, now_s: float) -> tuple[Ends, ...]:
        """A vehicle is heard again and can move, or was carried away. Returns the lanes that it has blocked."""
        lanes = self._lanes.get(atv, ())
        if lanes:
            self._ended_s[atv] = now_s
            self._forget(atv)
        return lanes

    def look(self) -> None:
        """An obstacle was forgotten: stop following vehicles without obstacles."""
        for atv, lanes in list(self._lanes.items()):
            if not any(self._obstacles.is_on(*ends) for ends in lanes):
                self._forget(atv)

    def _forget(self, atv: str) -> None:
        del self._lanes[atv]
        self._subscriptions.unfollow(atv)
        if not self._lanes:
            self._life.unsubscribe(self._keys.removals)
