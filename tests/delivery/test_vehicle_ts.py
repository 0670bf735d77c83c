"""The vehicle in TypeScript joins a plant with certificates, and all that is ordered is carried by it alone."""

from __future__ import annotations

import asyncio
import json
import os
import re
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest
from msgspec.structs import replace
from vehicle_ts_kit import PLANT_FILE, SOURCES, node

from dray.adapters.security.certificates import Authority
from dray.adapters.security.identity import Identity
from dray.adapters.security.signing import SigningKey
from dray.adapters.zenoh.bus import ZenohBus
from dray.adapters.zenoh.links import Links
from dray.cli.runtime.roster import agents_of
from dray.messages import (
    AtvHeartbeat,
    AtvStatus,
    CommandAnswered,
    CommandKind,
    CommandRefusal,
    Event,
    MachineHeartbeat,
    Message,
    OrderItem,
    OrderReleased,
    OrderTaken,
    Reason,
    Release,
    Role,
    VehicleCommand,
)
from dray.messages.fact import OrderFulfilled
from dray.messages.keys import STRATEGIST, Keys
from dray.messages.kinds import Kind
from dray.plant import load_plant

PLANT = load_plant(PLANT_FILE)
KEYS = Keys(PLANT.id)
VEHICLE = "A1"
SPEED = 5.0
"""Factory seconds per real one: an agent is suspected after 0.7 real seconds of silence."""

PATIENCE_S = 240.0
"""Real seconds for what takes some ten on a computer with nothing else to do."""

TAKEN_AWAY = {Reason.RELEASED, Reason.SUPERSEDED}
"""Ends of a contract that a coordinator gives to another vehicle, or to the same one again."""

COMMANDS = SigningKey(bytes(range(32)))


def free_address() -> str:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return f"127.0.0.1:{probe.getsockname()[1]}"


class Workshop:
    """Processes of a plant with TLS: a floor, a strategist, a machine; and the vehicle from elsewhere."""

    def __init__(self, folder: Path, stack: ExitStack, address: str) -> None:
        self.folder, self._stack, self._address = folder, stack, address
        self.certificates = folder / "certs"
        authority = Authority.make(PLANT.id)
        authority.write(self.certificates)
        names: dict[str, Kind] = {
            "floor": Kind.HISTORIAN,
            STRATEGIST: Kind.STRATEGIST,
            "gateway": Kind.GATEWAY,
            **agents_of(PLANT),
        }
        for name, kind in names.items():
            authority.issue(self.certificates, PLANT.id, {name: kind})
        (folder / "plant.json").write_text(self._dray("plant", "json", str(PLANT_FILE)))

    def start_agents(self) -> None:
        others = [("agent", kind, agent) for agent, kind in agents_of(PLANT).items() if agent != VEHICLE]
        for command in (("floor",), (STRATEGIST,), *others):
            self._start(
                command[-1],
                sys.executable,
                "-m",
                "dray",
                *command,
                DRAY_BUS_PEERS=self._address,
                **self._settings(),
            )

    def start_vehicle(self) -> subprocess.Popen[bytes]:
        return self._start(
            VEHICLE,
            str(node()),
            str(SOURCES / "main.ts"),
            *("--name", VEHICLE, "--plant", str(self.folder / "plant.json")),
            *("--certificates", str(self.certificates), "--peers", self._address),
            *("--notes", str(self.folder / "notes"), "--speed", str(SPEED)),
            *("--trusted-keys", COMMANDS.public.hex()),
        )

    def words(self, name: str) -> str:
        return (self.folder / f"{name}.log").read_text()

    def _settings(self) -> dict[str, str]:
        return {
            "DRAY_PLANT_FILE": str(PLANT_FILE),
            "DRAY_PLANT_SPEED": str(SPEED),
            # This vehicle keeps no right of way.
            "DRAY_TRAFFIC": "false",
            "DRAY_BUS_CERTIFICATES": str(self.certificates),
            "DRAY_JOURNAL_FOLDER": str(self.folder / "journals"),
        }

    def _dray(self, *command: str) -> str:
        return subprocess.run(
            (sys.executable, "-m", "dray", *command), stdout=subprocess.PIPE, text=True, check=True
        ).stdout

    def _start(self, name: str, *command: str, **settings: str) -> subprocess.Popen[bytes]:
        log = self._stack.enter_context((self.folder / f"{name}.log").open("ab"))
        process = subprocess.Popen(
            command, cwd=self.folder, env={**os.environ, **settings}, stdout=log, stderr=subprocess.STDOUT
        )
        self._stack.callback(process.wait)
        self._stack.callback(process.kill)
        return process


class Gateway:
    """Hears everything, and asks for things in people's name."""

    def __init__(self, bus: ZenohBus) -> None:
        self.heard: list[Message] = []
        self._changed = asyncio.Event()
        self._session = bus.join("gateway", self._on_message)
        self._session.subscribe(KEYS.all_heartbeats)
        self._session.subscribe(KEYS.all_events)

    def send(self, to: str, message: Message) -> None:
        self._session.send(to, message)

    async def until(self, seen: Callable[[Any], bool]) -> Any:
        """The first message for which this holds, of all that were heard since the start."""
        looked = 0
        while True:
            for message in self.heard[looked:]:
                looked += 1
                if seen(message):
                    return message
            self._changed.clear()
            await self._changed.wait()

    def _on_message(self, _sender: str, message: Message) -> None:
        self.heard.append(message)
        self._changed.set()


