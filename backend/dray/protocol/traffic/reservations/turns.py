"""Whose turn it is to keep a reservation table: the next replica's, when those before it do not answer.

Nobody watches a replica of whom nobody wants anything. Whoever is asked in its place, by a vehicle that had no answer, asks it
whether it lives. So does another replica that is asked for its promise: it takes nobody's word for it.
"""

from __future__ import annotations

from collections.abc import Sequence

from dray.messages import Message
from dray.messages.floor.traffic import (
    PlaceRequested,
    TableAcknowledged,
    TableAsked,
    TableReplicated,
    TableReported,
)
from dray.protocol.runtime.events import NEVER_S
from dray.protocol.traffic.numbers import FAR

NO_REPLICA = "the word of somebody who does not keep this table"
NOT_ITS_TURN = "a reservation table written by one whose turn it is not"
BEYOND_NUMBERS = "an epoch to which no reservation table has come"

ASK_S = 0.5
"""Between two questions to a replica whether it lives."""

DOUBT_S = 2.5
"""Who has not answered after this, and five questions, is taken for dead: at 20 % loss each way one of 160 that live."""

SILENT_AFTER = 4
"""Questions without an answer, `ASK_S` apart: at 20 % loss each way one of 60 that live; then somebody else keeps the table."""

WATCH_S = 1.5
"""Whoever asks for a promise, or says that somebody does not answer, says so again within this."""

NO_WORD_S = float("-inf")


class Turns:
    """What one replica knows of the others.

    Args:
        me: the replica.
        replicas: all of them, in the order of their turns.
    """

    def __init__(self, me: str, replicas: Sequence[str]) -> None:
        self._me, self._replicas = me, tuple(replicas)
        self._heard_s: dict[str, float] = {}
        self._doubted_s: float | None = None
        """Since when it is not known whether those before it live; None while nobody doubts it."""
        self._watched_s = NO_WORD_S
        """When another replica has said last that it doubts the present one."""
        self._questions: dict[str, tuple[int, float]] = {}
        """Replica -> questions that it has not answered, and when it was asked the last of them that counts."""

    def doubt(self, now_s: float) -> bool:
        """Somebody has had no answer from the one whose turn it is; False when that is known."""
        if self._doubted_s is not None:
            return False
        self._doubted_s = now_s
        return True

    def on_replica(self, replica: str, now_s: float) -> None:
        """Another replica lives."""
        if replica in self._replicas:
            self._heard_s[replica] = now_s
            self._questions.pop(replica, None)

    def watch(self, now_s: float) -> bool:
        """Another replica wants what the present one has, or says that it does not answer: find that out. Whether that is news."""
        is_news = now_s - self._watched_s >= ASK_S
        if is_news:
            self._watched_s = now_s
        return is_news

    def is_watching(self, epoch: int, now_s: float) -> bool:
        """Whether that is not long ago, and the present leader has not been heard since."""
        heard_s = self._heard_s.get(self.of(epoch), NO_WORD_S)
        return now_s - self._watched_s <= WATCH_S and heard_s < self._watched_s

    def on_question(self, replica: str, now_s: float) -> None:
        """A replica was asked whether it lives."""
        count, last_s = self._questions.get(replica, (0, now_s - ASK_S))
        if now_s - last_s >= ASK_S - 0.01:
            self._questions[replica] = (count + 1, now_s)

    def is_silent(self, replica: str, now_s: float) -> bool:
        """Whether a replica has not answered this one."""
        count, last_s = self._questions.get(replica, (0, now_s))
        return count > SILENT_AFTER or (count == SILENT_AFTER and now_s - last_s >= ASK_S - 0.01)

    @property
    def others(self) -> tuple[str, ...]:
        """All but this one."""
        return tuple(replica for replica in self._replicas if replica != self._me)

    def silent(self, now_s: float) -> tuple[str, ...]:
        """Those that have not answered this one."""
        return tuple(replica for replica in self.others if self.is_silent(replica, now_s))

    def of(self, epoch: int) -> str:
        """Whose turn an epoch is."""
        return self._replicas[epoch % len(self._replicas)]

    def objection(self, sender: str, message: Message) -> str:
        """Why a message is not believed, whatever it says: among replicas only replicas count, and only one of them writes."""
        if isinstance(message, PlaceRequested):
            return ""
        if sender not in self._replicas:
            return NO_REPLICA
        if isinstance(message, TableReplicated) and self.of(message.epoch) != sender:
            return NOT_ITS_TURN
        if (
            isinstance(message, TableReplicated | TableAcknowledged | TableAsked | TableReported)
            and message.epoch > FAR
        ):
            return BEYOND_NUMBERS
        if isinstance(message, TableReported) and message.kept_epoch > message.epoch:
            return BEYOND_NUMBERS
        return ""

    def asked(self, epoch: int, now_s: float) -> tuple[str, ...]:
        """Who is to be asked whether he lives: while it is doubted all others, for they are to find out, too."""
        if self._doubted_s is not None:
            return self.others
        return self._before(epoch)[:1] if self.is_watching(epoch, now_s) else ()

    def mine_at_s(self, epoch: int, now_s: float) -> float:
        """When it is this replica's turn, if none of those before it is heard until then; never while nobody doubts that they live."""
        before = self._before(epoch)
        if not before:
            return now_s
        doubted_s = self._doubted_s
        if doubted_s is not None and any(
            self._heard_s.get(replica, NO_WORD_S) >= doubted_s for replica in before
        ):
            self._doubted_s = doubted_s = None
        return NEVER_S if doubted_s is None else doubted_s + DOUBT_S

    def lead(self) -> None:
        """It is this replica's turn: there is nothing to doubt."""
        self._doubted_s = None

    def _before(self, epoch: int) -> tuple[str, ...]:
        before: list[str] = []
        while (replica := self.of(epoch + len(before))) != self._me:
            before.append(replica)
        return tuple(before)
