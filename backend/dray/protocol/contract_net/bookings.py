"""Words of vehicles that the body of a dock was told (`Book`), until it has answered.

Notes are written before the body is told: a life that ends in between has told nothing. The next one says the word again, and a body that has heard
it before books nothing twice.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from dray.body import Book, StockChanged
from dray.memory import DepartureMemory
from dray.protocol.runtime.events import Effect, Instruct


class Bookings:
    """Of one dock.

    Args:
        out: where effects go.
        commit: called when the next life must know of something else.
    """

    def __init__(self, out: list[Effect], commit: Callable[[], None]) -> None:
        self._out, self._commit = out, commit
        self._said: dict[tuple[str, str], DepartureMemory] = {}
        """By vehicle and item, what was said last and is not answered."""

    def say(self, load: DepartureMemory) -> None:
        """Tell the body what a vehicle has put down or taken."""
        self._said[load.vehicle, load.item] = load
        book = Book(load.vehicle, load.item, load.change, task=load.task, epoch=load.epoch)
        self._out.append(Instruct(book))
        self._commit()

    def on_stock_changed(self, report: StockChanged) -> None:
        """The body has booked something."""
        if self._said.pop((report.vehicle, report.item), None) is not None:
            self._commit()

    def memories(self) -> tuple[DepartureMemory, ...]:
        """For the next life, which says them again."""
        return tuple(self._said.values())

    def restore(self, memories: Iterable[DepartureMemory]) -> None:
        """Say again what an earlier life has had no answer to."""
        for load in memories:
            self.say(load)
