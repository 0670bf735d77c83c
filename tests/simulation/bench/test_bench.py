"""The benchmark harness: figures beside baselines, measured in the same run."""

from __future__ import annotations

import functools
import json
from collections import Counter
from collections.abc import Callable
from math import hypot

import pytest

from dray.gateway.live.projection import Projection
from dray.gateway.live.timescale import TimeScale
from dray.messages import AtvHeartbeat
from dray_sim import bench
from dray_sim.bench import Row, orders, rates
from dray_sim.bench.document import document
from dray_sim.bench.network import bus, zenoh
from dray_sim.bench.panels import projection
from dray_sim.bench.panels.crowd import GROUP, Crowd
from dray_sim.bench.postgres import installed


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


def test_a_document_has_every_figure_and_says_how_many_aims_are_missed() -> None:
    rows = [Row("a", 30.0, "1/s", 10.0, "plain"), Row("b|c", 30.0, "1/s", 10.0, "plain", target=31.0)]
    text = document(rows, "dray bench bus --out docs/benchmarks.md")
    assert "Made by `dray bench bus --out docs/benchmarks.md`" in text
    assert "2 figures, 1 with an aim, 1 of which are missed." in text
    assert text.splitlines()[-2:] == [
        "| a | 30 1/s | 3 x plain |  |  |",
        "| b/c | 30 1/s | 3 x plain | 31 MISSED |  |",
    ]


@pytest.mark.campaign
def test_the_adapter_is_measured_beside_bare_zenoh_between_two_processes(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(zenoh, "ROUND_TRIPS", 20 * zenoh.QUICK)
    monkeypatch.setattr(zenoh, "MESSAGES", 1_000 * zenoh.QUICK)
    monkeypatch.setattr(zenoh, "rates", functools.partial(rates, repeats=1))
    rows = zenoh.measure(quick=True)
    assert [(row.name.removeprefix("zenoh: "), row.baseline_name) for row in rows] == [
        ("round trips", "bare Zenoh"),
        ("messages one way", "bare Zenoh"),
        ("round trips", "bare Zenoh and the codec"),
        ("messages one way", "bare Zenoh and the codec"),
        ("round trips, TLS and signed", "bare Zenoh"),
        ("messages one way, TLS and signed", "bare Zenoh"),
        ("round trips, TLS and encrypted for one reader", "bare Zenoh"),
        ("messages one way, TLS and encrypted for one reader", "bare Zenoh"),
    ]
    assert all(row.figure > 0.0 and row.baseline > 0.0 for row in rows)


@pytest.mark.campaign
def test_orders_are_measured_on_each_database_and_beside_open_ones(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(orders, "OPEN", (0, 50))
    monkeypatch.setattr(orders, "ORDERS", {1: 3, 16: 16})
    monkeypatch.setattr(orders, "QUICK_ROUNDS", 1)
    rows = orders.measure(quick=True)
    databases = ("SQLite", "PostgreSQL") if installed() else ("SQLite",)
    assert [row.name for row in rows] == [
        f"orders: {database}, {count} open, {clients}"
        for database in databases
        for count in (0, 50)
        for clients in ("1 client", "16 clients")
    ]
    assert all(row.figure > 0.0 and row.baseline > 0.0 for row in rows)


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


def test_where_less_is_better_a_target_is_met_from_above() -> None:
    rows = [Row("r", figure, "ms", 10.0, "plain", target=8.0, less=True) for figure in (7.9, 8.0, 8.1)]
    assert [row.met for row in rows] == [True, True, False]


def test_a_crowd_says_a_heartbeat_per_agent_and_second_from_where_its_lanes_are() -> None:
    crowd = Crowd(20)
    told = [message for tenth in range(1, 51) for message in crowd.until(tenth / 10 - 1e-6)]
    said = Counter(getattr(message, "atv", None) or message.machine for message in told)
    assert set(said) == {*crowd.plant.fleet, *crowd.plant.machines}
    assert set(said.values()) == {5}
    for message in told:
        if isinstance(message, AtvHeartbeat):
            lane = crowd.plant.roads.lane(message.node, message.way[0])
            assert lane is not None
            begin = crowd.plant.nodes[message.node]
            assert hypot(message.pose.x_m - begin.x_m, message.pose.y_m - begin.y_m) <= lane.length_m
    ways = [message.pose for message in told if getattr(message, "atv", None) == "ATV1"]
    assert len(set(ways)) == 5


def test_what_a_crowd_says_is_understood_and_watched_over() -> None:
    crowd = Crowd(20)
    view = Projection(crowd.plant.file, TimeScale(0.0, 0.0))
    for message in (*crowd.transports(), *crowd.until(2.0)):
        view.fold(message)
    assert view.ignored == 0
    tasks = view.tasks.views()
    assert len(tasks) == 20 // GROUP
    assert all(task.state == "contracted" and task.secondary for task in tasks)
