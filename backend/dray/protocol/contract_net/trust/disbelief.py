"""Consequences of an implausible message: its sender is told why, and a fact records it.

At most once a minute per sender: constant nonsense must not fill a history, and a wrong clock repeats its error
with every bid.
"""

from __future__ import annotations

from dray.messages import Accepted, Bid, Disbelieved, Implausible, TakenOver
from dray.messages.fact import NotBelieved, WordDisbelieved
from dray.protocol.runtime.life import Life
from dray.protocol.runtime.throttle import Throttle


class Disbelief:
    """Tells contractors that they are not believed."""

    def __init__(self, life: Life) -> None:
        self._life = life
        self._throttle = Throttle()

    def tell(
        self,
        speaker: str,
        said: Bid | Accepted | TakenOver,
        reason: Implausible,
        now_s: float,
        clock_ahead_s: float = 0.0,
    ) -> None:
        """Record that a message is implausible, and tell its sender.

        Args:
            speaker: the sender.
            said: the message.
            reason: why it is not believed; counted.
            now_s: the present time.
            clock_ahead_s: how far the sender's clock is ahead, if that is the reason.
        """
        self._life.ignore(reason)
        if self._throttle.passes(speaker, now_s):
            self._life.send(speaker, Disbelieved(said.task, said.epoch, reason, clock_ahead_s))
            self._life.record(WordDisbelieved(speaker, said.task, reason, clock_ahead_s))


class DisbeliefHandling:
    """How a contractor handles disbelief: it goes on, and leaves the fault to people."""

    def __init__(self, life: Life) -> None:
        self._life = life
        self._throttle = Throttle()

    def on_disbelieved(self, sender: str, message: Disbelieved, now_s: float) -> None:
        """Record a fact, at most once a minute for each coordinator."""
        if not self._throttle.passes(sender, now_s):
            self._life.ignore("disbelief that was recorded within the last minute")
            return
        self._life.record(NotBelieved(by=sender, task=message.task, reason=message.reason))
