"""The machines of a simulated factory behind a real OPC UA server: agents and controllers speak by TCP only."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Any

from dray.adapters.documents import DocumentReader
from dray.adapters.opcua.link import OpcUaLink
from dray.adapters.opcua.mapping_file import OpcUaMapping
from dray.adapters.signals.signal import Sample, Value
from dray.adapters.signals.workcell import Kept, SignalledWorkcell
from dray.body.documents import Documents
from dray.plant import Plant
from dray.ports import Body, Clock
from dray_sim.bodies.workcell import SimWorkcell
from dray_sim.controllers.opcua_controllers import OpcUaControllers
from dray_sim.controllers.opcua_server import ControllerServer


class OpcUaMachines:
    """All machines of a plant with their controllers, and the bodies of their agents. Made on the factory's loop.

    Args:
        plant: its machines.
        clock: of that loop.
        server: that has their nodes.
        speed: the factory's seconds per real second.
        documents: the machines' document store; None for the workcell's own.

    Attributes:
        controllers: by machine.
        bodies: of the present lives, by machine.
    """

    def __init__(
        self,
        plant: Plant,
        clock: Clock,
        server: ControllerServer,
        speed: float,
        documents: Documents | None = None,
    ) -> None:
        self._plant, self._clock, self._server = plant, clock, server
        self._documents = documents
        self._controllers = OpcUaControllers(clock, server, speed)
        self.controllers = self._controllers.controllers
        self._loop = asyncio.get_running_loop()
        self.bodies: dict[str, SignalledWorkcell] = {}
        self._mappings: dict[str, OpcUaMapping] = {}
        self._kept: dict[str, Kept] = {}
        self._lives: dict[str, _Life] = {}

    def embody(self, workcell: SimWorkcell, _life: int) -> Body:
        """The body of the next life of a machine's agent.

        It knows what the last life has kept, and nothing of the workcell.

        Raises:
            OSError: the mapping file cannot be written.
        """
        machine = workcell.id
        if machine in self._lives:
            self._lives[machine].end()
        else:
            self._mappings[machine] = self._controllers.build(workcell)
        mapping = self._mappings[machine]
        life = _Life(mapping, self._loop, self._server, lambda kept: self._keep(machine, kept))
        spec, kept = self._plant.machines[machine], self._kept.get(machine)
        body = SignalledWorkcell(spec, self._plant, mapping, self._clock, life, kept)
        life.begin(body)
        self._lives[machine], self.bodies[machine] = life, body
        return DocumentReader(body, self._documents or workcell.documents)

    async def ready(self) -> None:
        """Wait until all are linked.

        Raises:
            Exception: that of an ended link, a fault of ours.
        """
        for life in [*self._lives.values()]:
            await life.linked()

    def end(self) -> None:
        """Hear nothing any more, and say nothing."""
        self._controllers.end()
        for life in self._lives.values():
            life.end()

    def _keep(self, machine: str, kept: Kept) -> None:
        self._kept[machine] = kept


class _Life:
    """Links of one life of a machine's body: its world on the factory's loop, and its link's listener on the server's.

    Args:
        mapping: the addresses of its controller.
        loop: the factory's.
        server: on whose loop the link runs.
        remember: keeps data for the next life.

    Attributes:
        outputs: values for the controller; replaced as a whole, because the link reads them on another thread.
    """

    def __init__(
        self,
        mapping: OpcUaMapping,
        loop: asyncio.AbstractEventLoop,
        server: ControllerServer,
        remember: Callable[[Kept], None],
    ) -> None:
        self._link = OpcUaLink(mapping, server.folder)
        self._loop, self._server, self._remember = loop, server, remember
        self._body: SignalledWorkcell | None = None
        self._ended = False
        self.outputs: dict[str, Value] = {}

    # --- on the factory's loop ---

    def begin(self, body: SignalledWorkcell) -> None:
        """Link a body that has just been made."""
        self._body, self.outputs = body, dict(body.outputs)
        self._running = self._server.begin(self._link.run(self))

    async def linked(self) -> None:
        """Wait until it is."""
        there = self._server.begin(self._wait())
        waits = [asyncio.wrap_future(there), asyncio.wrap_future(self._running)]
        await asyncio.wait(waits, return_when=asyncio.FIRST_COMPLETED)
        there.cancel()
        if self._running.done():
            self._running.result()

    def end(self) -> None:
        """Drop all further messages, also those under way between the threads."""
        self._ended = True
        self._running.cancel()

    def remember(self, kept: Kept) -> None:
        """See `dray.adapters.signals.workcell.World`."""
        if not self._ended:
            self._remember(kept)

    def write(self) -> None:
        """See `dray.adapters.signals.workcell.World`."""
        if self._body is not None and not self._ended:
            self.outputs = dict(self._body.outputs)
            self._server.loop.call_soon_threadsafe(self._link.write)

    def _arrive(self, name: str, args: tuple[Any, ...]) -> None:
        if not self._ended:
            getattr(self._body, name)(*args)

    # --- on the server's loop ---

    async def _wait(self) -> None:
        await self._link.linked.wait()

    def _cross(self, name: str, *args: Any) -> None:
        if not self._ended:
            self._loop.call_soon_threadsafe(self._arrive, name, args)

    def on_link(self) -> None:
        self._cross("on_link")

    def on_link_lost(self, reason: str) -> None:
        self._cross("on_link_lost", reason)

    def on_range(self, signal: str, moduli: tuple[int, ...]) -> None:
        self._cross("on_range", signal, moduli)

    def on_sample(self, name: str, sample: Sample) -> None:
        self._cross("on_sample", name, sample)

    def on_refused(self, name: str, reason: str) -> None:
        self._cross("on_refused", name, reason)