def ends_of(words: str) -> list[str]:
    """How each contract has ended that the vehicle has taken; empty for one that has not."""
    ends: dict[str, list[str]] = {}
    for takes, task, end in re.findall(rf"^{VEHICLE} (takes )?(\S+): (.*)$", words, re.MULTILINE):
        if takes:
            ends.setdefault(task, []).append("")
        elif task in ends:
            ends[task][-1] = end
    return [end for each in ends.values() for end in each]


def command(name: str, kind: CommandKind) -> VehicleCommand:
    """With a grant for the whole plant."""
    asked = VehicleCommand(command=name, kind=kind)
    return COMMANDS.grant(VEHICLE, asked, person="p1", areas=None, valid_until_s=time.time() * SPEED + 600)


@pytest.fixture
def stack() -> Iterator[ExitStack]:
    with ExitStack() as opened:
        yield opened


@pytest.mark.slow
def test_it_joins_with_tls_and_all_that_is_ordered_arrives(tmp_path: Path, stack: ExitStack) -> None:
    address = free_address()
    workshop = Workshop(tmp_path, stack, address)

    async def story() -> None:
        identity = Identity.in_folder(workshop.certificates, "gateway")
        bus = ZenohBus(Links(listen=(address,), identity=identity), PLANT.id)
        stack.callback(bus.close)
        gateway = Gateway(bus)
        workshop.start_agents()
        async with asyncio.timeout(PATIENCE_S):
            # It has a body, so the floor is there, for which nobody waits longer than half a minute.
            await gateway.until(lambda said: isinstance(said, MachineHeartbeat))
            vehicle = workshop.start_vehicle()
            await gateway.until(lambda said: isinstance(said, AtvHeartbeat) and said.atv == VEHICLE)

            # What a person says holds it, and lets it go on.
            for name, kind, status in (
                ("C1", CommandKind.STOP, AtvStatus.STOPPED),
                ("C2", CommandKind.ACKNOWLEDGE, AtvStatus.STOPPED),
                ("C3", CommandKind.RESUME, AtvStatus.IDLE),
            ):
                asked = command(name, kind)
                gateway.send(VEHICLE, asked)
                answer = await gateway.until(
                    lambda said, name=name: isinstance(said, CommandAnswered) and said.command == name
                )
                assert (answer.done, answer.reason) == (True, None)
                gateway.heard.clear()
                await gateway.until(
                    lambda said, status=status: isinstance(said, AtvHeartbeat) and said.status is status
                )
            gateway.send(VEHICLE, replace(command("C4", CommandKind.STOP), speed_frac=0.5))
            answer = await gateway.until(lambda said: isinstance(said, CommandAnswered))
            assert not answer.done
            assert answer.reason is CommandRefusal.NOT_TRUSTED

            # What is nobody's, and what a gateway has no business to say, is counted and changes nothing.
            for noise, attachment in ((b"\x00\xff", b""), (b"{}", b"\x93\x01\x01\xc4\x00"), (b"", b"\xc1")):
                for key in (KEYS.addressed(VEHICLE), KEYS.transports(PLANT.cell_of(2.0, 10.0))):
                    bus.inner.put(key, noise, attachment=attachment)
            gateway.send(
                VEHICLE, Release(task="M1-1", epoch=1, role=Role.PRIMARY, reason=Reason.RELEASED, number=1)
            )

            # Two containers of goods, which ask for one of material at least.
            now_s = time.time() * SPEED
            order = OrderReleased(order="O-1", items=(OrderItem("stool", 4),), due_s=now_s + 3600)
            taken = asyncio.create_task(gateway.until(lambda said: isinstance(said, OrderTaken)))
            while not taken.done():
                gateway.send(STRATEGIST, order)
                await asyncio.wait((taken,), timeout=1.0)
            await gateway.until(
                lambda said: isinstance(said, Event) and isinstance(said.fact, OrderFulfilled)
            )
            assert dict(bus.refused) == {}

            # It shuts down gracefully, and says so.
            vehicle.terminate()
            await gateway.until(lambda said: isinstance(said, AtvHeartbeat) and said.draining)
            assert await asyncio.to_thread(vehicle.wait) == 0

    asyncio.run(story())
    words = workshop.words(VEHICLE)
    assert "from M1 to DEL" in words
    # On a computer that is busy elsewhere others may not hear it for long, and its task is given to it again. How often it speaks is
    # tested without a computer's clock (`test_vehicle_ts_rhythm`).
    ends = ends_of(words)
    assert "handed over" in ends
    assert set(ends) <= {"handed over", *TAKEN_AWAY}
    refused = re.findall(r"refused (\d+): (.*)", words)
    assert {reason: int(times) for times, reason in refused} == {
        "a word that is not for us, or not of its kind": 1,
        "no seal": 1,
        "another wire version": 1,
        "no message of ours": 4,
    }
    assert json.loads((tmp_path / "notes" / f"{VEHICLE}.json").read_text())["contract"] is None
