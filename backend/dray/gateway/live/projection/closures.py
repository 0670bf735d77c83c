"""Closures, as panels see them, and which vehicles know of them."""

from __future__ import annotations

from collections.abc import Iterable

from msgspec import UNSET
from msgspec.structs import replace

from dray.gateway.live.projection.changes import Changes
from dray.gateway.live.views import ClosureView
from dray.messages import AtvHeartbeat


class Closures:
    """The closures in force. The reader of SQL puts them here."""

    def __init__(self) -> None:
        self._views: dict[str, tuple[ClosureView, int]] = {}
        """Per id, the closure and the number of its decision."""
        self._known: dict[str, int] = {}
        """Per vehicle, the number of its closure list."""
        self.changes = Changes("closure")

    def put(self, closures: Iterable[tuple[ClosureView, int]]) -> None:
        """Show exactly these closures."""
        now = {view.id: (view, number) for view, number in closures}
        for name in self._views.keys() - now.keys():
            self.changes.drop(name)
        for name, shown in now.items():
            if shown != self._views.get(name):
                self.changes.mark(name)
        self._views = now

    def on_heartbeat(self, heartbeat: AtvHeartbeat) -> None:
        """Note which closure list a vehicle uses."""
        number = 0 if heartbeat.closures is UNSET else heartbeat.closures
        before = self._known.get(heartbeat.atv)
        if number == before:
            return
        self._known[heartbeat.atv] = number
        for name, (_, decided) in self._views.items():
            if before is None or (before < decided) != (number < decided):
                self.changes.mark(name)

    def views(self) -> tuple[ClosureView, ...]:
        """All of them, the oldest first."""
        return tuple(self._view(name) for name in self._views)

    def take_changed(self) -> tuple[ClosureView, ...]:
        """Those that have come or changed since the last call."""
        return tuple(self._view(name) for name in self.changes.take_changed())

    def _view(self, name: str) -> ClosureView:
        view, decided = self._views[name]
        return replace(view, not_known_by=tuple(atv for atv, known in self._known.items() if known < decided))
