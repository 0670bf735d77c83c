"""The controllers of a simulated floor's machines, on the nodes of an OPC UA server."""

from __future__ import annotations

import asyncio

import msgspec

from dray.adapters.opcua.mapping_file import OpcUaMapping
from dray.adapters.signals.signal import Signal, Tag, Value
from dray.ports import Clock
from dray_sim.bodies.workcell import SimWorkcell
from dray_sim.controllers.machine import MachineController
from dray_sim.controllers.opcua_server import NODES, ControllerServer, node_id

REST_WALL_S, REST_MIN_S = 0.5, 1.0
"""Rest of a machine after each piece, in real seconds, and at least of the floor's: OPC UA takes a fifth of one to
report the piece, and then the machine is told whether another one is wanted."""


class OpcUaControllers:
    """Made on the floor's loop, on which all controllers work.

    Args:
        clock: of that loop.
        server: that has the machines' nodes.
        speed: the floor's seconds per real second.

    Attributes:
        controllers: by machine.
    """

    def __init__(self, clock: Clock, server: ControllerServer, speed: float) -> None:
        self._clock, self._server = clock, server
        self._rest_s = max(REST_MIN_S, REST_WALL_S * speed)
        self._loop = asyncio.get_running_loop()
        self._ended = False
        self.controllers: dict[str, MachineController] = {}

    def build(self, workcell: SimWorkcell) -> OpcUaMapping:
        """Give a machine its controller, and write down where that is.

        Raises:
            OSError: the mapping file cannot be written.
        """
        machine, server = workcell.id, self._server

        def show(signal: Signal, value: Value) -> None:
            server.show(machine, signal, value)

        def on_write(signal: Signal, value: Value) -> None:
            """Runs on the server's thread."""
            if not self._ended:
                self._loop.call_soon_threadsafe(controller.on_write, signal, value)

        controller = MachineController(workcell, self._clock, show, rest_s=self._rest_s)
        self.controllers[machine] = controller
        for signal, value in controller.shows.items():
            show(signal, value)
        server.connect(machine, on_write)
        tags = {signal: Tag(node_id(machine, signal)) for signal in NODES}
        mapping = OpcUaMapping(url=server.url, signals=tags, stock=workcell.sense().stock)
        (server.folder / f"{machine}.yaml").write_bytes(msgspec.yaml.encode(mapping))
        return mapping

    def end(self) -> None:
        """Hear nothing any more; the loop may be closed then."""
        self._ended = True
