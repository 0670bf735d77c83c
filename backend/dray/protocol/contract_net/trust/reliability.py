"""What a coordinator has learned of its contractors, from its own contracts alone, and what it makes of that.

    doubt        falls by half in HALF_LIFE_S; a contract that is kept takes a quarter of it away; one that is
                 dropped adds its BLAME, one that is late as much of it as it is late, up to 1
    surcharge_s  doubt * DROPPED_S: what a dropped contract costs, times how likely it is. It is added to every bid
                 before bids are ranked, so a contractor in doubt is asked when it is cheaper even so
    restricted   from RESTRICTED_FROM of doubt down to RESTRICTED_TO: only short tasks are given to it, as to one on probation
                 (`probation`), and what nobody else has taken; a task that it has dropped counts as long

Nothing is heard from others: a lie about a rival would be too cheap. So every coordinator pays for its own lesson, and
the lesson is short, for a contract has a progress deadline (`progress`). None of this is written down: a coordinator
that was started again begins without prejudice, and learns again from one contract.
"""

from __future__ import annotations

from collections.abc import Mapping

from dray.messages import Reason
from dray.messages.fact import ContractorRated
from dray.protocol.runtime.bounded_map import BoundedMap
from dray.protocol.runtime.life import Life

HALF_LIFE_S = 1800.0
"""A breakdown in the morning is forgotten by noon."""

DROPPED_S = 120.0
"""What a dropped contract costs: the time until it is noticed, and a transport begun anew, which takes 84 s in the
middle in the default plant."""

KEPT_FRAC = 0.75
"""What is left of the doubt after a contract that was kept."""

BLAME: Mapping[Reason, float] = {
    Reason.IN_ERROR: 0.25,
    Reason.STALLED: 1.5,
    Reason.OVERDUE: 1.0,
    Reason.NOT_COUNTED: 2.5,
}
"""Why a contract was dropped, and how much doubt that leaves. Who says itself that it cannot go on has told the
truth; who says that all is well, and stands, has not; and who says that it has done what it has not is restricted at once."""

DROPPED_BLAME = 1.0
"""For every other reason: silence, and having forgotten the contract."""

GIVEN_BACK_BLAME = 0.25
"""Giving a contract back costs little: the secondary is asked at once."""

DOUBT_MAX = 8.0
"""After an hour and a half without contracts even that restricts nobody any more."""

RESTRICTED_FROM, RESTRICTED_TO = 2.5, 1.0
"""Three contracts dropped within minutes, with none kept in between, are no bad luck; after two short ones kept, or
after forty minutes, it is given more again."""

LATE_FROM_S = 30.0
"""Chance makes a vehicle so late without anybody's fault."""

FORGOTTEN = 0.05
"""Less doubt than this is none: 6 s."""

DROPPED_KEPT = 32
"""Tasks that one contractor has dropped, the newest: more than a coordinator has open at a time, or nearly."""

KNOWN_MAX = 1024
"""Contractors in doubt that are remembered: more than work for one coordinator in a day, and some 100 kB. Whoever is
forgotten begins without prejudice."""


class Rating:
    """What is held against one contractor."""

    __slots__ = ("_at_s", "_doubt", "dropped", "restricted")

    def __init__(self) -> None:
        self.dropped: BoundedMap[str, None] = BoundedMap(DROPPED_KEPT)
        """Tasks that it has dropped or given back."""
        self._doubt = 0.0
        self._at_s = 0.0
        self.restricted = False

    def doubt(self, now_s: float) -> float:
        """How much doubt is left."""
        return float(self._doubt * 0.5 ** (max(0.0, now_s - self._at_s) / HALF_LIFE_S))

    def set(self, doubt: float, now_s: float) -> None:
        """Recompute the doubt and the restriction after a contract."""
        self._doubt, self._at_s = min(doubt, DOUBT_MAX), now_s
        self.look(now_s)

    def look(self, now_s: float) -> None:
        """Time has passed: the restriction may be over."""
        doubt = self.doubt(now_s)
        self.restricted = doubt >= RESTRICTED_FROM or (self.restricted and doubt > RESTRICTED_TO)


class Reliability:
    """The ratings that one coordinator has of its contractors."""

    def __init__(self, life: Life) -> None:
        self._life = life
        self._ratings: BoundedMap[str, Rating] = BoundedMap(KNOWN_MAX)

    def surcharge_s(self, contractor: str, now_s: float) -> float:
        """What is added to a bid before it is ranked."""
        rating = self._ratings.get(contractor)
        return 0.0 if rating is None else DROPPED_S * rating.doubt(now_s)

    def is_restricted(self, contractor: str, now_s: float) -> bool:
        """Whether it is given short tasks only."""
        rating = self._ratings.get(contractor)
        if rating is None:
            return False
        rating.look(now_s)
        return rating.restricted

    def has_dropped(self, contractor: str, task: str) -> bool:
        """Whether this is a task that it has dropped or given back."""
        rating = self._ratings.get(contractor)
        return rating is not None and task in rating.dropped

    def note_kept(self, contractor: str, task: str, late_s: float, now_s: float) -> None:
        """A contract came to its good end, so much later than promised."""
        lateness = min(max(late_s - LATE_FROM_S, 0.0) / DROPPED_S, 1.0)
        rating = self._ratings.get(contractor)
        if rating is None and not lateness:
            return
        if lateness:
            self._rate(contractor, task, 1.0, lateness, Reason.LATE, now_s, late_s)
        else:
            self._rate(contractor, task, KEPT_FRAC, 0.0, Reason.KEPT, now_s)

    def note_dropped(self, contractor: str, task: str, reason: Reason, now_s: float) -> None:
        """A contractor has lost a task that it had not finished."""
        self._rate(contractor, task, 1.0, BLAME.get(reason, DROPPED_BLAME), reason, now_s).dropped[task] = (
            None
        )

    def note_given_back(self, contractor: str, task: str, reason: Reason, now_s: float) -> None:
        """It gave a contract back."""
        self._rate(contractor, task, 1.0, GIVEN_BACK_BLAME, reason, now_s).dropped[task] = None

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
        rating.set(rating.doubt(now_s) * frac + more, now_s)
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
