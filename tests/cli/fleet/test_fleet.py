"""A factory as processes: an order is delivered, whoever is killed comes back, newcomers join, all end together."""

from __future__ import annotations

import asyncio
import json
import os
import re
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from urllib.request import urlopen

import pytest
from msgspec.structs import replace

from dray import __version__
from dray.adapters.zenoh_bus import ZenohBus
from dray.adapters.zenoh_links import Links
from dray.cli.fleet.roll import Roll, read_roll
from dray.messages import AtvHeartbeat, Event, MachineHeartbeat, Message, OrderItem, TrialBrief
from dray.messages.fact import OrderFulfilled
from dray.messages.keys import Keys
from dray.plant import Plant, plant_yaml
from dray.protocol.strategist import STRATEGIST
from dray_sim.demand import Order
from dray_sim.desk import Desk
from dray_sim.generator import generate_plant
from dray_sim.loop import VirtualClock

WHOLE = generate_plant(1, machines=3, vehicles=2)

NEW_MACHINE = WHOLE.file.machines[-1]

PLANT = Plant(replace(WHOLE.file, machines=WHOLE.file.machines[:-1]))
"""As it was before the last machine was bought."""

SPEED = 20.0

AGENTS = {*PLANT.machines, *PLANT.fleet, STRATEGIST, "historian", "gateway"}

NEWCOMER = "ATV99"

START_S = 120.0
"""Eight processes with their imports, on a computer that is busy elsewhere."""

PIECES = 8
"""Enough that the order is still in work when both have been killed, one after the other."""

DELIVERED_S = 240.0
"""Real seconds for the order; some twenty are enough on a computer with nothing else to do."""


class Fleet:
    """`dray fleet up` as a process."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        plant = folder / "plant.yaml"
        plant.write_text(plant_yaml(PLANT), encoding="utf-8")
        options = (
            "--plain",
            "--no-demand",
            "--metrics",
            "--port",
            "0",
            "--speed",
            str(SPEED),
            "--plant",
            str(plant),
        )
        self.process = subprocess.Popen(
            [sys.executable, "-m", "dray", "fleet", "up", "--folder", str(folder), *options],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            cwd=folder,
        )
        self.told = ""
        assert self.process.stdout is not None
        for line in self.process.stdout:
            self.told += line
            # The gateway says the last, when it answers.
            if re.search(r"^\d+ processes", self.told, re.MULTILINE) and "Ctrl-C stops it" in line:
                return
        pytest.fail(f"the fleet has ended: {self.told}")

    @property
    def roll(self) -> Roll:
        return read_roll(self.folder)

    def metrics(self) -> dict[str, str]:
        """What every process tells Prometheus, by its name."""
        told = {}
        for group in json.loads((self.folder / "metrics.json").read_text()):
            (address,) = group["targets"]
            with urlopen(f"http://{address}/metrics", timeout=START_S) as answer:
                told[group["labels"]["instance"]] = answer.read().decode()
        return told

    def run(self, *command: str) -> str:
        """Another `dray fleet` command, on this fleet."""
        done = subprocess.run(
            [sys.executable, "-m", "dray", "fleet", *command, "--folder", str(self.folder)],
            capture_output=True,
            text=True,
            check=True,
            timeout=START_S,
        )
        return done.stdout

    def stop(self) -> int:
        self.process.send_signal(signal.SIGTERM)
        _, code = self.process.communicate(timeout=START_S), self.process.returncode
        return code


@pytest.fixture
def fleet(tmp_path: Path) -> Iterator[Fleet]:
    started = Fleet(tmp_path)
    yield started
    if started.process.poll() is None:
        started.stop()


class Witness:
    """A peer on the fleet's bus that waits for what it wants to hear."""

    def __init__(self, roll: Roll) -> None:
        peers = tuple(member.address for member in roll.members)
        self.bus = ZenohBus(Links(peers=peers, plain=True), roll.plant)
        self._heard: list[Message] = []
        self._came = asyncio.Event()
        session = self.bus.join("witness", self._hear)
        for key in (Keys(roll.plant).all_events, Keys(roll.plant).all_heartbeats):
            session.subscribe(key)

    def _hear(self, sender: str, message: Message) -> None:
        self._heard.append(message)
        self._came.set()

    async def until(self, wanted: Callable[[Message], bool]) -> None:
        looked = 0
        while not any(wanted(message) for message in self._heard[looked:]):
            looked = len(self._heard)
            self._came.clear()
            await self._came.wait()


