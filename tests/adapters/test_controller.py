"""A dock's controller behind a broker, as the body of a station and of the gate: what is said is heard once, whatever is lost."""

from __future__ import annotations

import asyncio
import os
import subprocess
import sys
from collections.abc import Callable, Coroutine
from functools import partial
from pathlib import Path
from random import Random
from typing import Any

import msgspec
import pytest
from controller_kit import Controller

from dray.adapters.controller.body import ControllerBody
from dray.adapters.controller.letters import TOLD, prefix
from dray.adapters.remote_body import exchanged
from dray.adapters.vda5050.link import MqttLink
from dray.body import (
    Admit,
    CloseDock,
    DockReady,
    GoodsArrived,
    Instruction,
    OpenDock,
    Report,
    StockChanged,
    StorageState,
)
from dray.body.gate import GateState
from dray.plant import default_plant, load_plant
from dray.ports import Body
from dray_sim.bodies.gate import Gate
from dray_sim.bodies.stores import SourceWarehouse, Storage
from dray_sim.clock.loop import JUMP, clock, run
from dray_sim.vda5050.local_broker import local_broker

PLANT = load_plant("single-track")

STATE = b'{"type": "StorageState", "about": {"stock": {}, "seq": 0, "opened": []}}'

CHANGED_BY_MANY = b'{"type": "StockChanged", "about": {"item": "shaft", "change": "many", "seq": 1}}'


class Wire:
    """A way between both sides that loses, doubles and delays letters."""

    def __init__(self, loss_frac: float, seed: int = 1) -> None:
        self._loss_frac, self._random = loss_frac, Random(seed)
        self.agent: ControllerBody | None = None
        self.controller: Controller | None = None

    def to_controller(self, topic: str, data: bytes) -> None:
        self._carry(lambda: self.controller and self.controller.on_message(topic, data))

    def to_agent(self, topic: str, data: bytes) -> None:
        self._carry(lambda: self.agent and self.agent.on_message(topic, data))

    def _carry(self, deliver: Callable[[], object]) -> None:
        for _ in range(1 if self._random.random() > 0.1 else 2):
            if self._random.random() >= self._loss_frac:
                asyncio.get_running_loop().call_later(self._random.uniform(0.01, 0.5), deliver)


class Dock:
    """A storage behind its controller, and what its agent has heard."""

    def __init__(self, loss_frac: float = 0.0) -> None:
        self.storage = Storage(
            PLANT.storages["S1"], clock(), SourceWarehouse("SOURCE", PLANT.materials), parts=PLANT.parts
        )
        self.wire = Wire(loss_frac)
        self.controller = self.wire.controller = Controller(self.storage, self.wire.to_agent)
        self.heard: list[Report] = []
        self.life = 0

    async def live(self, state: type[StorageState] = StorageState) -> ControllerBody:
        """The agent's next life."""
        self.life += 1
        body = self.wire.agent = ControllerBody(self.life, state, self.wire.to_controller)
        body.on_link()
        await self.until(body.known())
        body.attach(self.heard.append)
        return body

    async def until(self, there: Coroutine[Any, Any, None]) -> None:
        """Let the controller tell once a second until this has come."""
        waited = asyncio.ensure_future(there)
        while not waited.done():
            self.controller.tell()
            await asyncio.sleep(1.0)

    async def pass_s(self, span_s: float) -> None:
        await self.until(asyncio.sleep(span_s))


def played(test: Callable[[], Coroutine[Any, Any, None]]) -> None:
    run(test(), JUMP)


@pytest.mark.parametrize("loss_frac", [0.0, 0.3, 0.7])
def test_what_is_instructed_is_done_and_what_is_counted_is_heard_once_and_in_order(loss_frac: float) -> None:
    async def test() -> None:
        dock = Dock(loss_frac)
        body = await dock.live()
        for number in range(5):
            vehicle = f"ATV{number}"
            body.instruct(OpenDock(vehicle, "shaft", 40))
            await dock.pass_s(60.0)
            assert dock.storage.take(vehicle, "shaft", 40) == ""
            assert dock.storage.take(vehicle, "shaft", 40) == "the dock is shut"
            await dock.pass_s(60.0)
        taken = [each for each in dock.heard if isinstance(each, StockChanged) and each.vehicle]
        assert [(each.vehicle, each.change) for each in taken] == [(f"ATV{n}", -40) for n in range(5)]
        assert body.sense() == dock.storage.sense()

    played(test)


