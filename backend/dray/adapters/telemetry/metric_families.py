"""Metrics that are read on demand: names begin with `dray_`, and a counter's ends in `_total`."""

from __future__ import annotations

from collections.abc import Mapping

from prometheus_client import Metric
from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily


def gauge(name: str, what: str, value: float) -> Metric:
    """A value that rises and falls."""
    return GaugeMetricFamily(f"dray_{name}", what, value=float(value))


def counter(name: str, what: str, value: float) -> Metric:
    """A value that only grows."""
    return CounterMetricFamily(f"dray_{name}", what, value=value)


def gauges(name: str, what: str, label: str, values: Mapping[str, float]) -> Metric:
    """Gauges of one name, by the value of a label."""
    family = GaugeMetricFamily(f"dray_{name}", what, labels=(label,))
    for each, value in values.items():
        family.add_metric((each,), value)
    return family


def counters(name: str, what: str, label: str, values: Mapping[str, float]) -> Metric:
    """Counters of one name, by the value of a label."""
    family = CounterMetricFamily(f"dray_{name}", what, labels=(label,))
    for each, value in values.items():
        family.add_metric((each,), value)
    return family
