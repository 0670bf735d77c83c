"""How vehicles make room for each other: priority inheritance with backtracking (Okumura et al., PIBT), in continuous time.

A vehicle in the way of a more urgent one inherits its rank, until `LAPSE_S` after the last request, and drives to a refuge: a place
off the way of those it makes room for. It requests its way with the inherited rank, so vehicles in its own way make room, too.
A vehicle without a refuge refuses; then the asking vehicle makes room itself, and rests meanwhile. If the refusing one has no way
of its own, it requests the way to a refuge past the asking one, and so leaves once that has backed off.
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
"""Time after which an inherited rank lapses unless it is renewed: no link loses eight requests in a row."""

REST_S = 1.0
"""Rest at a refuge: the other vehicle has set off by then."""

BACKTRACK_S = 6.0
"""Rest at a refuge that was taken because another vehicle had none: the time it needs to come out and past."""

BACKTRACKS_MAX = 4
"""Maximum doublings of that time, when it was too short for the same vehicle."""

BACKTRACK_MORE_S = 2.0
"""Largest addition to that time; its share follows from the vehicle's name, so that two do not go on together."""

PATIENCE_S = 4.0
"""Time after which a refuge that was not reached is given up for another one."""

REFUSE_AGAIN_S = 1.0
"""Shortest time between two refusals, as between two requests for room."""


class Inherited(msgspec.Struct, frozen=True, gc=False):
    """The inherited rank of a vehicle for which room is made."""

    rank: Rank
    pusher: str
    """The vehicle that has asked."""
    chain: tuple[str, ...]
    """All vehicles for which room is made, `pusher` last."""
    avoid: tuple[str, ...]
    """The nodes where they want to go."""
    until_s: float


class Yielding:
    """One vehicle's yielding: the rank that it inherits, and its refuge.

    Args:
        atv: the vehicle.
        ways: of the plant.
        outlook: its knowledge of traffic.
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
        """Whether it makes room because another vehicle has no refuge."""
        self._refuser, self._again = "", 0
        """The vehicle for which it did so last on this leg, and how often before."""
        self._tried: set[str] = set()
        """The refuges that it took for that on this leg; next it prefers other ones."""
        self._refused_s = -REFUSE_AGAIN_S

    # --- ranks -----------------------------------------------------------------------------------

    def of(self, now_s: float) -> Inherited | None:
        """The inherited rank, unless it has lapsed."""
        inherited = self._inherited
        if inherited is not None and inherited.until_s <= now_s:
            self._inherited = inherited = None
        return inherited

    def inherit(self, asked: YieldAsked, now_s: float) -> None:
        """Inherit the rank of a vehicle that asks for room."""
        chain = (*(atv for atv in asked.chain if atv != asked.waiting), asked.waiting)
        self._inherited = Inherited(
            asked.rank, asked.waiting, chain, asked.avoid[: 2 * ROUTE_MAX], now_s + LAPSE_S
        )

    def renew(self, asked: YieldAsked, now_s: float) -> bool:
        """Renew the inherited rank if a request carries the same one; True then.

        From now on room is made for the asking vehicle. Requests whose chain contains this vehicle do not renew (see the caller),
        so vehicles cannot renew each other's inherited rank: one that its owner does not renew lapses everywhere.
        """
        inherited = self.of(now_s)
        if inherited is None or inherited.rank != asked.rank:
            return False
        self.inherit(asked, now_s)
        return True

    def stop(self) -> None:
        """Give the inherited rank up: room was made, or is not needed any more."""
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
        """The cheapest way to a refuge; None when there is none.

        Args:
            here: the node where it stands.
            goal: the node where it goes afterwards.
            avoid: nodes where it would be in the way again.
            chain: the vehicles for which it makes room.
            rank: of the first one of them.
            now_s: the present time.
            again: the last refuge was not reached; a vehicle in the way there makes room by driving on, if it can.
            refused: another vehicle has no refuge; prefer refuges that were not tried for that before.
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
        """Forget tried refuges and refusals of the leg before."""
        self._refuser, self._again = "", 0
        self._tried.clear()

    def leave(self, to: str, now_s: float, *, refuser: str = "") -> None:
        """Note that it drives to a refuge; `refuser` is the vehicle without a refuge because of which it does, if any."""
        self._refuge_s, self._backtracks = now_s, bool(refuser)
        if refuser:
            self._tried.add(to)
            self._again = min(self._again + 1, BACKTRACKS_MAX) if refuser == self._refuser else 0
            self._refuser = refuser

    def is_patient(self, now_s: float) -> bool:
        """Whether the present refuge is not given up yet."""
        return now_s - self._refuge_s < PATIENCE_S

    @property
    def backtracks(self) -> bool:
        """Whether it makes room because another vehicle has no refuge."""
        return self._backtracks

    def reach_refuge(self) -> float:
        """Note that room is made; the time (s) to rest there."""
        rest_s = REST_S
        if self._backtracks:
            rest_s = BACKTRACK_S * 2.0**self._again + BACKTRACK_MORE_S * spread_frac(self._atv)
        self._backtracks = False
        self.stop()
        return rest_s

    def refuse(self, to: str, avoid: tuple[str, ...], holds: Iterable[str], now_s: float) -> None:
        """Refuse to make room, at most once in `REFUSE_AGAIN_S`."""
        if now_s - self._refused_s >= REFUSE_AGAIN_S:
            self._refused_s = now_s
            self._life.send(to, YieldRefused(avoid=avoid, holds=tuple(holds)))
