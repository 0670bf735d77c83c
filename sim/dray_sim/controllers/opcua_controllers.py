"""The controllers of a simulated floor's machines, storages and gate, on the nodes of an OPC UA server."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from functools import partial
from typing import Any

import msgspec

from dray.adapters.opcua.mapping_file import OpcUaMapping
from dray.adapters.signals.signal import AT_A_DOCK, LEVEL, Signal, Tag, Value
from dray.messages.keys import GATE
from dray.ports import Clock
from dray_sim.bodies.gate import Gate
from dray_sim.bodies.stores import Storage
from dray_sim.bodies.workcell import SimWorkcell
from dray_sim.controllers.alive import STILL_S
from dray_sim.controllers.gate import GateController
from dray_sim.controllers.machine import MachineController
from dray_sim.controllers.opcua_server import GATE_NODES, NODES, ControllerServer, node_id
from dray_sim.controllers.store import StoreController

REST_WALL_S, REST_MIN_S = 0.5, 1.0
"""Rest of a machine after each piece, in real seconds, and at least of the floor's: OPC UA takes a fifth of one to
report the piece, and then the machine is told whether another one is wanted."""


class OpcUaControllers:
    """Made on the floor's loop, on which all controllers work.

    Args:
        clock: of that loop.
        server: that has the nodes.
        speed: the floor's seconds per real second.

    Attributes:
        controllers: those of machines, by machine.
    """

    def __init__(self, clock: Clock, server: ControllerServer, speed: float) -> None:
        self._clock, self._server = clock, server
        self._rest_s = max(REST_MIN_S, REST_WALL_S * speed)
        self._still_s = STILL_S * max(1.0, speed)
        self._loop = asyncio.get_running_loop()
        self._ended = False
        self.controllers: dict[str, MachineController] = {}

    def build_machine(self, workcell: SimWorkcell) -> OpcUaMapping:
        """Give a machine its controller, and write down where that is.

        Raises:
            OSError: the mapping file cannot be written.
        """
        machine = workcell.id
        controller = MachineController(
            workcell, self._clock, self._show(machine), rest_s=self._rest_s, still_s=self._still_s
        )
        self.controllers[machine] = controller
        self._connect(machine, controller)
        tags = {signal: Tag(node_id(machine, signal)) for signal in NODES}
        return self._write(machine, self._mapping(signals=tags, stock=workcell.sense().stock))

    def build_store(self, storage: Storage) -> OpcUaMapping:
        """Give a storage or source warehouse its controller, and write down where that is.

        Raises:
            OSError: the mapping file cannot be written.
        """
        store = storage.id
        self._connect(store, StoreController(storage, self._clock, self._show(store)))
        tags = {signal: Tag(node_id(store, signal)) for signal in AT_A_DOCK}
        levels = {item: Tag(node_id(store, LEVEL + item)) for item in storage.stock}
        stock = dict(storage.stock)
        return self._write(store, self._mapping(signals=tags, levels=levels, stock=stock))

    def build_gate(self, gate: Gate) -> OpcUaMapping:
        """Give the gate its controller, and write down where that is.

        Raises:
            OSError: the mapping file cannot be written.
        """
        self._connect(GATE, GateController(gate, self._clock, self._show(GATE), still_s=self._still_s))
        tags = {signal: Tag(node_id(GATE, signal)) for signal in GATE_NODES}
        return self._write(GATE, self._mapping(signals=tags))

    def end(self) -> None:
        """Hear nothing any more; the loop may be closed then."""
        self._ended = True

    def _show(self, name: str) -> Callable[[str, Value], None]:
        return partial(self._server.show, name)

    def _connect(self, name: str, controller: MachineController | StoreController | GateController) -> None:
        def on_write(signal: Signal, value: Value) -> None:
            """Runs on the server's thread."""
            if not self._ended:
                self._loop.call_soon_threadsafe(controller.on_write, signal, value)

        for signal, value in controller.shows.items():
            self._server.show(name, signal, value)
        self._server.connect(name, on_write)

    def _mapping(self, **parts: Any) -> OpcUaMapping:
        return OpcUaMapping(url=self._server.url, life=self._server.life, **parts)

    def _write(self, name: str, mapping: OpcUaMapping) -> OpcUaMapping:
        (self._server.folder / f"{name}.yaml").write_bytes(msgspec.yaml.encode(mapping))
        return mapping
