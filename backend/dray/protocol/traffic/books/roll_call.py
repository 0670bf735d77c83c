"""A roll call: too few keepers of a book remember it, so every vehicle is asked what it holds."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator

from dray.messages.floor.traffic import HoldsAsked, PlaceGranted, PlaceWished
from dray.protocol.runtime.life import Life
from dray.protocol.traffic.books.book import Book
from dray.protocol.traffic.numbers import ALONE_MAX, FAR, OUTBID_MAX, highest_believed

ROLL_S = 6.0
"""A roll is called for so long at least: every vehicle beats in that time, also one that the plant file does not know."""

WAVE = 200
"""Vehicles asked at one time, at most: a plant of a thousand is asked within `ROLL_S`, and no link or inbox is flooded."""

AGAIN_S, AGAIN_AT_MOST_S = 1.0, 5.0
"""Who has not told is asked again after this, doubled each time, up to as long as an idle vehicle is quiet anyway."""

BESIDE_MAX = 3
"""Keys that tell under the name of one vehicle, beside the first: with so many the roll call is not over before people have seen to it."""

RAISE_AGAIN_S = 30.0
"""Once in so long one vehicle lets a roll be called anew, since it knows of a later epoch: whoever says ever later ones holds nobody up for ever."""

QUIET_S = 6.0
"""When nobody new has told for so long the roll call stands still, and those that are missing are awaited by name: as long as
others tell, it is merely under way, however slow the machines are."""


class RollCall:
    """Of one district, by the keeper who will lead.

    Args:
        district: whose book is lost.
        next_turn: the next epoch after a given one under which this keeper may lead.
        now_s: when it begins.

    Attributes:
        told: vehicle -> what it has told.
        epoch: grants of earlier ones count for nothing.
    """

    def __init__(self, district: str, next_turn: Callable[[int], int], now_s: float, life: Life) -> None:
        self.told: dict[str, PlaceWished] = {}
        self._by_people: set[str] = set()
        """Vehicles of which a person has told that they are off the floor, or on their way back to it."""
        self._beside: dict[str, dict[bytes, PlaceWished]] = {}
        """Vehicle -> key -> what others have told in its name: nobody knows whose word it is, so the places of all of them are held."""
        self.epoch = next_turn(0)
        self._district, self._next_turn, self._life = district, next_turn, life
        self._until_s = now_s + ROLL_S
        self._news_s = now_s
        """When somebody has told for the first time, last."""
        self._raised_s: dict[str, float] = {}
        """Vehicle -> when it has let it be called anew last."""
        self._later: dict[str, int] = {}
        """Vehicle -> the latest epoch that it has told, of those that were later than this one."""
        self._asks: dict[str, tuple[float, float]] = {}
        """Vehicle -> when it is asked again, and how long after that once more."""

    def call(self, atvs: Iterable[str], now_s: float) -> None:
        """Ask those that have not told, and were not asked a moment ago."""
        asked = HoldsAsked(district=self._district, epoch=self.epoch, roll_call=True)
        room = WAVE
        for atv in atvs:
            at_s, then_s = self._asks.get(atv, (now_s, AGAIN_S))
            if atv in self.told or at_s > now_s:
                continue
            if not room:
                return
            room -= 1
            self._asks[atv] = (now_s + then_s, min(2.0 * then_s, AGAIN_AT_MOST_S))
            self._life.send(atv, asked)

    def note(self, atv: str, wish: PlaceWished, now_s: float, *, by_person: bool = False) -> bool:
        """A vehicle has told, or a person in its place; True when that counts."""
        if wish.epoch > FAR or wish.seen > FAR:
            # It lies: no book has come farther.
            return False
        if wish.epoch > self.epoch:
            if now_s - self._raised_s.get(atv, -RAISE_AGAIN_S) < RAISE_AGAIN_S:
                return False
            self._raised_s[atv] = now_s
            # The vehicle has known a later keeper: what was told under this epoch may have changed since. Alone it is not believed how much
            # later: the roll would be called under an epoch that no other one follows, or at the end of numbers.
            self._later[atv] = wish.epoch
            others = (epoch for other, epoch in self._later.items() if other != atv)
            known = max(self.epoch, min(max(others, default=0), ALONE_MAX))
            self.told, self.epoch = {}, self._next_turn(min(wish.epoch, known + OUTBID_MAX))
            self._by_people, self._beside = set(), {}
            self._asks, self._news_s = {}, now_s
            return False
        before = self.told.get(atv)
        is_beside = (
            before is not None
            and before.mark != wish.mark
            and not by_person
            and atv not in self._by_people
            and wish.epoch == self.epoch
        )
        if is_beside:
            return self._note_beside(atv, wish)
        if before is not None and before.mark in (wish.mark, b"") and wish.removal < before.removal:
            self._life.send(
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
            return False
        if wish.epoch < self.epoch:
            return False
        if before is not None and _age(wish) <= _age(before):
            return False
        if before is None:
            self._news_s = now_s
        self.told[atv] = wish
        (self._by_people.add if by_person else self._by_people.discard)(atv)
        return True

    def _note_beside(self, atv: str, wish: PlaceWished) -> bool:
        """Another one has told under this name, with another key. Of too many the vehicle itself may be one: all wait for people."""
        others = self._beside.setdefault(atv, {})
        before = others.get(wish.mark)
        if before is not None and _age(wish) <= _age(before):
            return False
        if before is None and len(others) >= BESIDE_MAX:
            return False
        others[wish.mark] = wish
        return True

    @property
    def keys(self) -> Iterator[tuple[str, bytes]]:
        """Who has told, with its key."""
        yield from ((atv, wish.mark) for atv, wish in self.told.items())
        yield from ((atv, mark) for atv, others in self._beside.items() for mark in others)

    def is_over(self, atvs: Callable[[], Iterable[str]], now_s: float) -> bool:
        """Whether all have told who may hold something."""
        return now_s >= self._until_s and all(self._has_told(atv) for atv in atvs())

    def awaited(self, atvs: Iterable[str], now_s: float) -> Iterator[str]:
        """Those that have not told, though whoever is awake has had the time."""
        if now_s >= max(self._until_s, self._news_s + QUIET_S):
            yield from (atv for atv in atvs if not self._has_told(atv))

    def _has_told(self, atv: str) -> bool:
        return atv in self.told and len(self._beside.get(atv, ())) < BESIDE_MAX

    def book(self, may_hold: Callable[[str, Collection[str]], bool], version: int = 0) -> Book:
        """The book as they have told it; of two that hold one place the first counts.

        Args:
            may_hold: whether a vehicle is believed that it holds these places; else it has none.
            version: the highest of a copy that is known.
        """
        book = Book(version=highest_believed((wish.seen for wish in self.told.values()), version))
        for atv, wish in self.told.items():
            is_removed = atv in self._by_people
            book.remove(atv, wish.removal, None if is_removed else wish.mark)
            book.lives[atv] = (wish.mark, wish.life)
            for one in (wish, *self._beside.get(atv, {}).values()):
                if one.removal < wish.removal and is_removed:
                    continue
                if may_hold(atv, one.holds):
                    book.claim(atv, one)
        return book


def _age(wish: PlaceWished) -> tuple[int, int, int]:
    return wish.removal, wish.life, wish.seq
