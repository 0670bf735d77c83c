"""Whose turn it is to keep a book: the next keeper's, when those before it do not answer.

Nobody watches a keeper of whom nobody wants anything. Whoever is asked in its place, by a vehicle that had no answer, asks it
whether it lives.
"""

from __future__ import annotations

from collections.abc import Sequence

from dray.messages import Message
from dray.messages.floor.traffic import PlaceBooked, PlaceWished
from dray.protocol.runtime.events import NEVER_S

NO_KEEPER = "the word of somebody who does not keep this book"
NOT_ITS_TURN = "a book written by one whose turn it is not"

ASK_S = 0.5
"""Between two questions to a keeper whether it lives."""

DOUBT_S = 2.5
"""Who has not answered after this, and five questions, is taken for dead: at 20 % loss each way one of 160 that live."""


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
        return ""

    def asked(self, epoch: int) -> tuple[str, ...]:
        """Who is to be asked whether he lives: those whose turn comes before, while it is doubted."""
        return () if self._doubted_s is None else self._before(epoch)

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
