"""How patient and how far-reaching a coordinator is, round after round: pure arithmetic.

    radius_m = first radius * radius_growth ^ (round - 1)
    window_s = first window * window_growth ^ (round - 1), up to window_max_s; the wait for an answer grows with it
    rest_s   = first rest   * rest_growth   ^ (round - 1), up to rest_max_s; and a part of the time that it has lasted,
               up to rest_aged_max_s: who is free asks for what has waited so long

Before its first round an auction has the values of that round.
"""

from __future__ import annotations

import msgspec

from dray.protocol.liveness.suspicion import DEVIATIONS

PATIENCE_S = 300.0
"""What has waited so long is as urgent as what was needed by now."""


SLACK_FRAC = 0.1
"""Of the mean delay: a link that never varies is waited for so much longer, for the bidder thinks, too."""


class AuctionRules(msgspec.Struct, frozen=True):
    """The time-outs and the radius of a coordinator's auctions."""

    window_s: float = 1.0
    """Some ten times the latency of a good WLAN."""
    window_growth: float = 1.5
    window_max_s: float = 12.0
    """Covers links with up to 5 s of latency each way, and what they vary by."""
    answer_s: float = 1.0
    """How long an award may stay unanswered; grows with the window."""
    radius_m: float = 25.0
    """About three lane pitches: the vehicles nearby (paper, 5)."""
    radius_growth: float = 2.0
    rest_s: float = 2.0
    rest_growth: float = 2.0
    rest_max_s: float = 20.0
    rest_aged_frac: float = 1.0
    rest_aged_max_s: float = 120.0
    """A vehicle that did not hear of it, or could not take it, learns of it by then."""
    moves_deadline: bool = True
    """Where bidders refuse what they cannot do in time, late is better than never."""

    def radius_in_m(self, round_number: int) -> float:
        """How far a round reaches, in a plant without end."""
        return self.radius_m * _growth(self.radius_growth, round_number)

    def window_in_s(self, round_number: int) -> float:
        """How long bids are collected in a round."""
        return self._stretched_s(self.window_s, round_number)

    def answer_in_s(self, round_number: int) -> float:
        """How long an award may stay unanswered in a round."""
        return self._stretched_s(self.answer_s, round_number)

    def rest_in_s(self, round_number: int, lasts_s: float = 0.0) -> float:
        """How long the auction pauses after a round in which all bidders were asked in vain.

        Args:
            round_number: of that round.
            lasts_s: since when the auction has been open.
        """
        grown_s = min(self.rest_s * _growth(self.rest_growth, round_number), self.rest_max_s)
        return max(grown_s, min(self.rest_aged_frac * lasts_s, self.rest_aged_max_s))

    def on_links(self, delay_s: float, deviation_s: float) -> AuctionRules:
        """The rules for links with this delay each way: on slow ones patient from the beginning.

        Args:
            delay_s: the mean of it.
            deviation_s: the mean deviation from it.
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
    """`base` to the power of the rounds before this one; held, so that endless rounds do not overflow."""
    return float(base ** min(max(0, round_number - 1), 32))


def rank(total_s: float, finish_s: float, bidder: str) -> tuple[float, float, str]:
    """Bidders are asked in the order of this: the cheapest first; then who is done earlier; then the smaller id.

    Args:
        total_s: the price, with what its coordinator adds for contracts that the bidder has dropped.
        finish_s: when it would be done.
        bidder: its id; it makes the order total.
    """
    return (total_s, finish_s, bidder)


def prolonged_s(due_s: float, opened_s: float, now_s: float) -> float:
    """A deadline for who begins now: as much time as the task was given at first, and no earlier than then."""
    return max(due_s, now_s + due_s - opened_s)