@contextmanager
def newcomer(fleet: Fleet, *agent: str) -> Iterator[subprocess.Popen[bytes]]:
    """An agent that the plant file does not know, on trial; when the context ends it has left."""
    options = ("--trial", "1", "--settings", str(fleet.folder / "fleet.env"))
    process = subprocess.Popen([sys.executable, "-m", "dray", "agent", *agent, *options], cwd=fleet.folder)
    try:
        yield process
        assert process.wait(START_S) == 0
    finally:
        process.kill()


def assert_each_tells_its_own(told: dict[str, str]) -> None:
    assert set(told) == {*AGENTS, "floor"}
    for name, text in told.items():
        assert "process_resident_memory_bytes" in text, name
        assert ("dray_bus_messages_lost_total" in text) == (name != "floor"), name
        acts = name in PLANT.machines or name in PLANT.fleet or name == STRATEGIST
        assert ("dray_journal_write_seconds_count" in text) == acts, name
    assert "dray_historian_up 1.0" in told["historian"]
    assert "dray_database_up 1.0" in told["gateway"]


@pytest.mark.slow
def test_an_order_is_delivered_whoever_is_killed_and_a_newcomer_joins_and_leaves(fleet: Fleet) -> None:
    product = next(each for each in PLANT.products if PLANT.machines_for(each))
    order = Order("O-1", 0.0, 1e10, (OrderItem(product, PIECES),))
    atv = next(iter(PLANT.fleet))

    async def story() -> None:
        witness = Witness(fleet.roll)
        try:
            async with asyncio.timeout(START_S):
                while AGENTS - await witness.bus.roll_call():
                    pass
            assert_each_tells_its_own(await asyncio.to_thread(fleet.metrics))
            async with asyncio.timeout(DELIVERED_S):
                await Desk(witness.bus, VirtualClock()).order(order)
                for name in (atv, STRATEGIST):
                    await asyncio.to_thread(fleet.run, "kill", name)
                await witness.until(
                    lambda heard: (
                        isinstance(heard, AtvHeartbeat) and heard.atv == atv and heard.incarnation == 2
                    )
                )
                await witness.until(
                    lambda heard: (
                        isinstance(heard, Event)
                        and isinstance(heard.fact, OrderFulfilled)
                        and heard.incarnation == 2
                    )
                )
            async with asyncio.timeout(START_S):
                spec = next(iter(PLANT.fleet.values()))
                with newcomer(fleet, "atv", NEWCOMER, "--type", spec.type, "--node", spec.node) as process:
                    await witness.until(
                        lambda heard: (
                            isinstance(heard, AtvHeartbeat)
                            and heard.atv == NEWCOMER
                            and heard.trial == TrialBrief(of=1)
                        )
                    )
                    process.terminate()
                    await witness.until(
                        lambda heard: (
                            isinstance(heard, AtvHeartbeat) and heard.atv == NEWCOMER and heard.leaving
                        )
                    )
            async with asyncio.timeout(START_S):
                file = fleet.folder / "new.yaml"
                file.write_text(plant_yaml(WHOLE), encoding="utf-8")
                with newcomer(fleet, "machine", NEW_MACHINE.id, "--newcomer", str(file)) as process:
                    await witness.until(
                        lambda heard: (
                            isinstance(heard, MachineHeartbeat)
                            and heard.machine == NEW_MACHINE.id
                            and heard.newcomer is not None
                        )
                    )
                    process.terminate()
        finally:
            witness.bus.close()

    asyncio.run(story())
    starts = {member.name: member.starts for member in fleet.roll.members}
    assert {name for name, count in starts.items() if count > 1} == {atv, STRATEGIST}
    table = fleet.run("status")
    assert all(
        re.search(rf"^ {name} +\d+ +yes +(yes)? +{count} +{re.escape(__version__)} *$", table, re.MULTILINE)
        for name, count in starts.items()
    )
    pids = [member.pid for member in fleet.roll.members]
    assert fleet.stop() == 0
    for pid in pids:
        with pytest.raises(ProcessLookupError):
            os.kill(pid, 0)
    assert not (fleet.folder / "fleet.json").exists()


def test_without_a_fleet_there_is_nothing_to_show_or_kill(tmp_path: Path) -> None:
    for command in (["status"], ["kill", "ATV1"]):
        done = subprocess.run(
            [sys.executable, "-m", "dray", "fleet", *command, "--folder", str(tmp_path)],
            capture_output=True,
            text=True,
            check=False,
            timeout=START_S,
        )
        assert done.returncode == 1
        assert "start a fleet with `dray fleet up`" in done.stderr
