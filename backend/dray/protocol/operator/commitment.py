"""The one call that an operator has taken, or is about to take."""

from __future__ import annotations

from dray.messages import CallState, HelpCall

AGAIN_S = 2.0
"""Interval of repetitions until the caller confirms (s)."""

GIVE_UP_S = 15.0
"""Time after which the person is told that the caller has not confirmed, and decides again (s)."""


class Commitment:
    """The operator's promise to a caller. Empty at first.

    Attributes:
        call, caller, goods: empty for none.
        until_s: the promised arrival (the operator's clock).
        waits: whether the caller has yet to confirm the last message.
        again_s, give_up_s: times of the next repetition and of giving up, while `waits`.
    """

    def __init__(self) -> None:
        self._turn = 0
        self.call = self.caller = self.goods = ""
        self.until_s: float | None = None
        self.waits = False
        self.again_s = self.give_up_s = 0.0
        self._told_s: float | None = None

    @property
    def subject(self) -> tuple[str, str]:
        """The subject of the call; see `HelpCall.subject`."""
        return self.caller, self.goods

    @property
    def confirmed(self) -> tuple[str, int] | None:
        """The call whose caller expects this operator, and its turn; None for none."""
        return (self.call, self._turn) if self._turn else None

    def take(self, call: HelpCall, until_s: float, now_s: float) -> None:
        """Take a call, or renew the promise; then wait for the caller's confirmation."""
        if self.call != call.call:
            self._turn, self._told_s = 0, None
        self.call, self.until_s = call.call, until_s
        self.caller, self.goods = call.subject
        self.waits, self.give_up_s = True, now_s + GIVE_UP_S

    def said(self, now_s: float) -> None:
        """Set the next repetition after a message to the caller."""
        self.again_s = now_s + AGAIN_S

    def confirm(self, call: HelpCall, now_s: float) -> None:
        """The caller confirms this operator and the time; a newer promise may not have reached it yet."""
        self.call, self._turn = call.call, call.turn
        self.caller, self.goods = call.subject
        self._told_s = None if call.until_s is None else now_s + max(0.0, call.until_s - call.at_s)
        if not (self.waits and (self.until_s or 0.0) - (self._told_s or now_s) > AGAIN_S):
            self.settle()

    def settle(self) -> None:
        """Take over the caller's time."""
        self.until_s, self.waits = self._told_s, False

    def loses(self, call: HelpCall) -> bool:
        """Whether a caller's message with another operator, or none, ends the commitment.

        A message sent before the caller could hear the answer does not.
        """
        if call.state is CallState.ENDED or call.taken_by:
            return True
        return self._turn > 0 and not self.waits

    def clear(self) -> None:
        """Clear the commitment."""
        self.call = self.caller = self.goods = ""
        self.until_s, self.waits, self._turn = None, False, 0
