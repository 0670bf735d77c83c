"""Retransmission: messages repeated until they are answered, so that a lost message costs only seconds."""

from __future__ import annotations

from typing import Final

from msgspec.structs import replace

from dray.messages import Accepted, TakenOver
from dray.protocol.runtime.events import Publish, Send
from dray.protocol.runtime.life import Life

ASK_AGAIN_S = 3.0
"""Interval of repetitions (s): many times the latency of a good link."""

FOR_EVER: Final = 0
"""No limit: a message is repeated until it is answered."""


class Said:
    """A repeated message.

    Attributes:
        effect: the message with its recipient.
        times: transmissions since the other side was last heard.
    """

    __slots__ = ("effect", "times")

    def __init__(self, effect: Send | Publish) -> None:
        self.effect = effect
        self.times = 0


class Retransmitter:
    """Messages repeated until they are answered: at most one per subject.

    All repetition in the protocol is done here, except regular messages without an answer (heartbeats, renewals of
    a reservation) and auction rounds.

    Args:
        alarm: first part of the alarms' names, ``(alarm, about)``. The owner calls `wake` when one is due.
        every_s: answer timeout.
        most: maximum transmissions without an answer; `FOR_EVER` for no limit.
    """

    __slots__ = ("_alarm", "_every_s", "_life", "_life", "_most", "_said")

    def __init__(self, alarm: str, life: Life, *, every_s: float = ASK_AGAIN_S, most: int = FOR_EVER) -> None:
        self._alarm = alarm
        self._life = life
        self._every_s = every_s
        self._most = most
        self._said: dict[str, Said] = {}
        """By subject: the repeated message."""

    def __contains__(self, about: str) -> bool:
        """Whether an answer is still awaited."""
        return about in self._said

    def say(self, about: str, effect: Send | Publish, now_s: float) -> None:
        """Send now, and repeat. A new message replaces the subject's earlier one; an equal message continues its count."""
        said = self._said.get(about)
        if said is None or said.effect != effect:
            self._said[about] = Said(effect)
        self._repeat(about, now_s)

    def wake(self, about: str, now_s: float) -> None:
        """Repeat after an alarm without an answer, unless the limit is reached (`is_exhausted`)."""
        if about in self._said and not self.is_exhausted(about):
            self._repeat(about, now_s)

    def is_exhausted(self, about: str) -> bool:
        """Whether the limit is reached without an answer."""
        said = self._said.get(about)
        return said is not None and self._most != FOR_EVER and said.times >= self._most

    def count_anew(self, about: str) -> None:
        """The other side lives and has not answered yet: reset the count."""
        said = self._said.get(about)
        if said is not None:
            said.times = 0

    def defer(self, about: str, again_s: float) -> None:
        """The other side lives and cannot answer yet: repeat at `again_s`."""
        if about in self._said:
            self.count_anew(about)
            self._life.alarm((self._alarm, about), again_s)

    def settle(self, about: str) -> None:
        """Stop repeating: the answer has come, or none is needed. Ignored if nothing is repeated."""
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
