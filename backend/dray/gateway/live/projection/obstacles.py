"""Obstacles on lanes as panels see them: reported by vehicles, until gone or forgotten."""

from __future__ import annotations

from dray.gateway.live.projection.changes import Changes
from dray.gateway.live.views import ObstacleView
from dray.messages import ObstacleCleared, ObstacleSeen
from dray.messages.floor.obstacle import MOST, MOST_OF_ONE


class Obstacles:
    """The obstacles that were reported.

    Args:
        speed: factory seconds per real second.
    """

    def __init__(self, speed: float) -> None:
        self._speed = speed
        self._now_s = 0.0
        self._views: dict[str, ObstacleView] = {}
        self.changes = Changes("obstacle")

    def look(self, wall_s: float) -> None:
        """Forget expired obstacles."""
        self._now_s = wall_s
        for name in [name for name, view in self._views.items() if view.until_at_s <= wall_s]:
            self._drop(name)

    def fold(self, said: ObstacleSeen | ObstacleCleared) -> bool:
        """Take in a vehicle's or person's report; False when it is no news."""
        name = _name(said.start, said.end)
        if isinstance(said, ObstacleCleared) or not said.there:
            known = name in self._views
            if known:
                self._drop(name)
            return known
        if name not in self._views:
            # The same limits as in vehicles (`protocol.closures.obstacles`).
            of_one = sum(view.by == said.atv for view in self._views.values())
            if len(self._views) >= MOST or of_one >= MOST_OF_ONE:
                return False
        self._views[name] = ObstacleView(
            id=name,
            start=said.start,
            end=said.end,
            by=said.atv,
            at_s=self._now_s,
            until_at_s=self._now_s + said.forget_in_s / self._speed,
        )
        self.changes.mark(name)
        return True

    def of(self, start: str, end: str) -> ObstacleView | None:
        """The obstacle known on a lane, in either direction."""
        return self._views.get(_name(start, end))

    def views(self) -> tuple[ObstacleView, ...]:
        """All of them, the oldest first."""
        return tuple(self._views.values())

    def take_changed(self) -> tuple[ObstacleView, ...]:
        """Those that have come or changed since the last call."""
        return tuple(self._views[name] for name in self.changes.take_changed())

    def _drop(self, name: str) -> None:
        del self._views[name]
        self.changes.drop(name)


def _name(start: str, end: str) -> str:
    """The same name for both directions of a lane."""
    return ">".join(sorted((start, end)))
