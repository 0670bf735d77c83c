"""The meter counts a fact once, and goes on after a thief of its agent's certificate has told a number of the far future."""

from __future__ import annotations

from prometheus_client import CollectorRegistry

from dray.gateway.metrics.meter import Meter
from dray.messages import Event
from dray.messages.base import COUNT_MAX
from dray.messages.fact import PieceMade
from dray.messages.overtaken import OVERTAKES_S


def made(number: int, life: int = 1) -> Event:
    return Event("M1", life, number, 0.0, PieceMade(goal="G1", product="pump", made=number))


def test_a_number_of_the_far_future_does_not_end_the_counting_of_facts() -> None:
    registry = CollectorRegistry()
    meter = Meter(registry)

    def pieces() -> float | None:
        return registry.get_sample_value("dray_pieces_made_total")

    for event in (made(1), made(1), made(2), made(COUNT_MAX, COUNT_MAX)):
        meter.count(event, 10.0)
    assert pieces() == 3
    meter.count(made(2), 11.0)
    assert pieces() == 3, "it came late, or twice"
    meter.count(made(9), 10.0 + OVERTAKES_S + 0.1)
    meter.count(made(9), 10.0 + OVERTAKES_S + 0.2)
    assert pieces() == 4
