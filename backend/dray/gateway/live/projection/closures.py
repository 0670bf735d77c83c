"""Closures, as panels see them."""

from __future__ import annotations

from collections.abc import Iterable

from dray.gateway.live.projection.changes import Changes
from dray.gateway.live.views import ClosureView


class Closures:
    """The closures that hold. Whoever reads them from SQL says so here."""

    def __init__(self) -> None:
        self._views: dict[str, ClosureView] = {}
        self.changes = Changes("closure")

    def put(self, closures: Iterable[ClosureView]) -> None:
        """Show these, and no others."""
        now = {view.id: view for view in closures}
        for name in self._views.keys() - now.keys():
            self.changes.drop(name)
        for name, view in now.items():
            if view != self._views.get(name):
                self.changes.mark(name)
        self._views = now

    def views(self) -> tuple[ClosureView, ...]:
        """All of them, the oldest first."""
        return tuple(self._views.values())

    def take_changed(self) -> tuple[ClosureView, ...]:
        """Those that have come or changed since the last call."""
        return tuple(self._views[name] for name in self.changes.take_changed())
