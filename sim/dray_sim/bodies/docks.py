"""The dock of a body: open for one vehicle and one load, once; shut for all others."""

from __future__ import annotations

from collections.abc import Iterator

SHUT = "the dock is shut"

WHATEVER = "", 0
"""Item and quantity of a dock that accepts any load, as a controller opens it."""


class OpenDocks:
    """The vehicles for which the dock of a workcell or a storage is open."""

    __slots__ = ("_open",)

    def __init__(self) -> None:
        self._open: dict[str, tuple[str, int]] = {}
        """Vehicle -> the item and quantity that it may carry in or out, once."""

    def __iter__(self) -> Iterator[str]:
        return iter(self._open)

    def open(self, vehicle: str, item: str, quantity: int) -> None:
        self._open[vehicle] = (item, quantity)

    def shut(self, vehicle: str) -> None:
        """Harmless when it was never open."""
        self._open.pop(vehicle, None)

    def shut_all(self) -> None:
        self._open.clear()

    def refusal(self, vehicle: str, item: str, quantity: int) -> str:
        """Why a vehicle may not load or unload this; empty when it may."""
        return "" if self._open.get(vehicle) in ((item, quantity), WHATEVER) else SHUT

    def refusal_of_part(self, vehicle: str, item: str, quantity: int) -> str:
        """Why a vehicle may not load or unload this quantity, or less than the dock was opened for; empty when it may."""
        opened = self._open.get(vehicle)
        if opened is None or quantity <= 0:
            return SHUT
        return "" if opened == WHATEVER or (opened[0] == item and quantity <= opened[1]) else SHUT
