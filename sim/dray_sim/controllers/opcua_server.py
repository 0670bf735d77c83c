"""An OPC UA server that has the controllers of simulated machines.

It runs in a thread of its own, and so do the links of agents to it: a network uses the wall clock, at any speed of
the plant's clock. Each machine is an object, and each of its signals a node, as `ns=2;s=M8.pieces`.
"""

from __future__ import annotations

import asyncio
import logging
import threading
from collections.abc import Callable, Coroutine, Iterable
from concurrent.futures import Future
from pathlib import Path
from typing import Any, Self

from asyncua import ua
from asyncua.common.node import Node
from asyncua.server.server import Server

from dray.adapters.signals.signal import Signal, Value, is_told
from dray.errors import UnavailableError
from dray_sim.controllers.opcua_nodes import Types, add_controller, shown

NAMESPACE = "urn:dray:simulated-machines"
SPACE = 2
"""The index of our namespace: 0 is the standard's, 1 the server's own."""

START_S, STOP_S = 60.0, 20.0
"""Longest waits for the server: it reads the standard's 1,500 nodes first."""

AWAY_S = 2.0
"""Real seconds without any service after all connections were cut."""

NODES: Types = {
    Signal.PIECES: (0, ua.VariantType.UInt16),
    Signal.BAD: (0, ua.VariantType.UInt16),
    Signal.FAULT: (False, ua.VariantType.Boolean),
    Signal.FAULT_TEXT: ("", ua.VariantType.String),
    Signal.DOCK_READY: (False, ua.VariantType.Boolean),
    Signal.RUN: (False, ua.VariantType.Boolean),
    Signal.PRODUCT: ("", ua.VariantType.String),
    Signal.SPEED: (1.0, ua.VariantType.Double),
    Signal.RESET: (False, ua.VariantType.Boolean),
    Signal.DOCK_PERMIT: (False, ua.VariantType.Boolean),
    Signal.DOCK_VEHICLE: ("", ua.VariantType.String),
    Signal.ALIVE: (0, ua.VariantType.UInt16),
}
"""The first value and the type of each signal."""

OnWrite = Callable[[Signal, Value], None]

# It warns of a server without certificates.
logging.getLogger("asyncua").setLevel(logging.ERROR)

_log = logging.getLogger(__name__)


def node_id(machine: str, signal: Signal) -> str:
    """The address of a signal, as a mapping file has it."""
    return f"ns={SPACE};s={machine}.{signal.value}"


class ControllerServer:
    """A server on a free port of 127.0.0.1, as long as its context lasts.

    Any process on this computer may read and write.

    Args:
        machines: their ids.
        folder: where the mapping file of each is written, as `M8.yaml`.

    Attributes:
        url: where it is.
        loop: of its thread; for links to it, too.
    """

    def __init__(self, machines: Iterable[str], folder: Path) -> None:
        self.url = ""
        self.folder = folder
        self.loop = asyncio.new_event_loop()
        self._machines = tuple(machines)
        self._thread = threading.Thread(target=self._run, name="opc-ua", daemon=True)
        self._server: Server | None = None
        self._nodes: dict[tuple[str, Signal], Node] = {}
        self._writes: dict[str, OnWrite] = {}
        self._unshown: dict[tuple[str, Signal], Value] = {}
        """Values that are not shown yet: the latest one of each node."""
        self._changed = asyncio.Event()
        self._works: set[asyncio.Task[None]] = set()

    def __enter__(self) -> Self:
        self._thread.start()
        try:
            asyncio.run_coroutine_threadsafe(self._open(), self.loop).result(START_S)
        except BaseException as error:
            self.__exit__()
            if isinstance(error, OSError | TimeoutError):
                reason = str(error) or "it does not start"
                raise UnavailableError("an OPC UA server", reason, "try again") from None
            raise
        return self

    def __exit__(self, *_: object) -> None:
        try:
            asyncio.run_coroutine_threadsafe(self._close(), self.loop).result(STOP_S)
        finally:
            self.loop.call_soon_threadsafe(self.loop.stop)
            self._thread.join(STOP_S)

    # --- from any thread ---

    def connect(self, machine: str, on_write: OnWrite) -> None:
        """Call `on_write`, in the server's thread, for every later write to a machine."""
        self._writes[machine] = on_write

    def show(self, machine: str, signal: Signal, value: Value) -> None:
        """Let a machine show a value."""
        self.loop.call_soon_threadsafe(self._show, machine, signal, value)

    def begin(self, work: Coroutine[Any, Any, None]) -> Future[None]:
        """Let something run beside the server; it is cancelled with it at the latest."""
        return asyncio.run_coroutine_threadsafe(self._keep(work), self.loop)

    def cut(self) -> None:
        """End all connections, and be away for `AWAY_S`; changes of that time are shown afterwards."""
        self.begin(self._cut())

    # --- in its thread ---

    def datachange_notification(self, node: Node, value: Any, _data: Any) -> None:
        """Something was written."""
        machine, _, name = str(node.nodeid.Identifier).rpartition(".")
        if machine in self._writes and isinstance(value, bool | int | float | str):
            self._writes[machine](Signal(name), value)

    def _run(self) -> None:
        asyncio.set_event_loop(self.loop)
        try:
            self.loop.run_forever()
        finally:
            self.loop.close()

    async def _open(self) -> None:
        server = self._server = Server()
        await server.init()
        server.set_endpoint("opc.tcp://127.0.0.1:0/dray")
        server.set_security_policy([ua.SecurityPolicyType.NoSecurity])
        space = await server.register_namespace(NAMESPACE)
        assert space == SPACE, space  # noqa: S101 - of a server that was made here
        written = []
        for machine in self._machines:
            for signal, node in (await add_controller(server, space, machine, NODES)).items():
                self._nodes[machine, signal] = node
                if not is_told(signal):
                    await node.set_writable()
                    written.append(node)
        await server.start()
        assert server.bserver is not None  # noqa: S101 - it has started
        self.url = f"opc.tcp://127.0.0.1:{server.bserver.port}/dray"
        if written:
            subscription = await server.create_subscription(0, self)
            await subscription.subscribe_data_change(written)
        self.begin(self._show_all())

    async def _cut(self) -> None:
        assert self._server is not None  # noqa: S101 - it has been opened
        listener = self._server.bserver
        assert listener is not None  # noqa: S101 - likewise
        await listener.stop()
        await asyncio.sleep(AWAY_S)
        await listener.start()

    async def _close(self) -> None:
        works = [*self._works]
        for work in works:
            work.cancel()
        await asyncio.gather(*works, return_exceptions=True)
        if self._server is not None and self._server.bserver is not None:
            await self._server.stop()

    async def _keep(self, work: Coroutine[Any, Any, None]) -> None:
        task = asyncio.current_task()
        assert task is not None  # noqa: S101 - it runs as one
        self._works.add(task)
        try:
            await work
        except Exception:
            _log.exception("a link of the OPC UA server has ended")
            raise
        finally:
            self._works.discard(task)

    def _show(self, machine: str, signal: Signal, value: Value) -> None:
        self._unshown[machine, signal] = value
        self._changed.set()

    async def _show_all(self) -> None:
        while True:
            await self._changed.wait()
            self._changed.clear()
            while self._unshown:
                name = next(iter(self._unshown))
                value = self._unshown.pop(name)
                await self._nodes[name].write_value(shown(name[1], value, NODES))
