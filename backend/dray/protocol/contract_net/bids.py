"""The bids of one auction: collected while a round lasts, then asked one after the other, the cheapest first."""

from __future__ import annotations

from dray.messages import Bid
from dray.protocol.contract_net.auction_rules import rank
from dray.protocol.runtime.bounded_map import BoundedMap

BIDS_KEPT = 1024
"""In one round: more than any fleet has vehicles. Beyond that somebody bids under names that nobody has."""

Offer = tuple[str, Bid]
"""A bidder, and what it has bid."""


class Bids:
    """What was bid, and in which order it is asked.

    Args:
        candidates: bids to ask before anything was announced, cheapest first.
    """

    def __init__(self, candidates: tuple[Offer, ...] = ()) -> None:
        self._collected: BoundedMap[str, Bid] = BoundedMap(BIDS_KEPT)
        self._noted: BoundedMap[str, tuple[int, float]] = BoundedMap(BIDS_KEPT)
        """By bidder, the last round in which a bid of it was noted, and what was added to it (s)."""
        self._queue: list[Offer] = list(candidates)

    @property
    def is_queued(self) -> bool:
        """Whether somebody is still to be asked."""
        return bool(self._queue)

    def objection(self, bidder: str, bid: Bid, present_round: int) -> str:
        """Why a bid counts for nothing, whatever it says; empty when it is to be looked at."""
        if bid.round > present_round:
            return "a bid in a round that has not begun"
        if bid.round <= self._noted.get(bidder, (-1, 0.0))[0]:
            return "a second bid in one round"  # Nobody fills the history with bids.
        return ""

    def note(self, bidder: str, bid: Bid, surcharge_s: float) -> None:
        """Collect a bid; one of a later round replaces the same bidder's first."""
        self._collected[bidder], self._noted[bidder] = bid, (bid.round, surcharge_s)

    def let_bid_again(self, bidder: str) -> None:
        """It may bid once more in this round."""
        self._noted.pop(bidder, None)

    def close_window(self) -> None:
        """From now on those are asked who have bid, cheapest first; what comes meanwhile counts in the next round."""
        self._queue = sorted(self._collected.items(), key=self._rank_of)
        self._collected = BoundedMap(BIDS_KEPT)

    def next(self) -> Offer | None:
        """Whom to ask now; None when nobody is left."""
        return self._queue.pop(0) if self._queue else None

    def left_over(self) -> tuple[Offer, ...]:
        """Those who bid and were never asked, cheapest first."""
        return tuple(sorted((*self._queue, *self._collected.items()), key=self._rank_of))

    def _rank_of(self, offer: Offer) -> tuple[float, float, str]:
        bidder, bid = offer
        _, surcharge_s = self._noted.get(bidder, (0, 0.0))
        return rank(bid.cost.total_s + surcharge_s, bid.finish_s, bidder)
