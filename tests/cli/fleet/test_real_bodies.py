"""A fleet whose agents have no simulated body: machines by OPC UA, vehicles by VDA 5050, people at the gate. What is killed comes back, and every piece counts once."""

from __future__ import annotations

import asyncio
import logging
import os
import signal
import sys
import time
from collections.abc import Collection, Iterator
from pathlib import Path
from random import Random
from typing import Any, NamedTuple

import pytest
from fleets import AGENTS, PLANT, Fleet
from real_bodies import BrokerProcess, Gatekeeper, Imports

from dray.adapters.zenoh.bus import ZenohBus
from dray.adapters.zenoh.links import Links
from dray.cli.fleet.process_registry import Member
from dray.messages.keys import GATE
from dray_sim.bodies.floor import Pieces
from dray_sim.remote.pieces import count_pieces

PIECES = 6
KILLS = int(os.environ.get("DRAY_TEST_KILLS", "6"))
"""More of them, and so more orders, when it is run by hand."""

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


class Seen(NamedTuple):
    """What can be seen of a fleet at one moment."""

    there: Pieces
    """All pieces of the floor, as nobody but the floor knows them."""
    present: frozenset[str]
    """The agents on the bus."""


def look_at(fleet: Fleet) -> Seen:
    """Ask the floor and the bus."""

    async def ask() -> Seen:
        peers = tuple(member.address for member in fleet.registry.members)
        bus = ZenohBus(Links(peers=peers, plain=True), PLANT.id)
        try:
            return Seen(await count_pieces(bus.inner, PLANT.id), await bus.agents_present())
        finally:
            bus.close()

    return asyncio.run(ask())


def given_up(fleet: Fleet, orders: list[str]) -> set[str]:
    """The goals that were given to another machine, as the history has them by now."""
    with fleet.gateway() as client:
        told = [client.get(f"/api/orders/{order}/timeline").json() for order in orders]
    return {goal["goal"] for each in told for goal in each["goals"] if goal["ended"] == "lost"}


class Killer:
    """Kills one after the other. What is killed is started again: agents by the fleet, the others here.

    The next one is killed when the last one is back, and the orders in work have moved on since. So each kill meets a fleet at
    work, however fast the computer is.
    """

    def __init__(self, fleet: Fleet, broker: BrokerProcess, left: list[str]) -> None:
        self._fleet, self._broker, self.left = fleet, broker, left
        self.killed = 0
        self._last: Member | None = None
        """The last one, before its kill; None when it was no agent."""
        self._done = 0

    def is_back(self, present: Collection[str]) -> bool:
        """Whether the last one that was killed runs again: in its next life, and on the bus."""
        if self._last is None:
            return True
        now = self._fleet.registry.member(self._last.name)
        return now.starts > self._last.starts and now.runs and now.name in present

    def go_on(self, done: int, present: Collection[str]) -> None:
        """Kill the next one, if it is time; `done` counts the steps of all orders so far."""
        if self.left and done != self._done and self.is_back(present):
            self._done = done
            self._kill(self.left.pop(0))
            self.killed += 1

    def _kill(self, who: str) -> None:
        self._last = None
        if who == BROKER:
            self._broker.kill()
            self._broker.start()
        elif who == OPCUA:
            assert self._fleet.registry.member("floor").signal(signal.SIGHUP)
        else:
            self._last = self._fleet.registry.member(who)
            assert self._last.signal(signal.SIGKILL)


def victims(count: int) -> list[str]:
    """Who is killed, in this order: a machine, the broker, the gate, a vehicle, the OPC UA server, and then whoever it hits."""
    first = [next(iter(PLANT.machines)), BROKER, GATE, next(iter(PLANT.fleet)), OPCUA]
    chance, all_there = Random(1), sorted({*AGENTS, BROKER, OPCUA})
    return [*first, *(chance.choice(all_there) for _ in range(count - len(first)))][:count]


@pytest.mark.slow
def test_every_piece_counts_once_though_agents_broker_and_opc_ua_server_are_killed(
    real: Fleet, broker: BrokerProcess, imports: Imports
) -> None:
    fleet, keeper, killer = real, Gatekeeper(real), Killer(real, broker, victims(KILLS))
    product = next(each for each in PLANT.products if PLANT.machines_for(each))
    begun_s = time.monotonic()
    orders = [fleet.place(product, PIECES)]
    shown: list[Any] = []

    def told() -> str:
        counted = [(line["made"], line["delivered"]) for each in shown if each for line in each["items"]]
        return (
            f"ordered {len(orders)} times {PIECES}; made and delivered by the orders {counted}; there lie {seen.there}; "
            f"people have said {dict(keeper.said)}, and {keeper.again} words again; refused {dict(keeper.surplus)}; "
            f"the last word without an answer: {keeper.unanswered or 'none'}; "
            f"{killer.killed} killed, and {killer.left} not yet"
        )

    while True:
        seen = look_at(fleet)
        assert time.monotonic() - begun_s < HUNG_S, told()
        keeper.look(seen.there.arrived)
        shown = [fleet.try_order(order) for order in orders]
        if None not in shown:
            is_done = all(each["status"] == "delivered" for each in shown)
            is_calm = not killer.left and killer.is_back(seen.present)
            # The gate counts a word before it answers, so an order is delivered before its last word is answered.
            if is_done and is_calm and keeper.has_said(seen.there.arrived):
                break
            if is_done and killer.left:
                orders.append(fleet.place(product, PIECES))
            steps = sum(line["made"] + line["delivered"] for each in shown for line in each["items"])
            killer.go_on(steps, seen.present)
        time.sleep(LOOK_S)

    assert [line["delivered"] for each in shown for line in each["items"]] == [PIECES] * len(orders), told()
    assert keeper.said.total() == PIECES * len(orders), f"each word counts once: {told()}"
    assert keeper.again > 0, f"words were said again, and counted once: {told()}"
    while not given_up(fleet, orders) >= set(keeper.surplus):
        assert time.monotonic() - begun_s < HUNG_S, f"only what another machine has got is surplus: {told()}"
        time.sleep(LOOK_S)
    seconds = round(time.monotonic() - begun_s)
    _log.info("%d s: %s", seconds, told())
    assert fleet.stop() == 0
    assert imports.processes() == {"floor"}, (
        "no agent has looked for anything of the simulator, in none of its lives"
    )
