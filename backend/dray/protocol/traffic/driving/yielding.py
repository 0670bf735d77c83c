"""Who makes room for whom: priority inheritance with backtracking (Okumura et al., PIBT), for vehicles that take time.

Whoever stands in the way of a more urgent vehicle inherits its rank, until `LAPSE_S` after it was asked last, and drives to a refuge:
a place off the way of those it makes room for. It asks for its way with the inherited rank, so whoever is in ITS way makes room as well.
Who finds no refuge says so; then whoever has asked makes room itself, and rests meanwhile.
"""

from __future__ import annotations

from collections.abc import Iterable

import msgspec

from dray.messages.floor.traffic import ROUTE_MAX, Rank, YieldAsked, YieldRefused
from dray.protocol.runtime.life import Life
from dray.protocol.runtime.timers import spread_frac
from dray.protocol.traffic.prices import Outlook
from dray.protocol.traffic.ways import Ways

LAPSE_S = 8.0
"""A rank that nobody renews for so long is inherited no more: eight requests are lost in a row on no link."""

REST_S = 1.0
"""At a refuge, before going on: the other one has set off by then."""

BACKTRACK_S = 6.0
"""At a refuge that was taken because somebody had nowhere to go: so long it takes him to come out and past."""

BACKTRACKS_MAX = 4
"""So often that time is doubled at most, when it was not enough for the same vehicle."""

BACKTRACK_MORE_S = 2.0
"""Added to that by a part that follows from the vehicle's name, so that two do not go on together."""

PATIENCE_S = 4.0
"""A refuge that was not reached within this is given up for another one."""

REFUSE_AGAIN_S = 1.0
"""The same is not refused more often than it is asked for."""


class Inherited(msgspec.Struct, frozen=True, gc=False):
    """The rank of somebody for whom room is made."""

    rank: Rank
    pusher: str
    """Who has asked."""
    chain: tuple[str, ...]
    """Everybody for whom room is made, the first one first, `pusher` last."""
    avoid: tuple[str, ...]
    """Where they want to go."""
    until_s: float


class Yielding:
    """For whom one vehicle makes room, and where it goes meanwhile.

    Args:
        atv: the vehicle.
        ways: of the plant.
        outlook: what it knows of others.
    """

    def __init__(self, atv: str, ways: Ways, outlook: Outlook, life: Life) -> None:
        self._atv = atv
        self._ways = ways
        self._outlook = outlook
        self._life = life
        self._inherited: Inherited | None = None
        self._refuge_s = 0.0
        """When the present refuge was chosen."""
        self._backtracks = False
        """It makes room because somebody else has nowhere to go."""
        self._refuser, self._again = "", 0
        """For whom it did so last on this leg, and how often before."""
        self._tried: set[str] = set()
        """Where it has gone for that on this leg: it was not enough, so it goes elsewhere next."""
        self._refused_s = -REFUSE_AGAIN_S

    # --- ranks -----------------------------------------------------------------------------------

    def of(self, now_s: float) -> Inherited | None:
        """What it has inherited, unless that has lapsed."""
        inherited = self._inherited
        if inherited is not None and inherited.until_s <= now_s:
            self._inherited = inherited = None
        return inherited

    def inherit(self, asked: YieldAsked, now_s: float) -> None:
        """Make room for somebody from now on."""
        chain = (*(atv for atv in asked.chain if atv != asked.waiting), asked.waiting)
        self._inherited = Inherited(
            asked.rank, asked.waiting, chain, asked.avoid[: 2 * ROUTE_MAX], now_s + LAPSE_S
        )

    def renew(self, asked: YieldAsked, now_s: float) -> bool:
        """Somebody asks with the rank that is inherited already; True then.

        Whoever asks now is the one for whom room is made from now on. Nobody renews the rank of one for whose sake it has it itself:
        it stands in the chain then, and its request counts for nothing. So a rank that its owner does not renew lapses everywhere.
        """
        inherited = self.of(now_s)
        if inherited is None or inherited.rank != asked.rank:
            return False
        self.inherit(asked, now_s)
        return True

    def stop(self) -> None:
        """Room was made, or is asked for no more."""
        self._inherited = None

    # --- refuges ---------------------------------------------------------------------------------

    def refuge(
        self,
        here: str,
        goal: str,
        avoid: Iterable[str],
        chain: tuple[str, ...],
        rank: Rank,
        now_s: float,
        *,
        again: bool,
        refused: bool = False,
    ) -> tuple[str, ...] | None:
        """The cheapest way out of somebody's way; None when there is none.

        Args:
            here: the node where it stands.
            goal: where it goes afterwards.
            avoid: nodes where it would be in the way again.
            chain: the vehicles for whom it makes room.
            rank: of the first one of them.
            now_s: when.
            again: the one before was not reached: whoever was in the way there drives on itself, if it can.
            refused: because somebody else has nowhere to go: then not where it has gone for that before, as long as there is more.
        """
        if refused and self._tried:
            elsewhere = (*avoid, *self._tried)
            way = self.refuge(here, goal, elsewhere, chain, rank, now_s, again=again)
            if way is not None:
                return way
            self._tried.clear()
        forbidden, taken = self._outlook.holders(chain, rank, now_s)
        return self._ways.refuge(
            here,
            avoid=frozenset(avoid),
            forbidden=forbidden,
            taken=taken,
            prices=self._outlook.prices(now_s),
            own=self._ways.way(here, goal) or (),
            behind_others=not again,
        )

    def begin_leg(self) -> None:
        """It goes somewhere else: what was in the way there counts no more."""
        self._refuser, self._again = "", 0
        self._tried.clear()

    def leave(self, to: str, now_s: float, *, refuser: str = "") -> None:
        """It drives to a refuge from now on; because somebody else, the refuser, has nowhere to go, or not."""
        self._refuge_s, self._backtracks = now_s, bool(refuser)
        if refuser:
            self._tried.add(to)
            self._again = min(self._again + 1, BACKTRACKS_MAX) if refuser == self._refuser else 0
            self._refuser = refuser

    def is_patient(self, now_s: float) -> bool:
        """Whether the refuge that was chosen last may still be reached."""
        return now_s - self._refuge_s < PATIENCE_S

    @property
    def backtracks(self) -> bool:
        """Whether it makes room because somebody else has nowhere to go."""
        return self._backtracks

    def reach_refuge(self) -> float:
        """Room is made; how long to rest there (s)."""
        rest_s = REST_S
        if self._backtracks:
            rest_s = BACKTRACK_S * 2.0**self._again + BACKTRACK_MORE_S * spread_frac(self._atv)
        self._backtracks = False
        self.stop()
        return rest_s

    def refuse(self, to: str, avoid: tuple[str, ...], holds: Iterable[str], now_s: float) -> None:
        """Say that there is nowhere to go, not more often than it is asked for."""
        if now_s - self._refused_s >= REFUSE_AGAIN_S:
            self._refused_s = now_s
            self._life.send(to, YieldRefused(avoid=avoid, holds=tuple(holds)))
