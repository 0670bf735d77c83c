"""A roll call: too few keepers of a book remember it, so every vehicle is asked what it holds."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

from dray.messages.traffic import HoldsAsked, PlaceGranted, PlaceWished
from dray.protocol.runtime.events import Effect, Send
from dray.protocol.traffic.books.book import Book

ROLL_S = 6.0
"""A roll is called for so long at least: every vehicle beats in that time, also one that the plant file does not know."""


class RollCall:
    """Of one district, by the keeper who will lead.

    Args:
        district: whose book is lost.
        next_turn: the next epoch after a given one under which this keeper may lead.
        now_s: when it begins.
        out: where effects go.

    Attributes:
        told: vehicle -> what it has told.
        epoch: grants of earlier ones count for nothing.
    """

    def __init__(
        self, district: str, next_turn: Callable[[int], int], now_s: float, out: list[Effect]
    ) -> None:
        self.told: dict[str, PlaceWished] = {}
        self.epoch = next_turn(0)
        self._district, self._next_turn, self._out = district, next_turn, out
        self._until_s = now_s + ROLL_S

    def call(self, atvs: Iterable[str]) -> None:
        """Ask those that have not told."""
        asked = HoldsAsked(district=self._district, epoch=self.epoch, roll_call=True)
        self._out += [Send(atv, asked) for atv in atvs if atv not in self.told]

    def note(self, atv: str, wish: PlaceWished, atvs: Iterable[str]) -> bool:
        """A vehicle has told, or a person in its place; True when that counts."""
        if wish.epoch > self.epoch:
            # The vehicle has known a later keeper: what was told under this epoch may have changed since.
            self.told, self.epoch = {}, self._next_turn(wish.epoch)
            self.call(atvs)
            return False
        before = self.told.get(atv)
        if before is not None and wish.removal < before.removal:
            self._out.append(
                Send(
                    atv,
                    PlaceGranted(
                        district=self._district,
                        epoch=self.epoch,
                        life=wish.life,
                        upto=0,
                        grants=(),
                        removal=before.removal,
                    ),
                )
            )
            return False
        if wish.epoch < self.epoch:
            return False
        if before is not None and _age(wish) <= _age(before):
            return False
        self.told[atv] = wish
        return True

    def is_over(self, atvs: Iterable[str], now_s: float) -> bool:
        """Whether all have told who may hold something."""
        return now_s >= self._until_s and all(atv in self.told for atv in atvs)

    def awaited(self, atvs: Iterable[str], now_s: float) -> Iterator[str]:
        """Those that have not told, though whoever is awake has had the time."""
        if now_s >= self._until_s:
            yield from (atv for atv in atvs if atv not in self.told)

    def book(self) -> Book:
        """The book as they have told it; of two that hold one place the first counts."""
        book = Book(version=max((wish.seen for wish in self.told.values()), default=0))
        for atv, wish in self.told.items():
            book.remove(atv, wish.removal)
            book.lives[atv] = wish.life
            book.claim(atv, wish.holds)
        return book


def _age(wish: PlaceWished) -> tuple[int, int, int]:
    return wish.removal, wish.life, wish.seq
