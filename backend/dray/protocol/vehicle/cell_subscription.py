"""Where a vehicle listens for work: announcements go to the grid cells that they concern."""

from __future__ import annotations

from dray.messages.keys import Keys
from dray.plant import Plant
from dray.protocol.runtime.events import Effect, Subscribe, Unsubscribe


class CellSubscription:
    """The announcements that one vehicle hears: those for the cell that it is in.

    Args:
        plant: its cells.
        keys: the plant's bus keys.
        out: where effects go.
    """

    __slots__ = ("_cell", "_keys", "_out", "_plant")

    def __init__(self, plant: Plant, keys: Keys, out: list[Effect]) -> None:
        self._plant = plant
        self._keys = keys
        self._out = out
        self._cell = ""
        """Empty before the vehicle knows where it is."""

    def move(self, x_m: float, y_m: float) -> None:
        """The vehicle is here now."""
        cell = self._plant.cell_of(x_m, y_m)
        if cell == self._cell:
            return
        if self._cell:
            self._out.append(Unsubscribe(self._keys.transports(self._cell)))
        self._out.append(Subscribe(self._keys.transports(cell)))
        self._cell = cell
