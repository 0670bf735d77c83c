"""Injected faults, begun by hand, as panels see them."""

from __future__ import annotations

from dray.gateway.live.projection.changes import Changes
from dray.gateway.live.views import FaultView


class InjectedFaults:
    """Active faults. The fault injection puts and drops them here.

    Args:
        possible: whether faults can be begun at all.
    """

    def __init__(self, *, possible: bool) -> None:
        self.possible = possible
        self._faults: dict[str, FaultView] = {}
        self.changes = Changes("fault")

    def put(self, fault: FaultView) -> None:
        """Show a fault that has begun."""
        self._faults[fault.id] = fault
        self.changes.mark(fault.id)

    def drop(self, fault: str) -> None:
        """Drop a fault that has ended; harmless when done twice."""
        if self._faults.pop(fault, None) is not None:
            self.changes.drop(fault)

    def views(self) -> tuple[FaultView, ...]:
        """The active faults, oldest first."""
        return tuple(self._faults.values())

    def take_changed(self) -> tuple[FaultView, ...]:
        """Faults that have begun since the last call."""
        return tuple(self._faults[fault] for fault in self.changes.take_changed())
