"""Transit times of messages: a distribution, and the table from which delays are drawn."""

from __future__ import annotations

import math
from dataclasses import dataclass

QUANTILE_BITS = 12
"""Delays are drawn from 2^12 quantiles: one table look-up instead of a logarithm per delivery. Finer
than 0.1 ms nearly everywhere, and no agent's timer is that fine."""


@dataclass(frozen=True, slots=True)
class Latency:
    """The transit time of a message: `base_s` plus an exponential part, at most `cap_s`.

    Attributes:
        base_s: minimum on an idle WLAN: two radio hops of some 2 ms, and the two stacks.
        mean_extra_s: waiting for air time and sending again; exponential, since each try is like the last.
        cap_s: WLAN stops trying again after about this time; longer than this is loss.
    """

    base_s: float = 0.005
    mean_extra_s: float = 0.015
    cap_s: float = 0.250

    def quantiles(self) -> list[float]:
        """2^QUANTILE_BITS delays in seconds, all equally likely."""
        n = 1 << QUANTILE_BITS
        middles = ((i + 0.5) / n for i in range(n))
        return [min(self.base_s - self.mean_extra_s * math.log1p(-p), self.cap_s) for p in middles]


WLAN = Latency()
"""A factory's WLAN on an ordinary day: half of all messages within 15 ms, one in a thousand above 110 ms."""
