"""An OPC UA server that has the controllers of simulated machines, storages and the gate.

It runs in a thread of its own, and so do the links of agents to it: a network uses the wall clock, at any speed of
the plant's clock. Each machine is an object, and each of its signals a node, as `ns=2;s=M8.pieces`.
"""

from __future__ import annotations

import asyncio
import logging
import secrets
import threading
from collections.abc import Callable, Coroutine, Iterable
from concurrent.futures import Future
from pathlib import Path
from typing import Any, Self

from asyncua import ua
from asyncua.common.node import Node
from asyncua.server.server import Server

from dray.adapters.signals.signal import AT_A_DOCK, LEVEL, Signal, Value, is_told
from dray.errors import UnavailableError
from dray.messages.keys import GATE
from dray.plant.model import Storage as StorageSpec
from dray_sim.controllers.opcua_nodes import Types, add_controller, short, shown

NAMESPACE = "urn:dray:simulated-machines"
SPACE = 2
"""The index of our namespace: 0 is the standard's, 1 the server's own."""

START_S, STOP_S = 60.0, 20.0
"""Longest waits for the server: it reads the standard's 1,500 nodes first."""

AWAY_S = 2.0
"""Real seconds without any service after all connections were cut."""

NODES: Types[Signal] = {
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
"""The first value and the type of each signal of a machine."""

GATE_NODES: Types[Signal] = {
    Signal.PIECES: NODES[Signal.PIECES],
    Signal.GOAL: ("", ua.VariantType.String),
    Signal.ADMITTED: (0, ua.VariantType.UInt32),
    Signal.ADMITTED_GOAL: ("", ua.VariantType.String),
    Signal.ALIVE: NODES[Signal.ALIVE],
}
"""The first value and the type of each signal of the gate."""

OnWrite = Callable[[Signal, Value], None]

# It warns of a server without certificates.
logging.getLogger("asyncua").setLevel(logging.ERROR)

_log = logging.getLogger(__name__)


def node_id(name: str, signal: str) -> str:
    """The address of a signal of a machine or storage, as a mapping file has it."""
    return f"ns={SPACE};s={name}.{short(signal)}"


def nodes_of(storage: StorageSpec) -> Types[str]:
    """The first value and the type of each signal of a storage."""
    return {
        **{signal: NODES[signal] for signal in AT_A_DOCK},
        **{LEVEL + line.material: (0, ua.VariantType.UInt32) for line in storage.stocks},
    }


class ControllerServer:
    """A server on a free port of 127.0.0.1, as long as its context lasts.

    Any process on this computer may read and write.

    Args:
        machines: their ids.
        folder: where the mapping file of each is written, as `M8.yaml`.
        stores: the storages and source warehouses with controllers.
        gate: whether the gate has one.

    Attributes:
        url: where it is.
        life: its name among all such servers: counters begin anew with each.
        loop: of its thread; for links to it, too.
    """

    def __init__(
        self, machines: Iterable[str], folder: Path, stores: Iterable[StorageSpec] = (), *, gate: bool = False
    ) -> None:
        self.url, self.life = "", secrets.token_hex(4)
        self.folder = folder
        self.loop = asyncio.new_event_loop()
        self._types: dict[str, Types[Any]] = dict.fromkeys(machines, NODES)
        self._types |= {store.id: nodes_of(store) for store in stores}
        if gate:
            self._types[GATE] = GATE_NODES
        self._thread = threading.Thread(target=self._run, name="opc-ua", daemon=True)
        self._server: Server | None = None
        self._nodes: dict[tuple[str, str], Node] = {}
        self._writes: dict[str, OnWrite] = {}
        self._unshown: dict[tuple[str, str], Value] = {}
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

    def connect(self, name: str, on_write: OnWrite) -> None:
        """Call `on_write`, in the server's thread, for every later write to a machine or storage."""
        self._writes[name] = on_write

    def show(self, name: str, signal: str, value: Value) -> None:
        """Let a machine or storage show a value."""
        self.loop.call_soon_threadsafe(self._show, name, signal, value)

    def begin(self, work: Coroutine[Any, Any, None]) -> Future[None]:
        """Let something run beside the server; it is cancelled with it at the latest."""
        return asyncio.run_coroutine_threadsafe(self._keep(work), self.loop)

    def cut(self) -> None:
        """End all connections, and be away for `AWAY_S`; changes of that time are shown afterwards."""
        self.begin(self._cut())

    # --- in its thread ---

    def datachange_notification(self, node: Node, value: Any, _data: Any) -> None:
        """Something was written."""
        name, _, signal = str(node.nodeid.Identifier).rpartition(".")
        if name in self._writes and isinstance(value, bool | int | float | str):
            self._writes[name](Signal(signal), value)

    def _run(self) -> None:
        asyncio.set_event_loop(self.loop)
        try:
            self.loop.run_forever()
            self.loop.run_until_complete(_cancel_others())
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
        for name, types in self._types.items():
            for signal, node in (await add_controller(server, space, name, types)).items():
                self._nodes[name, signal] = node
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

    def _show(self, name: str, signal: str, value: Value) -> None:
        self._unshown[name, signal] = value
        self._changed.set()

    async def _show_all(self) -> None:
        while True:
            await self._changed.wait()
            self._changed.clear()
            while self._unshown:
                name, signal = next(iter(self._unshown))
                value = self._unshown.pop((name, signal))
                await self._nodes[name, signal].write_value(shown(signal, value, self._types[name]))


async def _cancel_others() -> None:
    """Cancel all other tasks of the loop: a server that stops leaves those of clients that are still connected."""
    others = asyncio.all_tasks() - {asyncio.current_task()}
    for each in others:
        each.cancel()
    await asyncio.gather(*others, return_exceptions=True)
