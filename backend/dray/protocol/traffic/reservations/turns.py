"""Turns decide which replica leads a reservation table: the next one, when those before it do not answer.

Replicas watch each other only when needed. A replica that gets the request of an unanswered vehicle asks the leader whether it
lives. A replica that is asked for its promise does the same: it does not rely on the report of another one.
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

NO_REPLICA = "a message about a table by an agent that does not keep it"
NOT_ITS_TURN = "a reservation table of a replica whose turn it is not"
BEYOND_NUMBERS = "an epoch that is too high"

ASK_S = 0.5
"""Interval between two questions to a replica whether it lives."""

DOUBT_S = 2.5
"""Time, and five questions, without an answer until a replica counts as dead: at 20 % loss each way, 1 of 160 living ones."""

SILENT_AFTER = 4
"""Unanswered questions, `ASK_S` apart, until a replica counts as silent: at 20 % loss each way, 1 of 60 living ones."""

WATCH_S = 1.5
"""Time to watch the leader: a replica that seeks a promise, or reports the leader silent, repeats it within this."""

NO_WORD_S = float("-inf")


class Turns:
    """What one replica knows about the others.

    Args:
        me: the replica.
        replicas: all of them, in the order of their turns.
    """

    def __init__(self, me: str, replicas: Sequence[str]) -> None:
        self._me, self._replicas = me, tuple(replicas)
        self._heard_s: dict[str, float] = {}
        self._doubted_s: float | None = None
        """Since when the replicas before this one are in doubt; None when they are not."""
        self._watched_s = NO_WORD_S
        """When another replica last cast doubt on the leader."""
        self._questions: dict[str, tuple[int, float]] = {}
        """Replica -> number of unanswered questions, and the time of the last one counted."""

    def doubt(self, now_s: float) -> bool:
        """Note that the leader may not answer; False when it is in doubt already."""
        if self._doubted_s is not None:
            return False
        self._doubted_s = now_s
        return True

    def on_replica(self, replica: str, now_s: float) -> None:
        """A message of another replica has come: it lives."""
        if replica in self._replicas:
            self._heard_s[replica] = now_s
            self._questions.pop(replica, None)

    def watch(self, now_s: float) -> bool:
        """Another replica seeks the leadership, or reports the leader silent: watch the leader. True when that is news."""
        is_news = now_s - self._watched_s >= ASK_S
        if is_news:
            self._watched_s = now_s
        return is_news

    def is_watching(self, epoch: int, now_s: float) -> bool:
        """Whether the leader of an epoch is being watched, and was not heard since."""
        heard_s = self._heard_s.get(self.of(epoch), NO_WORD_S)
        return now_s - self._watched_s <= WATCH_S and heard_s < self._watched_s

    def on_question(self, replica: str, now_s: float) -> None:
        """Count a question to a replica whether it lives."""
        count, last_s = self._questions.get(replica, (0, now_s - ASK_S))
        if now_s - last_s >= ASK_S - 0.01:
            self._questions[replica] = (count + 1, now_s)

    def is_silent(self, replica: str, now_s: float) -> bool:
        """Whether a replica left too many of this one's questions unanswered."""
        count, last_s = self._questions.get(replica, (0, now_s))
        return count > SILENT_AFTER or (count == SILENT_AFTER and now_s - last_s >= ASK_S - 0.01)

    @property
    def others(self) -> tuple[str, ...]:
        """All replicas but this one."""
        return tuple(replica for replica in self._replicas if replica != self._me)

    def silent(self, now_s: float) -> tuple[str, ...]:
        """The other replicas that are silent."""
        return tuple(replica for replica in self.others if self.is_silent(replica, now_s))

    def of(self, epoch: int) -> str:
        """The replica whose turn an epoch is."""
        return self._replicas[epoch % len(self._replicas)]

    def objection(self, sender: str, message: Message) -> str:
        """Why a message is rejected, empty for no reason: only replicas may send it, and only the leader writes."""
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
        """The replicas to ask whether they live. In doubt these are all others, so that they watch the leader, too."""
        if self._doubted_s is not None:
            return self.others
        return self._before(epoch)[:1] if self.is_watching(epoch, now_s) else ()

    def mine_at_s(self, epoch: int, now_s: float) -> float:
        """When this replica's turn comes, if none of those before it is heard until then; never without doubt."""
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
        """Take this replica's turn: the doubt is over."""
        self._doubted_s = None

    def _before(self, epoch: int) -> tuple[str, ...]:
        before: list[str] = []
        while (replica := self.of(epoch + len(before))) != self._me:
            before.append(replica)
        return tuple(before)
