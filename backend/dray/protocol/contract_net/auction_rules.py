"""Time-outs and radius of a coordinator's auctions, round after round: pure arithmetic.

    radius_m = first radius * radius_growth ^ (round - 1)
    window_s = first window * window_growth ^ (round - 1), up to window_max_s; the wait for an answer grows with it
    rest_s   = first rest   * rest_growth   ^ (round - 1), up to rest_max_s; or, if more, a part of the auction's
               age, up to rest_aged_max_s: free vehicles ask for tasks that have waited so long

Before its first round an auction uses the first round's values.
"""

from __future__ import annotations

import msgspec

from dray.protocol.liveness.suspicion import DEVIATIONS

PATIENCE_S = 300.0
"""A task that has waited so long is as urgent as one that is due now."""


SLACK_FRAC = 0.1
"""Slack as a fraction of the mean delay: even on a steady link the bidder needs time to compute."""


class AuctionRules(msgspec.Struct, frozen=True):
    """The time-outs and the radius of a coordinator's auctions."""

    window_s: float = 1.0
    """About ten times the latency of a good WLAN."""
    window_growth: float = 1.5
    window_max_s: float = 12.0
    """Covers links with up to 5 s of latency each way, and their jitter."""
    answer_s: float = 1.0
    """Answer timeout of an award (s); it grows with the window."""
    radius_m: float = 25.0
    """About three lane pitches: the vehicles nearby (paper, 5)."""
    radius_growth: float = 2.0
    rest_s: float = 2.0
    rest_growth: float = 2.0
    rest_max_s: float = 20.0
    rest_aged_frac: float = 1.0
    rest_aged_max_s: float = 120.0
    """Also the time in which a vehicle hears of a task that it missed or could not take."""
    moves_deadline: bool = True
    """Bidders refuse an impossible deadline: late is better than never."""

    def radius_in_m(self, round_number: int) -> float:
        """The radius of a round in an unbounded plant (m)."""
        return self.radius_m * _growth(self.radius_growth, round_number)

    def window_in_s(self, round_number: int) -> float:
        """The bidding window of a round (s)."""
        return self._stretched_s(self.window_s, round_number)

    def answer_in_s(self, round_number: int) -> float:
        """The answer timeout of an award in a round (s)."""
        return self._stretched_s(self.answer_s, round_number)

    def rest_in_s(self, round_number: int, lasts_s: float = 0.0) -> float:
        """The pause after a round in which all bidders were asked in vain (s).

        Args:
            round_number: of that round.
            lasts_s: age of the auction (s).
        """
        grown_s = min(self.rest_s * _growth(self.rest_growth, round_number), self.rest_max_s)
        return max(grown_s, min(self.rest_aged_frac * lasts_s, self.rest_aged_max_s))

    def on_links(self, delay_s: float, deviation_s: float) -> AuctionRules:
        """The rules for links with this delay each way: slow links get long time-outs from the first round.

        Args:
            delay_s: its mean.
            deviation_s: its mean deviation.
        """
        there_and_back_s = 2.0 * (delay_s + max(DEVIATIONS * deviation_s, SLACK_FRAC * delay_s))
        return msgspec.structs.replace(
            self,
            window_s=min(max(self.window_s, there_and_back_s), self.window_max_s),
            answer_s=min(max(self.answer_s, there_and_back_s), self.window_max_s),
        )

    def _stretched_s(self, span_s: float, round_number: int) -> float:
        """A span that grows with the rounds, as the window does."""
        return span_s * min(_growth(self.window_growth, round_number), self.window_max_s / self.window_s)


def _growth(base: float, round_number: int) -> float:
    """`base` to the power of the earlier rounds; the exponent is capped to avoid overflow."""
    return float(base ** min(max(0, round_number - 1), 32))


def rank(total_s: float, finish_s: float, bidder: str) -> tuple[float, float, str]:
    """Sort key of bids: the cheapest first, then the earliest finish, then the smallest id.

    Args:
        total_s: the price with the surcharge for dropped contracts.
        finish_s: promised finish.
        bidder: its id; it makes the order total.
    """
    return (total_s, finish_s, bidder)


def prolonged_s(due_s: float, opened_s: float, now_s: float) -> float:
    """A deadline for a contractor that begins now: the original time span, but never an earlier deadline."""
    return max(due_s, now_s + due_s - opened_s)
