"""Retransmission: messages that are repeated until they are answered, so that a lost message costs seconds only."""

from __future__ import annotations

from typing import Final

from msgspec.structs import replace

from dray.messages import Accepted, TakenOver
from dray.protocol.runtime.events import Publish, Send
from dray.protocol.runtime.life import Life

ASK_AGAIN_S = 3.0
"""Many times the latency of a good link."""

FOR_EVER: Final = 0
"""No bound: it is said until it is answered."""


class Said:
    """What is repeated.

    Attributes:
        effect: to whom, and what.
        times: how often it was said since the other side was heard last.
    """

    __slots__ = ("effect", "times")

    def __init__(self, effect: Send | Publish) -> None:
        self.effect = effect
        self.times = 0


class Retransmitter:
    """Messages that are repeated until they are answered: at most one about each subject.

    All repetition of messages in the protocol is done here. What is said regularly whether or not somebody answers (heartbeats,
    renewals of a reservation) and what is announced in rounds (auctions) is no repetition.

    Args:
        alarm: names the alarms, ``(alarm, about)``. Whoever owns them calls `wake` when one has come.
        every_s: how long an answer is waited for.
        most: how often a message is said without an answer; `FOR_EVER` for no bound.
    """

    __slots__ = ("_alarm", "_every_s", "_life", "_life", "_most", "_said")

    def __init__(self, alarm: str, life: Life, *, every_s: float = ASK_AGAIN_S, most: int = FOR_EVER) -> None:
        self._alarm = alarm
        self._life = life
        self._every_s = every_s
        self._most = most
        self._said: dict[str, Said] = {}
        """By subject."""

    def __contains__(self, about: str) -> bool:
        """Whether an answer is still waited for."""
        return about in self._said

    def say(self, about: str, effect: Send | Publish, now_s: float) -> None:
        """Say this now, and again. It replaces what was said before about the subject; the same once more is counted on."""
        said = self._said.get(about)
        if said is None or said.effect != effect:
            self._said[about] = Said(effect)
        self._repeat(about, now_s)

    def wake(self, about: str, now_s: float) -> None:
        """The alarm has come, and no answer: say it again, unless it was said often enough (`is_exhausted`)."""
        if about in self._said and not self.is_exhausted(about):
            self._repeat(about, now_s)

    def is_exhausted(self, about: str) -> bool:
        """Whether it was said as often as it may be, without an answer."""
        said = self._said.get(about)
        return said is not None and self._most != FOR_EVER and said.times >= self._most

    def count_anew(self, about: str) -> None:
        """The other side lives, and has not answered yet: count its repetitions from zero."""
        said = self._said.get(about)
        if said is not None:
            said.times = 0

    def defer(self, about: str, again_s: float) -> None:
        """The other side lives, and cannot answer yet: say it again at `again_s`."""
        if about in self._said:
            self.count_anew(about)
            self._life.alarm((self._alarm, about), again_s)

    def settle(self, about: str) -> None:
        """Stop repeating: it was answered, or no answer is needed any more. Harmless when nothing was being repeated."""
        self._said.pop(about, None)
        self._life.cancel((self._alarm, about))

    def _repeat(self, about: str, now_s: float) -> None:
        said = self._said[about]
        said.times += 1
        effect, message = said.effect, said.effect.message
        if isinstance(message, Accepted | TakenOver):
            effect = replace(effect, message=replace(message, at_s=now_s))
        self._life.do(effect)
        self._life.alarm((self._alarm, about), now_s + self._every_s)
