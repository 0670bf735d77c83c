"""What a coordinator learned of its contractors from its own contracts, and how that affects bids.

    doubt        halves every HALF_LIFE_S; a kept contract removes a quarter of it; a dropped one adds its BLAME,
                 a late one a part of it in proportion to its lateness, up to 1
    surcharge_s  doubt * DROPPED_S: the cost of a dropped contract times its likelihood. It is added to every bid
                 before ranking, so a doubted contractor is asked if it is still cheaper
    restricted   from doubt RESTRICTED_FROM down to RESTRICTED_TO: it gets short tasks only, as on probation
                 (`probation`), and tasks that nobody else takes; a task that it has dropped counts as long

Nothing is learned from others: a lie about a rival would be too cheap. Every coordinator pays for its own lesson, a
short one, because a contract has a progress deadline (`progress`). Nothing is stored: a restarted coordinator
begins without prejudice, and learns again from one contract.
"""

from __future__ import annotations

from collections.abc import Mapping

from dray.messages import Reason
from dray.messages.fact import ContractorRated
from dray.protocol.runtime.bounded_map import BoundedMap
from dray.protocol.runtime.life import Life

HALF_LIFE_S = 1800.0
"""Half-life of doubt (s): a breakdown in the morning is forgotten by noon."""

DROPPED_S = 120.0
"""Cost of a dropped contract (s): the time until it is noticed, and a new transport (median 84 s in the default plant)."""

KEPT_FRAC = 0.75
"""Fraction of the doubt that remains after a kept contract."""

BLAME: Mapping[Reason, float] = {
    Reason.IN_ERROR: 0.25,
    Reason.STALLED: 1.5,
    Reason.OVERDUE: 1.0,
    Reason.NOT_COUNTED: 2.5,
}
"""Doubt by reason of a dropped contract. A contractor that reports its own failure was honest. One that stands and reports
no problem was not. One that reports work it has not done is restricted at once."""

DROPPED_BLAME = 1.0
"""Doubt for all other reasons: silence, or a forgotten contract."""

GIVEN_BACK_BLAME = 0.25
"""Giving a contract back costs little: the secondary is asked at once."""

DOUBT_MAX = 8.0
"""Maximum doubt: after 1.5 h without contracts even that restricts no contractor."""

RESTRICTED_FROM, RESTRICTED_TO = 2.5, 1.0
"""Three contracts dropped within minutes, with none kept in between, are no bad luck. Two short ones kept, or forty
minutes, lift the restriction."""

LATE_FROM_S = 30.0
"""Lateness by chance, without anybody's fault (s)."""

FORGOTTEN = 0.05
"""Doubt below this counts as none: 6 s."""

DROPPED_KEPT = 32
"""Maximum remembered dropped tasks per contractor, the newest: about as many as a coordinator has open."""

KNOWN_MAX = 1024
"""Maximum remembered contractors in doubt: more than a coordinator hires in a day, some 100 kB. A forgotten one begins
without prejudice."""


class Rating:
    """The rating of one contractor."""

    __slots__ = ("_at_s", "_doubt", "dropped", "restricted")

    def __init__(self) -> None:
        self.dropped: BoundedMap[str, tuple[float, float]] = BoundedMap(DROPPED_KEPT)
        """By task that it has dropped or given back: the doubt for that, and its time (plant clock, s)."""
        self._doubt = 0.0
        self._at_s = 0.0
        self.restricted = False

    def doubt(self, now_s: float) -> float:
        """The remaining doubt."""
        return float(self._doubt * 0.5 ** (max(0.0, now_s - self._at_s) / HALF_LIFE_S))

    def set(self, doubt: float, now_s: float) -> None:
        """Recompute the doubt and the restriction after a contract."""
        self._doubt, self._at_s = min(doubt, DOUBT_MAX), now_s
        self.look(now_s)

    def note_dropped(self, task: str, blame: float, now_s: float) -> None:
        """Remember the doubt for a dropped task, so that it can be taken back."""
        self.dropped[task] = blame + self._left(task, now_s), now_s

    def take_back(self, task: str, now_s: float) -> float:
        """Forget that it has dropped a task. Returns what is left of the doubt for that."""
        left = self._left(task, now_s)
        self.dropped.pop(task, None)
        return left

    def _left(self, task: str, now_s: float) -> float:
        blame, at_s = self.dropped.get(task, (0.0, now_s))
        return float(blame * 0.5 ** (max(0.0, now_s - at_s) / HALF_LIFE_S))

    def look(self, now_s: float) -> None:
        """Lift the restriction if enough time has passed."""
        doubt = self.doubt(now_s)
        self.restricted = doubt >= RESTRICTED_FROM or (self.restricted and doubt > RESTRICTED_TO)


