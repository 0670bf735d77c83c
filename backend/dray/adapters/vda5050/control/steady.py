"""Steady problems: a flickering problem is held until it has been absent for a while, instead of calling for help every second."""

from __future__ import annotations

from dray.body import ProblemRaised

HELD_S, HELD_MAX_S = 10.0, 120.0
"""Absence after which a recurring problem is over: the first time, and at most."""

BACK_S = 60.0
"""A problem that returns so soon after its end is the same one."""

RETOLD_S = 60.0
"""Least seconds between reports of a problem's changed text; changed figures in it are not reported."""

KNOWN_MAX = 50
"""Maximum problems remembered; a vehicle has a handful."""


class Steady:
    """The reported problems of one vehicle.

    Attributes:
        told: the present problem; None for none.
    """

    def __init__(self) -> None:
        self.told: ProblemRaised | None = None
        self._told_s = 0.0
        self._gone_s: float | None = None
        self._held_s: dict[str, float] = {}
        """By problem, the absence required the next time."""
        self._ended_s: dict[str, float] = {}

    def look(self, found: ProblemRaised | None, now_s: float) -> ProblemRaised | None:
        """Update by the present findings.

        Args:
            found: the present problem of the vehicle; None for none.
            now_s: the present time.

        Returns:
            The problem to report; None when it is over.
        """
        told = self.told
        if found is None:
            if told is not None and self._is_over(told, now_s):
                self._end(told, now_s)
            return self.told
        self._gone_s = None
        if told is None or _name(found) != _name(told):
            if told is not None:
                self._end(told, now_s)
            self._begin(found, now_s)
        elif _figureless(found.reason) != _figureless(told.reason) and now_s - self._told_s >= RETOLD_S:
            self.told, self._told_s = found, now_s
        return self.told

    def _begin(self, found: ProblemRaised, now_s: float) -> None:
        name = _name(found)
        is_back = now_s - self._ended_s.get(name, float("-inf")) < BACK_S
        if not is_back:
            self._held_s.pop(name, None)
        elif len(self._held_s) < KNOWN_MAX:
            self._held_s[name] = min(2.0 * self._held_s.get(name, HELD_S / 2.0), HELD_MAX_S)
        self.told, self._told_s = found, now_s

    def _is_over(self, told: ProblemRaised, now_s: float) -> bool:
        self._gone_s = now_s if self._gone_s is None else self._gone_s
        return now_s - self._gone_s >= self._held_s.get(_name(told), 0.0)

    def _end(self, told: ProblemRaised, now_s: float) -> None:
        if len(self._ended_s) >= KNOWN_MAX:
            self._ended_s.clear()
        self._ended_s[_name(told)] = now_s
        self.told = self._gone_s = None


def _name(problem: ProblemRaised) -> str:
    """The identity of a problem: its kind, and its text before the first colon, without figures."""
    return f"{problem.problem.kind} {_figureless(problem.reason.partition(':')[0])}"


def _figureless(words: str) -> str:
    return "".join(letter for letter in words if not letter.isdigit())
