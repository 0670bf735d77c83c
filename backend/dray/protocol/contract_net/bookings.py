"""Words of vehicles that the body of a dock was told (`Book`), until it has answered.

Notes are written before the body is told: a life that ends in between has told nothing. The next one says the word again, and a body that has heard
it before books nothing twice.
"""

from __future__ import annotations

from collections.abc import Iterable

from dray.body import Book, StockChanged
from dray.memory import DepartureMemory
from dray.protocol.runtime.bounded_map import BoundedMap
from dray.protocol.runtime.life import Life

WORDS_KEPT = 256
"""Words that are said again: as many as a body remembers."""


class Bookings:
    """Of one dock."""

    def __init__(self, life: Life) -> None:
        self._life = life
        self._said: BoundedMap[tuple[str, str, str, int, bool], DepartureMemory] = BoundedMap(WORDS_KEPT)
        """What was said and is not answered, by what names a word, the oldest first."""

    def say(self, load: DepartureMemory) -> None:
        """Tell the body what a vehicle has put down or taken. Harmless while it has not answered the same word."""
        name = (load.vehicle, load.item, load.task, load.epoch, load.change > 0)
        if name in self._said:
            return  # It would answer twice, the second time for another word.
        self._said[name] = load
        book = Book(load.vehicle, load.item, load.change, task=load.task, epoch=load.epoch)
        self._life.instruct(book)
        self._life.commit()

    def on_stock_changed(self, report: StockChanged) -> DepartureMemory | None:
        """The body has booked something.

        Returns:
            The word that it has answered: of that vehicle's about that item the oldest, for it answers in the order in which they were said. None
            for no word that waits for an answer.
        """
        told = (report.vehicle, report.item)
        word = next((each for each in self._said if each[:2] == told), None)
        if word is None:
            return None
        self._life.commit()
        return self._said.pop(word)

    def memories(self) -> tuple[DepartureMemory, ...]:
        """For the next life, which says them again."""
        return tuple(self._said.values())

    def restore(self, memories: Iterable[DepartureMemory]) -> None:
        """Say again what an earlier life has had no answer to."""
        for load in memories:
            self.say(load)
