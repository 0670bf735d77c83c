"""What a caller knows of one of its calls for help, while it is open and while its end is said."""

from __future__ import annotations

from dray.messages import CallState, HelpCall, Problem
from dray.protocol.calls.call_state import TRANSITIONS
from dray.states import States


class Call:
    """An open call."""

    def __init__(
        self,
        name: str,
        goods: str,
        problem: Problem,
        reason: str,
        now_s: float,
        place_m: tuple[float, float] | None,
    ) -> None:
        self.name, self.goods, self.since_s = name, goods, now_s
        self.problem, self.reason, self.place_m = problem, reason, place_m
        # Before anybody was asked it rests.
        self.states = States("a call", TRANSITIONS, CallState.RESTING)
        self.said = False
        self.round = 1
        self.rounds = self.passes = self.turn = 0
        self.asked: tuple[str, ...] = ()
        self.until_s: float | None = None
        self.taken_by = ""
        self.turn_s = 0.0
        """When the present one has taken it."""
        self.taken_s: float | None = None
        """When it was taken first."""
        self.spared: set[str] = set()
        """Who is not asked again in this pass."""
        self.cannot: set[str] = set()
        self.ever_asked: set[str] = set()


class EndedCall:
    """A call that is over."""

    def __init__(self, told: HelpCall) -> None:
        self.told, self.said = told, 1
