"""How long a task waits for its carrier's problem to end: judged by the kind of the problem and by the deadline (paper, case 4).

    room_s      the time that is left to the deadline; what a takeover would cost, if that is more; PATIENCE_MIN_S to PATIENCE_MAX_S
    usual_s     three of five problems of this kind were over by then, as all vehicles have told; where nobody is on duty, and by the working
                time of the place nobody is there, counted from when people come

Where such problems are usually over within the room, the task waits as long as it has room. Else it is handed over at once: a dead drive is
not waited for. Of a problem about which there are only words nothing is usual, and the task waits.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import inf

from dray.messages import Problem, ProblemEnded, ProblemKind
from dray.protocol.runtime.durations import Durations

PATIENCE_MIN_S = 30.0
"""The shortest wait that is asked for, even when the task is late already: in less nobody could help."""

PATIENCE_MAX_S = 180.0
"""Waited for without a promise, however much time the task has."""

QUANTILE = 0.6
"""Waiting pays where more problems than not are over in time."""

HALF_LIFE_S = 4 * 3600.0
"""How long problems last follows the people of a shift, the goods of a season, the wear of a floor: half a shift."""

LONGEST_S = 1800.0
"""Nobody waits for so long: what lasts longer is no different."""

AT_FIRST_S: Mapping[ProblemKind, float] = {
    ProblemKind.LOAD: 90.0,
    ProblemKind.DRIVE: LONGEST_S,
    ProblemKind.SENSOR: 90.0,
    ProblemKind.BATTERY: 600.0,
    ProblemKind.WAY_BLOCKED: 60.0,
    ProblemKind.LOST_POSITION: 90.0,
    ProblemKind.LINK: 60.0,
    ProblemKind.EMERGENCY_STOP: 60.0,
    ProblemKind.DOCK: 60.0,
    ProblemKind.TOOL: 900.0,
    ProblemKind.JAM: 120.0,
    ProblemKind.SOFTWARE: 120.0,
    ProblemKind.UNKNOWN: 0.0,
}
"""What is believed before anybody has had such a problem: a person who comes at once puts most things right in a minute and
a half, exchanges no battery and repairs no drive. In a machine what is stuck takes longer, and a new tool a quarter of an hour."""

PASSES_AT_FIRST_S = 30.0
"""The same of what goes away by itself."""


class Experience:
    """How long problems have lasted, as one agent has measured and heard."""

    def __init__(self) -> None:
        self._durations = Durations(QUANTILE, HALF_LIFE_S, LONGEST_S)

    def note(self, ended: ProblemEnded, witness: str, now_s: float) -> None:
        """Note that a problem is over; `witness` is empty for one's own."""
        if ended.problem.kind is not ProblemKind.UNKNOWN:
            self._durations.note(_subject(ended.problem), witness, ended.lasted_s, now_s)

    def usual_s(self, problem: Problem, now_s: float, comes_after_s: float = 0.0) -> float:
        """How long it will last, more probably than not at most.

        Args:
            problem: what is known of it.
            now_s: the present time.
            comes_after_s: until anybody can be asked to help; 0 where somebody can be now.
        """
        if waits_for_people(problem):
            return comes_after_s + self._lasts_s(problem, now_s)
        return self._lasts_s(problem, now_s)

    def _lasts_s(self, problem: Problem, now_s: float) -> float:
        """The same where people are."""
        if problem.kind is ProblemKind.UNKNOWN:
            return 0.0
        if problem.passes is False and problem.needs_person is False:
            return inf
        at_first_s = PASSES_AT_FIRST_S if problem.passes else AT_FIRST_S[problem.kind]
        return self._durations.usual_s(_subject(problem), now_s, at_first_s)


def waits_for_people(problem: Problem) -> bool:
    """Whether it may be that nobody but a person ends it."""
    return problem.needs_person is True or (problem.needs_person is None and not problem.passes)


def room_s(slack_s: float, relief_s: float) -> float:
    """How long a task can wait at all.

    Args:
        slack_s: how much later than now expected it may be done.
        relief_s: how much later another vehicle would be done; until then waiting costs no more.
    """
    return min(max(slack_s, relief_s, PATIENCE_MIN_S), PATIENCE_MAX_S)


def _subject(problem: Problem) -> str:
    """What goes away by itself lasts otherwise than what does not, of whatever kind."""
    return f"{problem.kind} passes" if problem.passes else problem.kind.value
