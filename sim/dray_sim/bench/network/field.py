"""The paper's laboratory on computers of its own: machine 8, three vehicles, strategist and floor, in real time.

Each is a process with certificates. All connect to the wired processes over the WLAN. Vehicles connect to one another
by radio alone: two computers share one link, and it must not be the one that breaks. A probe hears everything.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TypeVar

from msgspec.structs import replace

from dray.adapters.security.certificates import Authority
from dray.messages import AtvHeartbeat, MachineHeartbeat, OrderItem, TaskBrief
from dray.messages.fact import CarrierChanged, PrimarySuspected, TookOver
from dray.messages.keys import GATE, STRATEGIST
from dray.messages.kinds import Kind
from dray.plant import Plant, plant_yaml
from dray.plant.model import BillLine
from dray_sim.bench.network.computers import RADIO_NETWORK, Computers
from dray_sim.bench.network.probe import AGENTS, PROBE, ProbeSpec, read, write
from dray_sim.bench.network.speaker import Speaker
from dray_sim.run.witness import Seen, Witness
from dray_sim.scenarios.paper.laboratory import MACHINE, PRODUCT, laboratory

T = TypeVar("T")

FLOOR = "floor"

PIECES, MATERIAL, PER_PIECE = 2, "housing", 12
"""An order of two pieces, for which machine 8 asks for one load of one material at once. Its buffer begins with less
than a piece takes."""

STATIONS = laboratory().storages_of(MATERIAL)
"""The storages that keep it; the others have nothing to do."""

WIRED = {
    FLOOR: Kind.HISTORIAN,
    GATE: Kind.GATE,
    STRATEGIST: Kind.STRATEGIST,
    MACHINE: Kind.MACHINE,
    **dict.fromkeys(STATIONS, Kind.STATION),
}
"""Processes that stay at one place; all others connect to them."""

VEHICLES = tuple(vehicle.id for vehicle in laboratory().file.fleet)

COMMANDS = {
    FLOOR: ("floor",),
    GATE: ("agent", "gate"),
    STRATEGIST: ("strategist",),
    MACHINE: ("agent", "machine", MACHINE),
    **{station: ("agent", "station", station) for station in STATIONS},
    **{vehicle: ("agent", "atv", vehicle) for vehicle in VEHICLES},
}

PORT = 7447

LEASE_S = 2.0
"""The default lease."""

KEPT = (AtvHeartbeat, MachineHeartbeat, CarrierChanged, PrimarySuspected, TookOver)

PATIENCE_S = 90.0
"""Longest wait for anything, on a busy computer."""


class Field:
    """The laboratory while it runs.

    Args:
        computers: for all processes and the probe.
        folder: empty; for certificates, journals and logs.

    Attributes:
        witness: messages that the probe has heard, by the unix time of their arrival.
    """

    def __init__(self, computers: Computers, folder: Path) -> None:
        self.computers = computers
        self.witness = Witness(*KEPT)
        self._folder = folder
        self._certificates = folder / "certs"
        self._plant = _plant()
        self._processes: dict[str, Speaker] = {}

    @classmethod
    @contextmanager
    def opened(cls, folder: Path) -> Iterator[Field]:
        """The laboratory with an order for machine 8, as long as the context lasts.

        Raises:
            UnavailableError: this computer cannot be several, or a process has not started.
        """
        with Computers.opened((*COMMANDS, PROBE), VEHICLES) as computers:
            field = cls(computers, folder)
            try:
                field._start()
                yield field
            finally:
                field._end()

    def seen(
        self, kind: type[T], where: Callable[[Seen[T]], bool] = lambda _: True, *, since_s: float = 0.0
    ) -> Seen[T]:
        """The first of this kind that has come since then, or is still to come.

        Raises:
            UnavailableError: it does not come.
        """
        ends_s = time.monotonic() + PATIENCE_S
        while time.monotonic() < ends_s:
            for seen in self.witness.all(kind, since_s=since_s):
                if where(seen):
                    return seen
            at_s, sender, message = read(self._processes[PROBE].line())
            self.witness.on_message(at_s, sender, "", message)
        raise self._processes[PROBE].complaint(f"has waited for {kind.__name__} in vain")

    def contract(self) -> TaskBrief:
        """The first task with two carriers, when the primary drives."""
        task, *_ = _contracted(self.seen(MachineHeartbeat, lambda seen: bool(_contracted(seen.said))).said)
        self.seen(AtvHeartbeat, lambda seen: seen.agent == task.primary and seen.said.speed_mps > 0)
        return task

    def switch_off(self, vehicle: str) -> None:
        """Cut its power: no link closes, so no peer is told."""
        self.computers.switch_wlan(vehicle, "down")
        self.computers.switch_radio(vehicle, "down")
        self._processes[vehicle].kill()

    # --- processes -------------------------------------------------------------------------------

    def _start(self) -> None:
        (self._folder / "plant.yaml").write_text(plant_yaml(self._plant), encoding="utf-8")
        self._certify()
        for name, command in COMMANDS.items():
            self._run(name, "dray", *command)
        for name in COMMANDS:
            # Its first line reports that it is ready.
            self._processes[name].line()
        spec = ProbeSpec(
            plant=self._plant.id,
            certificates=str(self._certificates),
            peers=self._called(*WIRED),
            lease_s=LEASE_S,
            order=OrderItem(PRODUCT, PIECES),
        )
        self._run(PROBE, "dray_sim.bench.network.probe", write(spec))

    def _end(self) -> None:
        for process in self._processes.values():
            process.kill()
        for process in self._processes.values():
            process.close()

    def _certify(self) -> None:
        authority, plant = Authority.make(self._plant.id), self._plant.id
        authority.write(self._certificates)
        for name, kind in {**WIRED, **dict.fromkeys(VEHICLES, Kind.ATV)}.items():
            authority.issue(self._certificates, plant, {name: kind})
        authority.issue(self._certificates, plant, dict.fromkeys(AGENTS, Kind.GATEWAY))

    def _run(self, name: str, module: str, *arguments: str) -> None:
        command = self.computers.command(name, sys.executable, "-m", module, *arguments)
        self._processes[name] = Speaker(name, command, self._environment(name), self._folder / f"{name}.log")

    def _environment(self, name: str) -> dict[str, str]:
        inherited = {key: value for key, value in os.environ.items() if not key.startswith("DRAY_")}
        return {
            **inherited,
            "DRAY_PLANT_FILE": str(self._folder / "plant.yaml"),
            "DRAY_JOURNAL_FOLDER": str(self._folder / "journals"),
            "DRAY_BUS_CERTIFICATES": str(self._certificates),
            "DRAY_BUS_LISTEN": f"0.0.0.0:{PORT}",
            "DRAY_BUS_PEERS": ",".join(self._peers(name)),
            "DRAY_BUS_LEASE_S": str(LEASE_S),
            "DRAY_BUS_RADIO": RADIO_NETWORK if name in VEHICLES else "",
            # The machines that would keep the reservation tables are absent.
            "DRAY_TRAFFIC": "false",
        }

    def _peers(self, name: str) -> tuple[str, ...]:
        """Addresses that a process connects to: the wired ones before it, and the neighbours before it by radio."""
        before = tuple(COMMANDS)[: tuple(COMMANDS).index(name)] if name in COMMANDS else tuple(WIRED)
        wired = self._called(*(each for each in before if each in WIRED))
        neighbours = [each for each in before if each in VEHICLES]
        return (*wired, *(f"{self.computers.radio_address(each, name)}:{PORT}" for each in neighbours))

    def _called(self, *names: str) -> tuple[str, ...]:
        return tuple(f"{self.computers.wlan_address(name)}:{PORT}" for name in names)


def _plant() -> Plant:
    """The laboratory, with a product for which machine 8 asks for one material, and soon."""
    file = laboratory().file
    bill = (BillLine(MATERIAL, PER_PIECE),)
    products = (replace(product, bill=bill) for product in file.products if product.id == PRODUCT)
    machines = (
        replace(machine, makes=tuple(making for making in machine.makes if making.product == PRODUCT))
        for machine in file.machines
    )
    return Plant(replace(file, products=tuple(products), machines=tuple(machines)))


def _contracted(heartbeat: MachineHeartbeat) -> list[TaskBrief]:
    return [task for task in heartbeat.tasks if task.primary and task.secondary]
