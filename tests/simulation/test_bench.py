"""The benchmark harness: figures beside baselines, measured in the same run."""

from __future__ import annotations

import functools
import json
from collections.abc import Callable

import pytest

from dray_sim import bench
from dray_sim.bench import Row, bus, projection, rates


def count_to(number: int, calls: list[int]) -> Callable[[], int]:
    def work() -> int:
        calls.append(number)
        return number

    return work


def test_figure_and_baseline_take_turns() -> None:
    calls: list[int] = []
    figure, baseline = rates(count_to(1, calls), count_to(2, calls), repeats=3)
    assert calls == [1, 2, 1, 2, 1, 2]
    assert figure > 0.0
    assert baseline > 0.0


def test_a_row_says_its_ratio_and_whether_its_target_was_met() -> None:
    rows = [Row("r", 30.0, "1/s", 10.0, "plain"), Row("r", 30.0, "1/s", 10.0, "plain", target=31.0)]
    assert [(row.ratio, row.met) for row in rows] == [(3.0, True), (3.0, False)]
    document = json.loads(bench.as_json(rows))
    assert [(row["ratio"], row["met"], row["target"]) for row in document["rows"]] == [
        (3.0, True, None),
        (3.0, False, 31.0),
    ]


def test_the_bus_is_measured_at_every_floor(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bus, "QUICK_SPAN_S", 0.5)
    monkeypatch.setattr(bus, "rates", functools.partial(rates, repeats=1))
    rows = bus.measure(quick=True)
    assert [row.name.removeprefix("bus: ") for row in rows] == [
        "deliveries, network",
        "deliveries, network and trace",
        "deliveries, network, trace and codec",
        "deliveries, network and workers",
        "heartbeats written and read",
    ]
    assert all(row.figure > 0.0 and row.baseline > 0.0 for row in rows)


def test_what_panels_see_is_measured_from_the_bus_to_the_frame(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in (("VEHICLES", 50), ("QUICK_ROUNDS", 2), ("QUICK_TASKS", 20), ("QUICK_SNAPSHOTS", 1)):
        monkeypatch.setattr(projection, name, value)
    monkeypatch.setattr(projection, "rates", functools.partial(rates, repeats=1))
    rows = projection.measure(quick=True)
    assert [row.name.removeprefix("projection: ") for row in rows] == [
        "heartbeats taken in",
        "facts of transports taken in",
        "frames, 5 vehicles in each",
        "snapshots of 50 vehicles",
    ]
    assert all(row.figure > 0.0 and row.baseline > 0.0 for row in rows)


def test_every_message_that_the_projection_is_measured_with_tells_it_something() -> None:
    view = projection._projection()
    for message in (*projection._heartbeats(2), *projection._facts(3)):
        view.fold(message)
    assert view.ignored == 0
    assert [task.state for task in view.tasks.views()] == ["delivered"] * 3
