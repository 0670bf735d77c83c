"""The machines, storages and gate of a simulated factory behind a real OPC UA server: agents and controllers speak by TCP only."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Any, Protocol

from dray.adapters.documents import DocumentReader
from dray.adapters.opcua.link import OpcUaLink
from dray.adapters.opcua.mapping_file import OpcUaMapping
from dray.adapters.signals.gate import SignalledGate, settle_s
from dray.adapters.signals.signal import LinkListener, Sample, Value
from dray.adapters.signals.store import SignalledStore, rests_s
from dray.adapters.signals.workcell import SignalledWorkcell
from dray.body.documents import Documents
from dray.messages.keys import GATE
from dray.plant import Plant
from dray.ports import Body, Clock
from dray_sim.bodies.gate import Gate
from dray_sim.bodies.stores import Storage
from dray_sim.bodies.workcell import SimWorkcell
from dray_sim.controllers.opcua_controllers import OpcUaControllers
from dray_sim.controllers.opcua_server import ControllerServer
from dray_sim.factory.installation import Bodies


class _Controlled(LinkListener, Body, Protocol):
    """A body with a controller."""


class OpcUaBodies(Bodies):
    """All machines, stores and the gate of a plant with their controllers, and the bodies of their agents. Made on the factory's loop.

    Args:
        plant: its machines and stores.
        clock: of that loop.
        server: that has their nodes.
        speed: the factory's seconds per real second.
        documents: the machines' document store; None for the workcell's own.

    Attributes:
        controllers: those of machines, by machine.
        machines: their bodies in the present lives, by machine.
        stores: the bodies of storages and source warehouses, likewise.
        gate: the body of the gate; None before its agent's first life.
    """

    has_levels = True

    def __init__(
        self,
        plant: Plant,
        clock: Clock,
        server: ControllerServer,
        speed: float,
        documents: Documents | None = None,
    ) -> None:
        self._plant, self._clock, self._server = plant, clock, server
        self._rests_s, self._settle_s = rests_s(speed), settle_s(speed)
        self._documents = documents
        self._controllers = OpcUaControllers(clock, server, speed)
        self.controllers = self._controllers.controllers
        self._loop = asyncio.get_running_loop()
        self.machines: dict[str, SignalledWorkcell] = {}
        self.stores: dict[str, SignalledStore] = {}
        self.gate: SignalledGate | None = None
        self._mappings: dict[str, OpcUaMapping] = {}
        self._kept: dict[str, Any] = {}
        self._lives: dict[str, _Life] = {}

    def embody_machine(self, workcell: SimWorkcell, _life: int) -> Body:
        """The body of the next life of a machine's agent.

        It knows what the last life has kept, and nothing of the workcell.

        Raises:
            OSError: the mapping file cannot be written.
        """
        machine = workcell.id
        life = self._next_life(machine, lambda: self._controllers.build_machine(workcell))
        spec, mapping = self._plant.machines[machine], self._mappings[machine]
        body = SignalledWorkcell(spec, self._plant, mapping, self._clock, life, self._kept.get(machine))
        self.machines[machine] = body
        life.begin(body)
        return DocumentReader(body, self._documents or workcell.documents)

    def embody_store(self, storage: Storage, _life: int) -> Body:
        """The body of the next life of a station, likewise.

        Raises:
            OSError: the mapping file cannot be written.
        """
        store = storage.id
        life = self._next_life(store, lambda: self._controllers.build_store(storage))
        spec, mapping, kept = self._plant.stores[store], self._mappings[store], self._kept.get(store)
        body = SignalledStore(spec, mapping, self._clock, life, kept, rests_s=self._rests_s)
        self.stores[store] = body
        life.begin(body)
        return body

    def embody_gate(self, gate: Gate, _life: int) -> Body:
        """The body of the next life of the gate's agent, likewise.

        Raises:
            OSError: the mapping file cannot be written.
        """
        life = self._next_life(GATE, lambda: self._controllers.build_gate(gate))
        mapping, kept = self._mappings[GATE], self._kept.get(GATE)
        body = self.gate = SignalledGate(mapping, self._clock, life, kept, settle_s=self._settle_s)
        life.begin(body)
        return body

    def _next_life(self, name: str, build: Callable[[], OpcUaMapping]) -> _Life:
        if name in self._lives:
            self._lives[name].end()
        else:
            self._mappings[name] = build()

        def keep(kept: Any) -> None:
            self._kept[name] = kept

        life = self._lives[name] = _Life(self._mappings[name], self._loop, self._server, keep)
        return life

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


class _Life:
    """Links of one life of a body: its world on the factory's loop, and its link's listener on the server's.

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
        remember: Callable[[Any], None],
    ) -> None:
        self._link = OpcUaLink(mapping, server.folder)
        self._loop, self._server, self._remember = loop, server, remember
        self._body: _Controlled | None = None
        self._ended = False
        self.outputs: dict[str, Value] = {}

    # --- on the factory's loop ---

    def begin(self, body: _Controlled) -> None:
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

    def remember(self, kept: Any) -> None:
        """See `dray.adapters.signals.workcell.World`, and that of `store`."""
        if not self._ended:
            self._remember(kept)

    def write(self) -> None:
        """See `dray.adapters.signals.workcell.World`, and that of `store`."""
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

    def on_written(self, name: str, value: Value) -> None:
        self._cross("on_written", name, value)
