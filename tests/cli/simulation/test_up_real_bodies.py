"""`dray up --real-bodies`: machines, storages and gate behind an OPC UA server and vehicles behind a broker, in one command."""

from __future__ import annotations

import asyncio
import re
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from asyncua import Client

from dray.cli.commands.simulation.up import controlled
from dray.plant import default_plant

PATIENCE_S = 400.0
"""Far beyond what a busy computer takes for one order."""

CONTROLLED = {*default_plant().machines, *default_plant().stores, "gate"}

ORDER = {"customer": "Hall 3", "items": [{"product": "gear-unit-g1", "quantity": 1}]}


async def alive(url: str) -> dict[str, int]:
    """What agents have counted up at their machines and storages, and the gate."""
    async with Client(url) as client:
        return {name: await client.get_node(f"ns=2;s={name}.alive").read_value() for name in CONTROLLED}


async def at_the_gate(url: str) -> int:
    """What its counter shows."""
    async with Client(url) as client:
        return int(await client.get_node("ns=2;s=gate.pieces").read_value())


@pytest.mark.slow
def test_an_order_is_delivered_while_agents_speak_to_the_server(start_dray: Callable[..., Any]) -> None:
    dray = start_dray("--real-bodies", "--no-demand", "--speed", "5")
    said = dray.output()
    assert "mqtt://127.0.0.1:" in said
    folder = Path(re.findall(r"Mapping files +(\S+),", said)[0])
    assert {file.stem for file in folder.iterdir()} == CONTROLLED
    url = re.findall(r"opc\.tcp://[^\s,]+", said)[0]
    until_s = time.monotonic() + PATIENCE_S
    # Each agent counts up for the first time soon after it was linked.
    while not all((counted := asyncio.run(alive(url))).values()):
        assert time.monotonic() < until_s, counted
        time.sleep(0.5)
    assert asyncio.run(at_the_gate(url)) == 0
    path = f"/api/orders/{dray.ask('/api/orders', ORDER)['id']}"
    until_s = time.monotonic() + PATIENCE_S
    while dray.ask(path)["status"] != "delivered":
        assert time.monotonic() < until_s, dray.ask(path)
        time.sleep(0.5)
    assert asyncio.run(at_the_gate(url)) == 1
    assert not any(machine["problem"] for machine in dray.ask("/api/machines")["items"])
    assert dray.stop() == 0, dray.output()
    assert not folder.exists()


def test_nothing_is_started_where_nobody_asks_for_it() -> None:
    with controlled(default_plant(), real_bodies=False) as server:
        assert server is None
