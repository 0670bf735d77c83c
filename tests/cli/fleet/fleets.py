"""A factory as processes, for tests: a fleet of a small plant, and a peer on its bus."""

from __future__ import annotations

import asyncio
import json
import os
import re
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Collection
from pathlib import Path
from typing import Any
from urllib.request import urlopen

import httpx
import msgspec
import pytest
from msgspec.structs import replace

from dray.adapters.security.identity import Identity
from dray.adapters.zenoh.bus import ZenohBus
from dray.adapters.zenoh.links import Links
from dray.cli.fleet.folder import CERTIFICATES, OBSERVER
from dray.cli.fleet.process_registry import ProcessRegistry, read_registry
from dray.cli.fleet.rollout.report import Report
from dray.messages import Event, Message
from dray.messages.fact import Fact
from dray.messages.keys import GATE, STRATEGIST, Keys
from dray.plant import Plant, plant_yaml
from dray_sim.plants.generator import generate_plant

WHOLE = generate_plant(1, machines=3, vehicles=2)

NEW_MACHINE = WHOLE.file.machines[-1]

PLANT = Plant(replace(WHOLE.file, machines=WHOLE.file.machines[:-1]))
"""As it was before the last machine was bought."""

AGENTS = {*PLANT.machines, *PLANT.storages, *PLANT.fleet, GATE, STRATEGIST, "historian", "gateway"}

SPEED = 10.0
"""An agent is suspected after 3 s of the plant; faster, and a busy computer makes all of them look silent."""

TOKEN = "admin-token-of-these-fleets"

START_S = 240.0
"""Ten processes with their imports, on a computer that is busy elsewhere."""

PIECES = 12
"""Seven minutes of the plant: an order of so many is still in work when an agent was killed and has been silent for 15 s."""

DELIVERED_S = 300.0
"""Real seconds for such an order; some forty are enough on a computer with nothing else to do."""

UPDATE_S = 300.0
"""Eight processes, one after the other, on the same."""


class Fleet:
    """`dray fleet up` as a process.

    Args:
        folder: of the fleet.
        more: options beside those of all fleets here.
        plain: links without certificates.
    """

    def __init__(self, folder: Path, *more: str, plain: bool = True) -> None:
        self.folder = folder
        plant = folder / "plant.yaml"
        plant.write_text(plant_yaml(PLANT), encoding="utf-8")
        options = (
            *(["--plain"] if plain else []),
            "--no-demand",
            "--metrics",
            "--port",
            "0",
            "--speed",
            str(SPEED),
            "--plant",
            str(plant),
            *more,
        )
        self.process = subprocess.Popen(
            [sys.executable, "-m", "dray", "fleet", "up", "--folder", str(folder), *options],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            cwd=folder,
            env={**os.environ, "DRAY_ADMIN_TOKEN": TOKEN},
        )
        self.told = ""
        hurry = threading.Timer(START_S, self.process.kill)
        hurry.start()
        assert self.process.stdout is not None
        for line in self.process.stdout:
            self.told += line
            if re.search(r"^\d+ processes", self.told, re.MULTILINE) and "Ctrl-C stops it" in self.told:
                hurry.cancel()
                return
        pytest.fail(f"the fleet has ended, or does not start: {self.told}")

    @property
    def registry(self) -> ProcessRegistry:
        return read_registry(self.folder)

    def gateway(self) -> httpx.Client:
        """A client of its gateway, with the administrator's token."""
        [url] = re.findall(r"Management panel +(http\S+)/$", self.told, re.MULTILINE)
        return httpx.Client(base_url=url, headers={"authorization": f"Bearer {TOKEN}"}, timeout=START_S)

    def place(self, product: str, quantity: int) -> str:
        """Order at the gateway; returns the order's id."""
        with self.gateway() as client:
            draft = {"customer": "Muster GmbH", "items": [{"product": product, "quantity": quantity}]}
            answer = client.post("/api/orders", json=draft)
        assert answer.status_code == 201, answer.text
        return str(answer.json()["id"])

    def order(self, order: str) -> Any:
        """An order, as the gateway shows it."""
        with self.gateway() as client:
            answer = client.get(f"/api/orders/{order}")
        assert answer.status_code == 200, answer.text
        return answer.json()

    def try_order(self, order: str) -> Any:
        """The same; None while the gateway is away."""
        try:
            return self.order(order)
        except httpx.TransportError:
            return None

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

    def update(self, python: Path, *options: str) -> tuple[int, Report]:
        """`dray fleet update`: its exit code and its report."""
        file = self.folder / "report.json"
        command = ("fleet", "update", "--python", str(python), "--folder", str(self.folder))
        done = subprocess.run(
            [sys.executable, "-m", "dray", *command, "--json", str(file), *options],
            capture_output=True,
            text=True,
            check=False,
            timeout=UPDATE_S,
        )
        assert file.exists(), done.stderr
        return done.returncode, msgspec.json.decode(file.read_bytes(), type=Report)

    def stop(self) -> int:
        self.process.send_signal(signal.SIGTERM)
        _, code = self.process.communicate(timeout=START_S), self.process.returncode
        return code


class Witness:
    """A peer on the fleet's bus that waits for what it wants to hear.

    Args:
        registry: of the fleet.
        folder: of one that has certificates; None for a plain one.
    """

    def __init__(self, registry: ProcessRegistry, folder: Path | None = None) -> None:
        peers = tuple(member.address for member in registry.members)
        identity = None if folder is None else Identity.in_folder(folder / CERTIFICATES, OBSERVER)
        self.bus = ZenohBus(Links(peers=peers, identity=identity, plain=folder is None), registry.plant)
        self.heard: list[Message] = []
        self._came = asyncio.Event()
        session = self.bus.join("witness" if folder is None else OBSERVER, self._on_message)
        for key in (Keys(registry.plant).all_events, Keys(registry.plant).all_heartbeats):
            session.subscribe(key)

    def _on_message(self, sender: str, message: Message) -> None:
        self.heard.append(message)
        self._came.set()

    async def all_there(self, agents: Collection[str]) -> None:
        """Wait until all of these are on the bus."""
        while set(agents) - await self.bus.agents_present():
            pass

    async def told(self, kind: type[Fact]) -> Event:
        """The first event of a kind."""
        await self.until(lambda heard: isinstance(heard, Event) and isinstance(heard.fact, kind))
        return next(each for each in self.heard if isinstance(each, Event) and isinstance(each.fact, kind))

    async def until(self, wanted: Callable[[Message], bool]) -> None:
        looked = 0
        while not any(wanted(message) for message in self.heard[looked:]):
            looked = len(self.heard)
            await self.until_more()

    async def until_more(self) -> None:
        """Wait until anything is heard."""
        self._came.clear()
        await self._came.wait()
