"""Metrics: the gateway's counts and measurements, in Prometheus' terms.

Names end in their unit, or in `_total` for counters. Labels are our own words (a kind, a status, a reason, a
route's template), never ids or a peer's text, which bounds the number of series. Factory times are seconds of
the plant's clock.

`meter` counts messages on the bus, `stopwatch` measures requests; `state` and `history` read other parts'
data on request.
"""

from __future__ import annotations

from dray.gateway.metrics.metrics import Metrics
from dray.gateway.metrics.stopwatch import Stopwatch

__all__ = ["Metrics", "Stopwatch"]
