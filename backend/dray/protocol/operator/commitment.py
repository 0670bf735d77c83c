"""The one call that an operator has taken, or is about to take."""

from __future__ import annotations

from dray.messages import CallState, HelpCall

AGAIN_S = 2.0
"""A word that the caller has not confirmed is said again after this long."""

GIVE_UP_S = 15.0
"""After this long the person is told that nobody has confirmed, and decides again."""


class Commitment:
    """What one operator has promised to whom. Empty at first.

    Attributes:
        call, caller, goods: empty for none.
        until_s: by when it is promised (the operator's clock).
        waits: whether the caller has yet to confirm what was said last.
        again_s, give_up_s: when it is said again, and when it is given up, while `waits`.
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
        """What it is about; see `HelpCall.subject`."""
        return self.caller, self.goods

    @property
    def confirmed(self) -> tuple[str, int] | None:
        """The call whose caller expects this operator, and its turn; None for none."""
        return (self.call, self._turn) if self._turn else None

    def take(self, call: HelpCall, until_s: float, now_s: float) -> None:
        """Take it, or promise anew; it waits for the caller's word."""
        if self.call != call.call:
            self._turn, self._told_s = 0, None
        self.call, self.until_s = call.call, until_s
        self.caller, self.goods = call.subject
        self.waits, self.give_up_s = True, now_s + GIVE_UP_S

    def said(self, now_s: float) -> None:
        """It was said to the caller, once more."""
        self.again_s = now_s + AGAIN_S

    def confirm(self, call: HelpCall, now_s: float) -> None:
        """The caller has said that this operator has it, and until when; what was promised anew since may not have come there yet."""
        self.call, self._turn = call.call, call.turn
        self.caller, self.goods = call.subject
        self._told_s = None if call.until_s is None else now_s + max(0.0, call.until_s - call.at_s)
        if not (self.waits and (self.until_s or 0.0) - (self._told_s or now_s) > AGAIN_S):
            self.settle()

    def settle(self) -> None:
        """What the caller has told counts."""
        self.until_s, self.waits = self._told_s, False

    def loses(self, call: HelpCall) -> bool:
        """Whether a word of the caller's that names another one, or nobody, ends it.

        What was said before the answer could be heard does not.
        """
        if call.state is CallState.ENDED or call.taken_by:
            return True
        return self._turn > 0 and not self.waits

    def clear(self) -> None:
        """It is over."""
        self.call = self.caller = self.goods = ""
        self.until_s, self.waits, self._turn = None, False, 0