class SlowDock:
    """A storage whose dock takes three seconds to be safe, and says so."""

    def __init__(self, storage: Storage) -> None:
        self._storage, self._report = storage, list[Callable[[Report], None]]()

    def attach(self, report: Callable[[Report], None]) -> None:
        self._report = [report]
        self._storage.attach(report)

    def sense(self) -> StorageState:
        return msgspec.structs.replace(self._storage.sense(), answers=True)

    def instruct(self, instruction: Instruction) -> None:
        self._storage.instruct(instruction)
        if isinstance(instruction, OpenDock):
            ready = DockReady(instruction.vehicle)
            asyncio.get_running_loop().call_later(3.0, lambda: [tell(ready) for tell in self._report])


@pytest.mark.parametrize("loss_frac", [0.0, 0.5])
def test_a_dock_that_takes_time_to_open_says_once_that_it_is_ready(loss_frac: float) -> None:
    async def test() -> None:
        dock = Dock(loss_frac)
        dock.controller = dock.wire.controller = Controller(SlowDock(dock.storage), dock.wire.to_agent)
        body = await dock.live()
        state = body.sense()
        assert isinstance(state, StorageState)
        assert state.answers
        body.instruct(OpenDock("ATV1", "shaft", 40))
        await dock.pass_s(2.0)
        assert dock.heard == []
        await dock.pass_s(60.0)
        assert dock.heard == [DockReady("ATV1")]

    played(test)


def test_a_killed_agent_leaves_the_dock_as_it_is_and_its_next_life_alone_is_obeyed() -> None:
    async def test() -> None:
        dock = Dock()
        before = await dock.live()
        before.instruct(OpenDock("ATV1", "shaft", 40))
        await dock.pass_s(2.0)
        after = await dock.live()
        state = after.sense()
        assert isinstance(state, StorageState)
        assert state.opened == ("ATV1",)
        before.instruct(CloseDock("ATV1"))
        await dock.pass_s(2.0)
        assert dock.storage.take("ATV1", "shaft", 40) == ""

    played(test)


def test_what_is_counted_while_no_agent_lives_is_in_the_count_of_the_next_life() -> None:
    async def test() -> None:
        dock = Dock()
        body = await dock.live()
        body.instruct(OpenDock("ATV1", "shaft", 40))
        await dock.pass_s(2.0)
        dock.wire.agent = None
        before = dock.storage.stock["shaft"]
        dock.storage.take("ATV1", "shaft", 40)
        body = await dock.live()
        state = body.sense()
        assert isinstance(state, StorageState)
        assert (state.stock["shaft"], state.opened) == (before - 40, ())

    played(test)


def test_a_controller_that_is_silent_or_has_begun_anew_is_lost() -> None:
    async def test() -> None:
        dock = Dock()
        body = await dock.live()
        lost = asyncio.ensure_future(body.lost())
        await dock.pass_s(3.0 * exchanged.SILENT_LOOKS)
        assert not lost.done()
        dock.controller = dock.wire.controller = Controller(dock.storage, dock.wire.to_agent)
        await dock.pass_s(3.0)
        assert lost.done()
        silent = await dock.live()
        dock.wire.controller = None
        await asyncio.wait_for(silent.lost(), 3.0 * exchanged.SILENT_LOOKS)

    played(test)


@pytest.mark.parametrize(
    "data",
    [
        b"no letter",
        b'{"life": 1, "heard": 0, "first": 1, "state": {"type": "VehicleState", "about": {}}}',
        b'{"life": 1, "heard": 0, "first": 1, "state": {"type": "GateState", "about": {"arrived": {}}}}',
        b'{"life": 1, "heard": 0, "first": 1, "state": %b, "parts": [%b]}' % (STATE, CHANGED_BY_MANY),
    ],
)
def test_what_is_no_letter_changes_nothing(data: bytes) -> None:
    async def test() -> None:
        dock = Dock()
        body = await dock.live()
        before = body.sense()
        body.on_message(TOLD, data)
        assert (body.refused, body.sense(), dock.heard) == (1, before, [])

    played(test)


