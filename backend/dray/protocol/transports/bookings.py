"""Vehicle reports that a dock's body was told (`Book`) and has not answered yet.

A report is stored before the body is told, and repeated after a restart. A body that has heard a report before
books nothing twice.
"""

from __future__ import annotations

from collections.abc import Iterable

from dray.body import Book, StockChanged
from dray.memory import DepartureMemory
from dray.protocol.runtime.bounded_map import BoundedMap
from dray.protocol.runtime.life import Life

WORDS_KEPT = 256
"""Maximum unanswered reports: as many as a body remembers."""


class Bookings:
    """The unanswered reports of one dock."""

    def __init__(self, life: Life) -> None:
        self._life = life
        self._said: BoundedMap[tuple[str, str, str, int, bool], DepartureMemory] = BoundedMap(WORDS_KEPT)
        """Unanswered reports by their key, the oldest first."""

    def say(self, load: DepartureMemory) -> None:
        """Tell the body what a vehicle has put down or taken. An unanswered report is not sent again."""
        name = (load.vehicle, load.item, load.task, load.epoch, load.change > 0)
        if name in self._said:
            return  # The body would answer twice, and the second answer would match another report.
        self._said[name] = load
        book = Book(load.vehicle, load.item, load.change, task=load.task, epoch=load.epoch)
        self._life.instruct(book)
        self._life.commit()

    def on_stock_changed(self, report: StockChanged) -> DepartureMemory | None:
        """Handle a booking of the body.

        Returns:
            The oldest report of that vehicle about that item, because the body answers in order. None if no report
                waits for an answer.
        """
        told = (report.vehicle, report.item)
        word = next((each for each in self._said if each[:2] == told), None)
        if word is None:
            return None
        self._life.commit()
        return self._said.pop(word)

    def memories(self) -> tuple[DepartureMemory, ...]:
        """The unanswered reports, also for the next life to repeat."""
        return tuple(self._said.values())

    def restore(self, memories: Iterable[DepartureMemory]) -> None:
        """Repeat the reports that an earlier life had no answer to."""
        for load in memories:
            self.say(load)
