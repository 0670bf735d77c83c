"""The board and the alerts ask for metrics that there are, and the board can be read."""

from __future__ import annotations

import asyncio
import json
import re
from contextlib import closing
from itertools import combinations
from pathlib import Path
from typing import Any

import pytest
import yaml
from gateway_kit import gateway
from prometheus_client import CollectorRegistry, generate_latest
from prometheus_client.parser import text_string_to_metric_families

from dray.adapters.journal.sqlite_journal import SqliteJournal
from dray.adapters.security.certificates import Authority
from dray.adapters.security.identity import Identity
from dray.adapters.system_clock import SystemClock
from dray.adapters.zenoh.bus import ZenohBus
from dray.adapters.zenoh.links import Links
from dray.cli.runtime.telemetry.agent_meter import AgentMeter
from dray.cli.runtime.telemetry.body_meter import BodyMeter
from dray.cli.runtime.telemetry.bus_meter import BusMeter
from dray.cli.runtime.telemetry.clock_meter import ClockMeter
from dray.cli.simulation.factory_meter import FactoryMeter
from dray.messages.kinds import Kind
from dray.plant import default_plant
from dray_sim.clock.loop import VirtualClock
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.network.bridge import BridgedBus

DEPLOY = Path(__file__).parents[3] / "deploy"

SUFFIXES = {
    "counter": ("_total",),
    "gauge": ("",),
    "histogram": ("_bucket", "_sum", "_count"),
    "summary": ("_sum", "_count"),
}

LABELS = {"le", "job", "route", "status"}
"""Those that are everywhere, or that only a request has."""


@pytest.fixture
def anyio_backend() -> str:
    return "asyncio"


@pytest.fixture(scope="module")
def board() -> dict[str, Any]:
    loaded: dict[str, Any] = json.loads((DEPLOY / "grafana/boards/factory.json").read_text())
    return loaded


@pytest.fixture(scope="module")
def panels(board: dict[str, Any]) -> list[dict[str, Any]]:
    """Without the headings."""
    return [panel for panel in board["panels"] if panel["type"] != "row"]


@pytest.fixture(scope="module")
def rules() -> list[dict[str, Any]]:
    (group,) = yaml.safe_load((DEPLOY / "prometheus/alerts.yml").read_text())["groups"]
    found: list[dict[str, Any]] = group["rules"]
    return found


def expressions(panels: list[dict[str, Any]], rules: list[dict[str, Any]]) -> list[str]:
    return [target["expr"] for panel in panels for target in panel["targets"]] + [
        rule["expr"] for rule in rules
    ]


def bus_of(folder: Path) -> ZenohBus:
    """The place on the bus of a machine with a certificate."""
    authority = Authority.make("p")
    authority.write(folder)
    authority.issue(folder, "p", {"M1": Kind.MACHINE})
    return ZenohBus(Links(identity=Identity.in_folder(folder, "M1")), "p")


@pytest.mark.anyio
async def test_whatever_is_asked_for_is_told(
    sqlite_url: str, tmp_path: Path, panels: list[dict[str, Any]], rules: list[dict[str, Any]]
) -> None:
    loop = asyncio.get_running_loop()
    factory = SimFactory(default_plant(), VirtualClock(), seed=1)
    meter = FactoryMeter(factory, BridgedBus(factory.bus, loop, loop))
    async with gateway(sqlite_url, collectors=(meter,)) as house:
        answer = await house.client.get("/metrics")
    agents = CollectorRegistry()
    with (
        closing(SqliteJournal(tmp_path / "M1.db", events_kept=1)) as journal,
        closing(bus_of(tmp_path)) as bus,
    ):
        agents.register(AgentMeter(factory.workers["M1"], journal))
        agents.register(BodyMeter(()))
        agents.register(BusMeter(bus))
        agents.register(ClockMeter(SystemClock(loop)))
        in_a_process = generate_latest(agents).decode()
    told = {
        f"{family.name}{suffix}"
        for text in (answer.text, in_a_process)
        for family in text_string_to_metric_families(text)
        for suffix in SUFFIXES[family.type]
    }
    asked = expressions(panels, rules)
    assert len(asked) > 50
    for expression in asked:
        names = re.findall(r"\b(?:dray|process)_[a-z_]+", expression)
        assert names or "up{job=" in expression, expression
        assert set(names) <= told, expression
        assert expression.count("(") == expression.count(")")
        # A counter is of no use but as a rate or an increase, and neither is anything else.
        for name in names:
            grows = name.endswith(("_total", "_bucket", "_sum", "_count"))
            bare = rf"(?:rate|increase)\({name}(?:\{{[^}}]*\}})?\["
            assert grows == bool(re.search(bare, expression)), expression


def test_every_panel_says_what_it_shows_and_in_which_unit(panels: list[dict[str, Any]]) -> None:
    for panel in panels:
        assert panel["title"]
        assert panel["description"].endswith("."), panel["title"]
        assert panel["fieldConfig"]["defaults"]["unit"], panel["title"]
        for target in panel["targets"]:
            assert target["datasource"]["uid"] == "${source}"
            labels = re.findall(r"\{\{(\w+)\}\}", target["legendFormat"])
            for label in labels:
                assert re.search(rf"by \([^)]*\b{label}\b", target["expr"]), target


def test_no_panel_covers_another(board: dict[str, Any]) -> None:
    assert len({panel["id"] for panel in board["panels"]}) == len(board["panels"])
    places = [panel["gridPos"] for panel in board["panels"]]
    for place in places:
        assert 0 <= place["x"] < place["x"] + place["w"] <= 24
    for one, other in combinations(places, 2):
        beside = one["x"] + one["w"] <= other["x"] or other["x"] + other["w"] <= one["x"]
        over = one["y"] + one["h"] <= other["y"] or other["y"] + other["h"] <= one["y"]
        assert beside or over, (one, other)


def test_every_alert_says_what_it_means(rules: list[dict[str, Any]]) -> None:
    assert len(rules) >= 6
    for rule in rules:
        assert rule["alert"].startswith("Dray")
        assert rule["annotations"]["summary"].endswith(".")
