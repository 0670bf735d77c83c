"""A fleet whose agents have no simulated body: machines by OPC UA, vehicles by VDA 5050, people at the gate. What is killed comes back, and every piece counts once."""

from __future__ import annotations

import asyncio
import logging
import os
import signal
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from random import Random

import pytest
from fleets import AGENTS, PLANT, Fleet
from real_bodies import BrokerProcess, Gatekeeper, Imports

from dray.adapters.zenoh.bus import ZenohBus
from dray.adapters.zenoh.links import Links
from dray.messages.keys import GATE
from dray_sim.bodies.floor import Pieces
from dray_sim.remote.pieces import count_pieces

PIECES = 6
KILLS = int(os.environ.get("DRAY_TEST_KILLS", "6"))
"""More of them, and so more orders, when it is run by hand."""

BETWEEN_S = 6.0
"""Real seconds between two kills: an agent has begun its next life by then, on a computer with something else to do."""

HUNG_S = 300.0 + 40.0 * KILLS
"""Only a fleet that hangs takes so long."""

LOOK_S = 0.5

_log = logging.getLogger(__name__)
BROKER, OPCUA = "broker", "OPC UA server"


@pytest.fixture
def broker() -> Iterator[BrokerProcess]:
    process = BrokerProcess()
    yield process
    process.kill()


@pytest.fixture
def imports(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Imports:
    notes = Imports(tmp_path)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join((str(notes.path), *sys.path)))
    return notes


@pytest.fixture
def real(tmp_path: Path, broker: BrokerProcess, imports: Imports) -> Iterator[Fleet]:
    fleet = Fleet(tmp_path, "--opcua", "--vda5050", broker.url, "--people-at-gate")
    yield fleet
    if fleet.process.poll() is None:
        fleet.stop()


def lies_there(fleet: Fleet) -> Pieces:
    """All pieces of the floor, as nobody but the floor knows them."""

    async def ask() -> Pieces:
        peers = tuple(member.address for member in fleet.registry.members)
        bus = ZenohBus(Links(peers=peers, plain=True), PLANT.id)
        try:
            return await count_pieces(bus.inner, PLANT.id)
        finally:
            bus.close()

    return asyncio.run(ask())


def kill(fleet: Fleet, broker: BrokerProcess, who: str) -> None:
    """What is killed is started again: agents by the fleet, the others here."""
    if who == BROKER:
        broker.kill()
        broker.start()
    elif who == OPCUA:
        [floor] = [member for member in fleet.registry.members if member.name == "floor"]
        assert floor.signal(signal.SIGHUP)
    else:
        member = next(member for member in fleet.registry.members if member.name == who)
        member.signal(signal.SIGKILL)


def victims(count: int) -> list[str]:
    """Who is killed, in this order: a machine, the broker, the gate, a vehicle, the OPC UA server, and then whoever it hits."""
    first = [next(iter(PLANT.machines)), BROKER, GATE, next(iter(PLANT.fleet)), OPCUA]
    chance, all_there = Random(1), sorted({*AGENTS, BROKER, OPCUA})
    return [*first, *(chance.choice(all_there) for _ in range(count - len(first)))][:count]


@pytest.mark.slow
def test_every_piece_counts_once_though_agents_broker_and_opc_ua_server_are_killed(
    real: Fleet, broker: BrokerProcess, imports: Imports
) -> None:
    fleet, keeper = real, Gatekeeper(real)
    product = next(each for each in PLANT.products if PLANT.machines_for(each))
    begun_s = time.monotonic()
    left, orders, killed = victims(KILLS), [fleet.place(product, PIECES)], 0
    while True:
        assert time.monotonic() - begun_s < HUNG_S, (orders, keeper.said, left)
        there = lies_there(fleet)
        keeper.look(there.arrived)
        shown = [fleet.try_order(order) for order in orders]
        if left and time.monotonic() > begun_s + BETWEEN_S * (killed + 1):
            kill(fleet, broker, left.pop(0))
            killed += 1
        is_done = all(each is not None and each["status"] == "delivered" for each in shown)
        if is_done and not left:
            break
        if is_done:
            orders.append(fleet.place(product, PIECES))
        time.sleep(LOOK_S)

    counted = [line["delivered"] for each in shown if each is not None for line in each["items"]]
    assert counted == [PIECES] * len(orders)
    assert sum(keeper.said.values()) == PIECES * len(orders), (
        "people have said so many, and each word counted once"
    )
    there = lies_there(fleet)
    assert sum(there.arrived.values()) == PIECES * len(orders), "and so many lie there"
    assert keeper.again > 0, "words were said again, and counted once"
    seconds = round(time.monotonic() - begun_s)
    _log.info(
        "%d kills, %d pieces ordered, %d counted, %d words said again, %d s: %s",
        killed,
        PIECES * len(orders),
        sum(counted),
        keeper.again,
        seconds,
        there,
    )
    assert fleet.stop() == 0
    assert imports.processes() == {"floor"}, (
        "no agent has looked for anything of the simulator, in none of its lives"
    )
