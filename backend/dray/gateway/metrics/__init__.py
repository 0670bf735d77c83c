"""Metrics: what the gateway counts and measures, in Prometheus' words.

Names end in their unit, or in `_total` where they only grow. Labels are words of ours (a kind, a status, a
reason, a route's template), never ids or what a peer has written, so that there are few series. Times of
the factory are seconds of the plant's clock.

`meter` counts what is heard on the bus, `stopwatch` how long requests take; `state` and `history` read what
the other parts know anyway when somebody asks.
"""

from __future__ import annotations

from dray.gateway.metrics.metrics import Metrics
from dray.gateway.metrics.stopwatch import Stopwatch

__all__ = ["Metrics", "Stopwatch"]
