"""The auctions of one coordinator: their set-up and their alarms."""

from __future__ import annotations

from collections.abc import Callable
from itertools import count

from dray.messages import Bid, Wait, Work
from dray.protocol.contract_net.auction import Auction
from dray.protocol.contract_net.auction_rules import AuctionRules
from dray.protocol.contract_net.terms import Place, Terms
from dray.protocol.contract_net.trust.assessment import Assessor
from dray.protocol.liveness.suspicion import ArrivalStatistics
from dray.protocol.runtime.events import NEVER_S
from dray.protocol.runtime.life import Life

AWARDS_PER_LIFE = 1_000_000
"""Award numbers per incarnation, more than one uses. They reveal answers to an earlier life's awards."""


class Auctions:
    """What all auctions of one coordinator share.

    Args:
        coordinator: its id.
        place: where it stands.
        audience: for a task's work and a radius (m), the bus keys of the agents to ask.
        arrivals: arrival statistics of heartbeats; None if the coordinator follows nobody.
        assessor: checks bids and adds surcharges.
    """

    def __init__(
        self,
        coordinator: str,
        place: Place,
        audience: Callable[[Work, float], tuple[str, ...]],
        life: Life,
        arrivals: ArrivalStatistics | None,
        assessor: Assessor,
    ) -> None:
        self._coordinator = coordinator
        self._place = place
        self._audience = audience
        self._life = life
        self._arrivals = arrivals
        self._numbers = count((life.incarnation - 1) * AWARDS_PER_LIFE + 1)
        self._assessor = assessor
        self.waits: Callable[[Work, float], tuple[Wait, ...]] = lambda _work, _now_s: ()
        """The coordinator's known waits at the places of a work, at a time (s)."""

    def prepare(
        self, terms: Terms, rules: AuctionRules, candidates: tuple[tuple[str, Bid], ...] = ()
    ) -> Auction:
        """An auction that is not open yet; `candidates` are asked before the first announcement.

        On links that are known to be slow its time-outs are long from the first round.
        """
        if self._arrivals is not None:
            rules = rules.on_links(self._arrivals.delay_s, self._arrivals.deviation_s)

        def audience(radius_m: float) -> tuple[str, ...]:
            return self._audience(terms.work, radius_m)

        return Auction(
            self._coordinator,
            terms,
            self._place,
            audience,
            rules,
            self._life,
            self._assessor,
            candidates,
            self._numbers,
            self.waits,
        )

    def arm(self, kind: str, auction: Auction) -> None:
        """Set or clear the alarm ``(kind, task)`` to match the auction."""
        name = (kind, auction.terms.task)
        if auction.wake_at_s < NEVER_S:
            self._life.alarm(name, auction.wake_at_s)
        else:
            self._life.cancel(name)