@pytest.mark.parametrize("loss_frac", [0.0, 0.5])
def test_a_gate_lets_in_what_was_admitted_and_tells_it_to_its_agent(loss_frac: float) -> None:
    async def test() -> None:
        gate, wire, heard = Gate(clock()), Wire(loss_frac), list[Report]()
        controller = wire.controller = Controller(gate, wire.to_agent)
        body = wire.agent = ControllerBody(1, GateState, wire.to_controller)
        body.attach(heard.append)
        body.on_link()

        async def tell(span_s: float) -> None:
            for _ in range(int(span_s)):
                controller.tell()
                await asyncio.sleep(1.0)

        await tell(30.0)
        body.instruct(Admit("G1", 5))
        await tell(30.0)
        assert gate.enter("G1", 3, "ATV1") == ""
        assert gate.enter("G1", 3, "ATV2") == "not admitted"
        await tell(30.0)
        assert heard == [GoodsArrived("G1", 0, 5), GoodsArrived("G1", 3, 5, "ATV1")]
        assert body.sense() == GateState({"G1": 3})

    played(test)


def test_over_a_broker() -> None:
    """The same with the real link, on both sides."""

    async def test() -> None:
        with local_broker() as broker:
            topics = partial(prefix, PLANT.id)
            there = MqttLink(broker, topics("S1"), "controller-S1", ("do",))
            here = MqttLink(broker, topics("S1"), "dray-S1", (TOLD,))
            gate = Gate(_Wall())
            controller = Controller(gate, there.publish)
            body = ControllerBody(1, GateState, here.publish)
            admitted, arrived = asyncio.Event(), asyncio.Event()
            heard: list[Report] = []

            def on_report(report: Report) -> None:
                heard.append(report)
                if isinstance(report, GoodsArrived):
                    (arrived if report.arrived else admitted).set()

            body.attach(on_report)
            tasks = [asyncio.create_task(there.run(controller)), asyncio.create_task(here.run(body))]
            telling = asyncio.create_task(_tell(controller))
            await body.known()
            body.instruct(Admit("G1", 5))
            await admitted.wait()
            assert gate.enter("G1", 5, "ATV1") == ""
            await arrived.wait()
            assert heard == [GoodsArrived("G1", 0, 5), GoodsArrived("G1", 5, 5, "ATV1")]
            for task in (*tasks, telling):
                task.cancel()
            await asyncio.gather(*tasks, telling, return_exceptions=True)

    asyncio.run(asyncio.wait_for(test(), 120.0))


async def _tell(controller: Controller) -> None:
    while True:
        controller.tell()
        await asyncio.sleep(0.2)


@pytest.mark.parametrize(
    ("command", "agent"), [(("agent", "station", "S1"), "S1"), (("agent", "gate"), "gate")]
)
def test_a_process_takes_part_when_its_controller_speaks_and_ends_when_that_begins_anew(
    command: tuple[str, ...], agent: str, tmp_path: Path
) -> None:
    async def test() -> None:
        with local_broker() as broker:
            link = MqttLink(broker, prefix(default_plant().id, agent), f"controller-{agent}", ("do",))
            controller = Controller(_body_of(agent), link.publish)
            tasks = [asyncio.create_task(link.run(controller)), asyncio.create_task(_tell(controller))]
            process = await asyncio.create_subprocess_exec(
                *(sys.executable, "-m", "dray", *command, "--body", "controller", "--broker", str(broker)),
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                env={**os.environ, "DRAY_BUS_PLAIN": "true"},
                cwd=tmp_path,
            )
            assert process.stdout is not None
            assert (await process.stdout.readline()).decode() == f"{agent} is ready\n"
            controller.life = 0
            # At once: a letter of the agent that is under way makes the controller serve it again.
            controller.tell()
            _, told = await process.communicate()
            assert process.returncode == 1
            assert f"the body of {agent}: has fallen silent" in told.decode()
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)

    asyncio.run(asyncio.wait_for(test(), 180.0))


def _body_of(agent: str) -> Body:
    if agent == "gate":
        return Gate(_Wall())
    plant = default_plant()
    source = SourceWarehouse("SOURCE", plant.materials)
    return Storage(plant.storages[agent], _Wall(), source, parts=plant.parts)


class _Wall:
    """A clock of this computer."""

    def now_s(self) -> float:
        return asyncio.get_running_loop().time()

    def call_at(self, when_s: float, callback: Callable[[], object]) -> None:
        asyncio.get_running_loop().call_at(when_s, callback)


def test_a_letter_is_plain_json() -> None:
    """As docs/stations.md has it."""
    said: list[bytes] = []
    body = ControllerBody(7, StorageState, lambda _topic, data: said.append(data))
    body.instruct(OpenDock("ATV3", "shaft", 40))
    assert msgspec.json.decode(said[-1]) == {
        "life": 7,
        "heard": 0,
        "first": 1,
        "parts": [{"type": "OpenDock", "about": {"vehicle": "ATV3", "item": "shaft", "quantity": 40}}],
    }
