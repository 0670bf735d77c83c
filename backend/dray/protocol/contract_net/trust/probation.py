"""On probation: whoever is not known to be good takes short tasks first, until some were done well (paper, 4.2 case 6).

A short task that goes wrong costs little, and shows soon that something is wrong. Whether a task was done
well is for those to judge who have given it out; the agent itself only counts, to know when it may do more.
Probation is not remembered: each life that is to be on probation is started on probation.

Probation must not keep a task from being done at all. What nobody has taken in PASSED_OVER_ROUNDS rounds is
taken on probation too, however long it is.
"""

from __future__ import annotations

from dray.messages import ProbationBrief

SHORT_S = 90.0
"""A transport that is given to one on probation: every second one of the default plant, which take 83 s in the middle."""

PASSED_OVER_ROUNDS = 4
"""By then the circle of those who are asked has grown to 200 m, and bidders that were busy were asked again."""

ON_PROBATION = "on probation, and this is not short"


def is_barred(*, short: bool, round_number: int) -> bool:
    """Whether a task is not for one that is given short ones only; what nobody has taken is for everybody."""
    return not short and round_number <= PASSED_OVER_ROUNDS


class Probation:
    """The probation of one agent.

    Args:
        transports: so many have to be done well; 0 for an agent that is not on probation.
    """

    __slots__ = ("_done", "_of")

    def __init__(self, transports: int) -> None:
        self._of = transports
        self._done = 0

    @property
    def lasts(self) -> bool:
        return self._done < self._of

    def bars(self, *, short: bool, round_number: int) -> bool:
        """Whether a task that was announced is not for an agent on probation.

        Args:
            short: whether it is a short one, as far as the agent can tell.
            round_number: of its announcement.
        """
        return self.lasts and is_barred(short=short, round_number=round_number)

    def note_done(self) -> None:
        """A transport came to its good end."""
        self._done += self.lasts

    def brief(self) -> ProbationBrief | None:
        """What the heartbeat tells of it; None when there is no probation, or it is passed."""
        return ProbationBrief(of=self._of, done=self._done) if self.lasts else None
