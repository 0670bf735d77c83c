"""What follows from an implausible message: its sender is told why, and a fact records it.

Once a minute of every speaker: whoever says nonsense all the time must not fill anybody's history, and whoever has
a wrong clock says the same wrong thing with every bid.
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
        """Note that something said cannot be true, and let its speaker know.

        Args:
            speaker: who has said it.
            said: what.
            reason: why it is not believed, as it is counted.
            now_s: the present time.
            clock_ahead_s: how far the speaker's clock is ahead, if that is the reason.
        """
        self._life.ignore(reason)
        if self._throttle.passes(speaker, now_s):
            self._life.send(speaker, Disbelieved(said.task, said.epoch, reason, clock_ahead_s))
            self._life.record(WordDisbelieved(speaker, said.task, reason, clock_ahead_s))


class DisbeliefHandling:
    """What a contractor does when it hears that it is not believed: it goes on, and leaves it to people."""

    def __init__(self, life: Life) -> None:
        self._life = life
        self._throttle = Throttle()

    def on_disbelieved(self, sender: str, message: Disbelieved, now_s: float) -> None:
        """Record a fact, at most once a minute for each coordinator."""
        if not self._throttle.passes(sender, now_s):
            self._life.ignore("that it is not believed was noted before")
            return
        self._life.record(NotBelieved(by=sender, task=message.task, reason=message.reason))
