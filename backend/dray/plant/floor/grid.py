"""The grid of cells that announcements are addressed to.

A vehicle subscribes to its own cell, and a machine announces to the cells within its radius. So the cost of an
announcement depends on the radius, not on the size of the plant.
"""

from __future__ import annotations

from functools import lru_cache
from math import ceil

CIRCLES_KEPT = 4096
"""Circles whose cells are remembered: a machine asks from one place with a handful of radii."""


class Grid:
    """A floor cut into square cells; `2_1` is the third column from the left, second row from below.

    Args:
        width_m: extent of the floor along x, from 0.
        height_m: extent of the floor along y, from 0.
        cell_m: edge of a cell; the last column and row may reach beyond the floor.
    """

    __slots__ = ("_cell_m", "_columns", "_rows", "within")

    def __init__(self, width_m: float, height_m: float, cell_m: float) -> None:
        self._cell_m = cell_m
        self._columns = max(1, ceil(width_m / cell_m))
        self._rows = max(1, ceil(height_m / cell_m))
        self.within = lru_cache(CIRCLES_KEPT)(self._within)
        """`_within`, remembered."""

    def cell_of(self, x_m: float, y_m: float) -> str:
        """The cell of a point; one beyond the floor counts to the nearest column and row."""
        return f"{_clip(x_m / self._cell_m, self._columns)}_{_clip(y_m / self._cell_m, self._rows)}"

    def _within(self, x_m: float, y_m: float, radius_m: float) -> tuple[str, ...]:
        """The cells whose square has a point in common with a circle, by column, then row."""
        cell_m = self._cell_m
        columns = range(
            _clip((x_m - radius_m) / cell_m, self._columns),
            _clip((x_m + radius_m) / cell_m, self._columns) + 1,
        )
        rows = range(
            _clip((y_m - radius_m) / cell_m, self._rows), _clip((y_m + radius_m) / cell_m, self._rows) + 1
        )
        square_m2 = radius_m * radius_m
        cells = []
        for column in columns:
            gap_x_m = _gap(x_m, column * cell_m, (column + 1) * cell_m)
            for row in rows:
                gap_y_m = _gap(y_m, row * cell_m, (row + 1) * cell_m)
                if gap_x_m * gap_x_m + gap_y_m * gap_y_m <= square_m2:
                    cells.append(f"{column}_{row}")
        return tuple(cells)


def _clip(index: float, count: int) -> int:
    """A whole index from 0 to `count` - 1; an infinite one is clipped like any other."""
    return int(min(max(index, 0.0), count - 1.0))


def _gap(value_m: float, low_m: float, high_m: float) -> float:
    """Distance of a value outside of an interval; 0 inside."""
    return max(low_m - value_m, 0.0, value_m - high_m)
