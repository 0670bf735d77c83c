"""Late tellers: vehicles of which nobody knew when the roll was called. They tell afterwards what they hold."""

from __future__ import annotations

from collections.abc import Iterable

from dray.messages.floor.traffic import PlaceWished
from dray.protocol.traffic.books.book import Book
from dray.protocol.traffic.books.reach import Reach
from dray.protocol.traffic.books.roll_call import BESIDE_MAX
from dray.protocol.traffic.numbers import FAR


class LateTellers:
    """Of one book.

    Args:
        reach: how much of the floor one vehicle may have.

    Attributes:
        unknown: those that say to hold something; it is not known whether they are there.
    """

    def __init__(self, reach: Reach) -> None:
        self._reach = reach
        self._told: set[tuple[str, bytes]] | None = None
        """Who has told, with its key; None where the book was not made from a roll call."""
        self.unknown: set[str] = set()

    def start(self, told: Iterable[tuple[str, bytes]] | None) -> None:
        """A book begins.

        Args:
            told: who has told in the roll call from which it was made, with its key; None where it was made otherwise.
        """
        self._told = None if told is None else set(told)
        self.unknown = set()

    def on_wish(self, atv: str, wish: PlaceWished, book: Book, now_s: float) -> bool:
        """A vehicle says what it holds: one that has not told before tells now, and the book is changed.

        Returns:
            Whether its word counts; else it is not known yet whether it is there, and it will say it again.
        """
        if self._told is None or (atv, wish.mark) in self._told:
            return True
        if wish.removal < book.removal_of(atv):
            # Whatever it holds is void by a person's word.
            return True
        others = sum(one == atv for one, _ in self._told)
        if others and (not wish.holds or others > BESIDE_MAX):
            # It has nothing to tell that would not come as well after the roll call.
            return True
        if wish.seen > FAR or not self._reach.may_hold(atv, wish.holds, now_s):
            self.unknown.add(atv)
            return False
        self.unknown.discard(atv)
        self._told.add((atv, wish.mark))
        book.tell_late(atv, wish)
        return True