class Reliability:
    """One coordinator's ratings of its contractors."""

    def __init__(self, life: Life) -> None:
        self._life = life
        self._ratings: BoundedMap[str, Rating] = BoundedMap(KNOWN_MAX)

    def surcharge_s(self, contractor: str, now_s: float) -> float:
        """Added to a bid before it is ranked (s)."""
        rating = self._ratings.get(contractor)
        return 0.0 if rating is None else DROPPED_S * rating.doubt(now_s)

    def is_restricted(self, contractor: str, now_s: float) -> bool:
        """Whether it gets short tasks only."""
        rating = self._ratings.get(contractor)
        if rating is None:
            return False
        rating.look(now_s)
        return rating.restricted

    def has_dropped(self, contractor: str, task: str) -> bool:
        """Whether it has dropped or given back this task."""
        rating = self._ratings.get(contractor)
        return rating is not None and task in rating.dropped

    def note_kept(self, contractor: str, task: str, late_s: float, now_s: float) -> None:
        """A contract was kept, `late_s` later than promised."""
        lateness = min(max(late_s - LATE_FROM_S, 0.0) / DROPPED_S, 1.0)
        rating = self._ratings.get(contractor)
        if rating is None and not lateness:
            return
        if lateness:
            self._rate(contractor, task, 1.0, lateness, Reason.LATE, now_s, late_s)
        else:
            self._rate(contractor, task, KEPT_FRAC, 0.0, Reason.KEPT, now_s)

    def note_dropped(self, contractor: str, task: str, reason: Reason, now_s: float) -> None:
        """A contractor has lost an unfinished task."""
        blame = BLAME.get(reason, DROPPED_BLAME)
        self._rate(contractor, task, 1.0, blame, reason, now_s).note_dropped(task, blame, now_s)

    def note_given_back(self, contractor: str, task: str, reason: Reason, now_s: float) -> None:
        """A contractor has given a contract back."""
        blame = GIVEN_BACK_BLAME
        self._rate(contractor, task, 1.0, blame, reason, now_s).note_dropped(task, blame, now_s)

    def take_back(self, contractor: str, task: str, now_s: float) -> None:
        """It was not the contractor's fault that it has dropped a task."""
        rating = self._ratings.get(contractor)
        if rating is not None and task in rating.dropped:
            less = rating.take_back(task, now_s)
            self._rate(contractor, task, 1.0, -less, Reason.DISPUTED, now_s)

    def _rate(
        self,
        contractor: str,
        task: str,
        frac: float,
        more: float,
        reason: Reason,
        now_s: float,
        late_s: float = 0.0,
    ) -> Rating:
        rating = self._ratings.get(contractor)
        if rating is None:
            rating = self._ratings[contractor] = Rating()
        # A contract kept since may have removed part of a doubt that is taken back.
        rating.set(max(rating.doubt(now_s) * frac + more, 0.0), now_s)
        surcharge_s = DROPPED_S * rating.doubt(now_s)
        if rating.doubt(now_s) < FORGOTTEN:
            del self._ratings[contractor]
            surcharge_s = 0.0
        rated = ContractorRated(
            contractor=contractor,
            task=task,
            reason=reason,
            surcharge_s=surcharge_s,
            restricted=rating.restricted,
            late_s=late_s,
        )
        self._life.record(rated)
        return rating
