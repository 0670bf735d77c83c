"""Whose turn it is to keep a book: the next keeper's, when those before it are silent."""

from __future__ import annotations

from collections.abc import Sequence

from dray.messages import Message
from dray.messages.traffic import PlaceBooked, PlaceWished
from dray.protocol.traffic.neighbours import SILENT_S

NO_KEEPER = "the word of somebody who does not keep this book"
NOT_ITS_TURN = "a book written by one whose turn it is not"


class Turns:
    """What one keeper has heard of the others.

    Args:
        me: the keeper.
        keepers: all of them, in the order of their turns.
    """

    def __init__(self, me: str, keepers: Sequence[str]) -> None:
        self._me, self._keepers = me, tuple(keepers)
        self._heard_s: dict[str, float] = {}

    def start(self, now_s: float) -> None:
        """Count as heard whoever has had no time to speak."""
        self._heard_s = dict.fromkeys(self._keepers, now_s)

    def on_keeper(self, keeper: str, now_s: float) -> None:
        """Another keeper lives."""
        if keeper in self._heard_s:
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

    def mine_at_s(self, epoch: int, now_s: float) -> float:
        """When it is this keeper's turn, if none of those before it is heard until then."""
        at_s = now_s
        while (keeper := self.of(epoch)) != self._me:
            at_s = max(at_s, self._heard_s.get(keeper, now_s) + SILENT_S)
            epoch += 1
        return at_s
