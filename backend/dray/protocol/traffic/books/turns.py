"""Whose turn it is to keep a book: the next keeper's, when those before it do not answer.

Nobody watches a keeper of whom nobody wants anything. Whoever is asked in its place, by a vehicle that had no answer, asks it
whether it lives. So does another keeper that is asked for its promise: it takes nobody's word for it.
"""

from __future__ import annotations

from collections.abc import Sequence

from dray.messages import Message
from dray.messages.floor.traffic import BookAsked, BookKept, BookTold, PlaceBooked, PlaceWished
from dray.protocol.runtime.events import NEVER_S
from dray.protocol.traffic.numbers import FAR

NO_KEEPER = "the word of somebody who does not keep this book"
NOT_ITS_TURN = "a book written by one whose turn it is not"
BEYOND_NUMBERS = "an epoch to which no book has come"

ASK_S = 0.5
"""Between two questions to a keeper whether it lives."""

DOUBT_S = 2.5
"""Who has not answered after this, and five questions, is taken for dead: at 20 % loss each way one of 160 that live."""

SILENT_AFTER = 4
"""Questions without an answer, `ASK_S` apart: at 20 % loss each way one of 60 that live; then somebody else keeps the book."""

WATCH_S = 1.5
"""Whoever asks for a promise, or says that somebody does not answer, says so again within this."""

NO_WORD_S = float("-inf")


class Turns:
    """What one keeper knows of the others.

    Args:
        me: the keeper.
        keepers: all of them, in the order of their turns.
    """

    def __init__(self, me: str, keepers: Sequence[str]) -> None:
        self._me, self._keepers = me, tuple(keepers)
        self._heard_s: dict[str, float] = {}
        self._doubted_s: float | None = None
        """Since when it is not known whether those before it live; None while nobody doubts it."""
        self._watched_s = NO_WORD_S
        """When another keeper has said last that it doubts the present one."""
        self._questions: dict[str, tuple[int, float]] = {}
        """Keeper -> questions that it has not answered, and when it was asked the last of them that counts."""

    def doubt(self, now_s: float) -> bool:
        """Somebody has had no answer from the one whose turn it is; False when that is known."""
        if self._doubted_s is not None:
            return False
        self._doubted_s = now_s
        return True

    def on_keeper(self, keeper: str, now_s: float) -> None:
        """Another keeper lives."""
        if keeper in self._keepers:
            self._heard_s[keeper] = now_s
            self._questions.pop(keeper, None)

    def watch(self, now_s: float) -> bool:
        """Another keeper wants what the present one has, or says that it does not answer: find that out. Whether that is news."""
        is_news = now_s - self._watched_s >= ASK_S
        if is_news:
            self._watched_s = now_s
        return is_news

    def is_watching(self, epoch: int, now_s: float) -> bool:
        """Whether that is not long ago, and the present keeper has not been heard since."""
        heard_s = self._heard_s.get(self.of(epoch), NO_WORD_S)
        return now_s - self._watched_s <= WATCH_S and heard_s < self._watched_s

    def on_question(self, keeper: str, now_s: float) -> None:
        """A keeper was asked whether it lives."""
        count, last_s = self._questions.get(keeper, (0, now_s - ASK_S))
        if now_s - last_s >= ASK_S - 0.01:
            self._questions[keeper] = (count + 1, now_s)

    def is_silent(self, keeper: str, now_s: float) -> bool:
        """Whether a keeper has not answered this one."""
        count, last_s = self._questions.get(keeper, (0, now_s))
        return count > SILENT_AFTER or (count == SILENT_AFTER and now_s - last_s >= ASK_S - 0.01)

    @property
    def others(self) -> tuple[str, ...]:
        """All but this one."""
        return tuple(keeper for keeper in self._keepers if keeper != self._me)

    def silent(self, now_s: float) -> tuple[str, ...]:
        """Those that have not answered this one."""
        return tuple(keeper for keeper in self.others if self.is_silent(keeper, now_s))

    def of(self, epoch: int) -> str:
        """Whose turn an epoch is."""
        return self._keepers[epoch % len(self._keepers)]

    def objection(self, sender: str, message: Message) -> str:
        """Why a message is not believed, whatever it says: among keepers only keepers count, and only one of them writes."""
        if isinstance(message, PlaceWished):
            return ""
        if sender not in self._keepers:
            return NO_KEEPER
        if isinstance(message, PlaceBooked) and self.of(message.epoch) != sender:
            return NOT_ITS_TURN
        if isinstance(message, PlaceBooked | BookKept | BookAsked | BookTold) and message.epoch > FAR:
            return BEYOND_NUMBERS
        if isinstance(message, BookTold) and message.kept_epoch > message.epoch:
            return BEYOND_NUMBERS
        return ""

    def asked(self, epoch: int, now_s: float) -> tuple[str, ...]:
        """Who is to be asked whether he lives: while it is doubted all others, for they are to find out, too."""
        if self._doubted_s is not None:
            return self.others
        return self._before(epoch)[:1] if self.is_watching(epoch, now_s) else ()

    def mine_at_s(self, epoch: int, now_s: float) -> float:
        """When it is this keeper's turn, if none of those before it is heard until then; never while nobody doubts that they live."""
        before = self._before(epoch)
        if not before:
            return now_s
        doubted_s = self._doubted_s
        if doubted_s is not None and any(
            self._heard_s.get(keeper, NO_WORD_S) >= doubted_s for keeper in before
        ):
            self._doubted_s = doubted_s = None
        return NEVER_S if doubted_s is None else doubted_s + DOUBT_S

    def lead(self) -> None:
        """It is this keeper's turn: there is nothing to doubt."""
        self._doubted_s = None

    def _before(self, epoch: int) -> tuple[str, ...]:
        before: list[str] = []
        while (keeper := self.of(epoch + len(before))) != self._me:
            before.append(keeper)
        return tuple(before)
