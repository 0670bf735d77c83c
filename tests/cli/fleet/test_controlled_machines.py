"""A fleet whose machines are behind an OPC UA server: their agents are killed, and every piece is counted once."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Iterator
from pathlib import Path

import msgspec
import pytest
from asyncua import Client
from fleets import DELIVERED_S, PLANT, Fleet

from dray.adapters.mapping_file import load_mapping
from dray.adapters.opcua.mapping_file import OpcUaMapping
from dray.adapters.signals.counting import CounterState
from dray.adapters.signals.signal import Signal
from dray.adapters.signals.workcell import Kept

PIECES = 6
LOOK_S = 0.5


@pytest.fixture
def controlled(tmp_path: Path) -> Iterator[Fleet]:
    fleet = Fleet(tmp_path, "--opcua")
    yield fleet
    if fleet.process.poll() is None:
        fleet.stop()


async def shown(mapping: OpcUaMapping) -> int:
    """What a machine's counter shows."""
    async with Client(mapping.url) as client:
        node = client.get_node(mapping.signals[Signal.PIECES].node)
        return int(await node.read_value())


def kept(fleet: Fleet, machine: str) -> Kept:
    file = fleet.folder / "journals" / f"{machine}.workcell.json"
    return msgspec.json.decode(file.read_bytes(), type=Kept)


@pytest.mark.slow
def test_an_order_is_delivered_though_each_machines_agent_is_killed(controlled: Fleet) -> None:
    fleet = controlled
    product = next(each for each in PLANT.products if PLANT.machines_for(each))
    mappings = {
        machine: load_mapping(fleet.folder / "controllers" / f"{machine}.yaml", OpcUaMapping)
        for machine in PLANT.machines
    }
    until_s = time.monotonic() + DELIVERED_S
    left = [*PLANT.machines]
    orders = 0
    while left:
        # An order that was delivered between two looks has killed nobody, so another one is placed.
        order = fleet.place(product, PIECES)
        orders += 1
        while (shows := fleet.order(order))["status"] != "delivered":
            assert time.monotonic() < until_s, shows
            if left and any(line["made"] for line in shows["items"]):
                fleet.run("kill", left.pop())
            time.sleep(LOOK_S)
    counted = {machine: asyncio.run(shown(mapping)) for machine, mapping in mappings.items()}
    assert sum(counted.values()) >= PIECES * orders
    while any(state is None or state.value != counted[machine] for machine, state in states(fleet).items()):
        assert time.monotonic() < until_s, (counted, states(fleet))
        time.sleep(LOOK_S)
    assert {kept(fleet, machine).doubt for machine in mappings} == {""}
    assert fleet.stop() == 0


def states(fleet: Fleet) -> dict[str, CounterState | None]:
    return {machine: kept(fleet, machine).pieces for machine in PLANT.machines}
