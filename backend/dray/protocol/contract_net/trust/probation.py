"""Probation: an unknown contractor takes short tasks first, until some were done well (paper, 4.2 case 6).

A short task that goes wrong costs little, and soon shows the fault. The coordinator judges whether a task was done
well; the agent itself only counts its tasks. Probation is not remembered: each life on probation is started on
probation.

Probation must not keep a task from being done. After PASSED_OVER_ROUNDS rounds a vehicle on probation takes any
task, even a long one.
"""

from __future__ import annotations

from dray.messages import ProbationBrief

SHORT_S = 90.0
"""Longest transport on probation (s): half of the default plant's transports, whose median is 83 s."""

PASSED_OVER_ROUNDS = 4
"""By then the announcement radius has grown to 200 m, and busy bidders were asked again."""

ON_PROBATION = "on probation, and this is not short"


def is_barred(*, short: bool, round_number: int) -> bool:
    """Whether a restricted contractor may not take a task; long tasks are open to all after enough rounds."""
    return not short and round_number <= PASSED_OVER_ROUNDS


class Probation:
    """The probation of one agent.

    Args:
        transports: how many must be done well; 0 for an agent without probation.
    """

    __slots__ = ("_done", "_of")

    def __init__(self, transports: int) -> None:
        self._of = transports
        self._done = 0

    @property
    def lasts(self) -> bool:
        return self._done < self._of

    def bars(self, *, short: bool, round_number: int) -> bool:
        """Whether an announced task is barred for an agent on probation.

        Args:
            short: whether the agent expects it to be short.
            round_number: of the announcement.
        """
        return self.lasts and is_barred(short=short, round_number=round_number)

    def note_done(self) -> None:
        """Count a completed transport."""
        self._done += self.lasts

    def brief(self) -> ProbationBrief | None:
        """The heartbeat's entry; None without probation, or when it is passed."""
        return ProbationBrief(of=self._of, done=self._done) if self.lasts else None
