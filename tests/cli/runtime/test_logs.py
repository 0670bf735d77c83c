"""Logs for programs: one object in a line, with what a fact is about."""

from __future__ import annotations

import io
import json
import logging
from typing import Any

import pytest

from dray.adapters.telemetry.fact_log import FACTS, LoggedBus
from dray.cli.runtime.telemetry.logs import JsonFormatter
from dray.cli.runtime.telemetry.traces import traced, watched
from dray.errors import SettingsError
from dray.messages import Event, Handover, Message, Reason
from dray.messages.fact import TookOver
from dray.settings import Settings

TOOK = TookOver(task="M8-17", epoch=2, primary="ATV3", silent_s=3.5, reason=Reason.SILENT)


class Bus:
    """Keeps what is said."""

    context = ""

    def __init__(self) -> None:
        self.said: list[Message] = []

    def join(self, agent: str, receive: object, life: int = 0) -> Bus:
        return self

    def publish(self, key: str, message: Message) -> None:
        self.said.append(message)

    def send(self, to: str, message: Message) -> None:
        self.said.append(message)


@pytest.fixture
def lines():
    """What is logged from now on, line by line."""
    written = io.StringIO()
    handler = logging.StreamHandler(written)
    handler.setFormatter(JsonFormatter())
    root = logging.getLogger()
    level = root.level
    root.addHandler(handler)
    root.setLevel(logging.INFO)
    yield lambda: [json.loads(line) for line in written.getvalue().splitlines()]
    root.removeHandler(handler)
    root.setLevel(level)


def test_a_fact_is_logged_with_its_task_and_epoch_and_said_all_the_same(lines) -> None:
    bus = Bus()
    session = LoggedBus(bus).join("ATV1", lambda _sender, _message: None)
    fact = Event(agent="ATV1", incarnation=1, number=9, at_s=60.0, fact=TOOK)
    handover = Handover(task="M8-17", epoch=2, quantity=4)
    session.publish("plant/event/ATV1", fact)
    session.send("M8", handover)
    assert bus.said == [fact, handover]
    (line,) = lines()
    line.pop("at")
    assert line == {
        "level": "info",
        "logger": FACTS,
        "message": "ATV1: TookOver",
        "agent": "ATV1",
        "fact": "TookOver",
        "task": "M8-17",
        "epoch": 2,
        "reason": "silent",
    }


def test_a_fault_is_one_line_with_its_traceback_inside(lines) -> None:
    fault = RuntimeError("a\nfault")
    logging.getLogger("dray.test").error("it went wrong: %s", 7, exc_info=fault)
    (line,) = lines()
    assert (line["level"], line["message"]) == ("error", "it went wrong: 7")
    assert "RuntimeError: a\nfault" in line["error"]
    assert line["at"].endswith("+00:00")


def meet(**options: Any) -> object:
    """Where agents meet by these settings, and whether that is the bus itself."""
    settings, bus = Settings.load(**options), Bus()
    with traced(settings) as provider:
        return watched(settings, provider, lambda plant_s: plant_s)(bus), bus


def test_nothing_stands_between_agents_and_their_bus_unless_somebody_asks_for_it() -> None:
    met, bus = meet()
    assert met is bus
    met, bus = meet(log_format="json")
    assert isinstance(met, LoggedBus)
    met, bus = meet(trace_url="http://127.0.0.1:9/v1/traces")
    assert type(met).__name__ == "TracedBus"


def test_a_collector_that_is_no_address_is_refused() -> None:
    with pytest.raises(SettingsError, match="trace-url"):
        Settings.load(trace_url="collector:4318")
