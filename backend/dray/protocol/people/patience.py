"""How long a task waits for its carrier's problem to end, by the kind of the problem and the deadline (paper, case 4).

    room_s      the time left to the deadline, or the cost of a takeover if that is more; PATIENCE_MIN_S to PATIENCE_MAX_S
    usual_s     three of five problems of this kind were over by then, by all vehicles' reports; counted from when people come,
                if nobody is on duty or at work by the place's working time

If such problems usually end within the room, the task waits as long as it has room. Otherwise it is handed over at
once: no task waits for a dead drive. A problem known only in words has no usual duration, and the task waits.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import inf

from dray.memory import ProblemMemory
from dray.messages import Problem, ProblemEnded, ProblemKind
from dray.protocol.runtime.durations import Durations

PATIENCE_MIN_S = 30.0
"""Minimum wait, even of a late task (s): no person could help sooner."""

PATIENCE_MAX_S = 180.0
"""Maximum wait without a promise, with any deadline (s)."""

QUANTILE = 0.6
"""Waiting pays if most problems end in time."""

HALF_LIFE_S = 4 * 3600.0
"""Half-life of experience (s): half a shift, because people, goods and wear change."""

LONGEST_S = 1800.0
"""Maximum duration that counts (s): no task waits so long, so longer problems make no difference."""

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
"""Initial durations (s). A person who comes at once solves most problems in 1.5 min, but exchanges no battery and repairs
no drive. A jam in a machine takes longer, and a new tool a quarter of an hour."""

PASSES_AT_FIRST_S = 30.0
"""Initial duration of a problem that passes by itself (s)."""


class Experience:
    """Durations of problems, as one agent has measured and heard them."""

    def __init__(self) -> None:
        self._durations = Durations(QUANTILE, HALF_LIFE_S, LONGEST_S)

    def note(self, ended: ProblemEnded, witness: str, now_s: float) -> None:
        """Note the end of a problem; `witness` is empty for the agent's own."""
        if ended.problem.kind is not ProblemKind.UNKNOWN:
            self._durations.note(_subject(ended.problem), witness, ended.lasted_s, now_s)

    def usual_s(self, problem: Problem, now_s: float, comes_after_s: float = 0.0) -> float:
        """The expected duration as a quantile (s).

        Args:
            problem: the known facts about it.
            now_s: the present time.
            comes_after_s: time until a person can be asked; 0 if one can be asked now.
        """
        if waits_for_people(problem):
            return comes_after_s + self._lasts_s(problem, now_s)
        return self._lasts_s(problem, now_s)

    def _lasts_s(self, problem: Problem, now_s: float) -> float:
        """The expected duration while people are there."""
        if problem.kind is ProblemKind.UNKNOWN:
            return 0.0
        if problem.passes is False and problem.needs_person is False:
            return inf
        at_first_s = PASSES_AT_FIRST_S if problem.passes else AT_FIRST_S[problem.kind]
        return self._durations.usual_s(_subject(problem), now_s, at_first_s)


def waits_for_people(problem: Problem) -> bool:
    """Whether the problem may need a person to end."""
    return problem.needs_person is True or (problem.needs_person is None and not problem.passes)


def calls_after_s(problem: Problem, lasted_s: float) -> float:
    """How long its agent waits before it calls a person (s): a problem that may pass by itself gets time first."""
    passes = problem.passes is True and not problem.needs_person
    return max(0.0, PASSES_AT_FIRST_S - lasted_s) if passes else 0.0


def since_s(memory: ProblemMemory | None, problem: Problem, now_s: float) -> float:
    """Since when an agent that has just been started has had a problem, as far as its earlier life knew."""
    return min(memory.since_s, now_s) if memory is not None and memory.kind is problem.kind else now_s


def room_s(slack_s: float, relief_s: float) -> float:
    """How long a task can wait at all (s).

    Args:
        slack_s: how much later than expected it may be done.
        relief_s: how much later another vehicle would be done; until then waiting costs no more.
    """
    return min(max(slack_s, relief_s, PATIENCE_MIN_S), PATIENCE_MAX_S)


def _subject(problem: Problem) -> str:
    """Problems that pass by themselves have their own durations within each kind."""
    return f"{problem.kind} passes" if problem.passes else problem.kind.value
