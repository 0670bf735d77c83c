"""A controller of our own that is an OPC UA server, for tests: a counter, bits and words, as a machine builder would lay them out."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from pathlib import Path
from typing import Self

from asyncua import Node, Server, ua
from asyncua.crypto.permission_rules import SimpleRoleRuleset, User, UserRole
from asyncua.server.address_space import NodeData
from asyncua.server.user_managers import UserManager

from dray.adapters.signals.signal import Signal, Value
from dray_sim.controllers.opcua_nodes import add_controller, shown

NAMESPACE = "http://example.org/press"

TYPES = {
    Signal.PIECES: (0, ua.VariantType.UInt16),
    Signal.BAD: (0, ua.VariantType.UInt16),
    Signal.FAULT: (False, ua.VariantType.Boolean),
    Signal.FAULT_TEXT: ("", ua.VariantType.String),
    Signal.DOCK_READY: (False, ua.VariantType.Boolean),
    Signal.RUN: (False, ua.VariantType.Boolean),
    Signal.PRODUCT: ("", ua.VariantType.String),
    Signal.SPEED: (100.0, ua.VariantType.Float),
    Signal.DOCK_PERMIT: (False, ua.VariantType.Boolean),
    Signal.DOCK_VEHICLE: ("", ua.VariantType.String),
    Signal.GOAL: ("", ua.VariantType.String),
    Signal.ADMITTED: (0, ua.VariantType.UInt16),
    Signal.ADMITTED_GOAL: ("", ua.VariantType.String),
    Signal.ALIVE: (0, ua.VariantType.Int16),
}

PATIENCE_S = 60.0
"""Far beyond what a busy computer takes."""


class OneUser(UserManager):
    """Knows one name and one password."""

    def get_user(
        self,
        iserver: object,
        username: str | None = None,
        password: str | None = None,
        certificate: object = None,
    ) -> User | None:
        return User(UserRole.User, username) if (username, password) == ("dray", "secret") else None


class Plc:
    """A server on this machine.

    Args:
        port: TCP port; 0 for any.
        user: whether it wants name and password.
        certificates: its own certificate and key, where it wants to be spoken to in secret.
        pieces: what its counter shows at the beginning.
        types: of its nodes, where they differ from `TYPES`.
    """

    def __init__(
        self,
        port: int = 0,
        *,
        user: bool = False,
        certificates: tuple[Path, Path] | None = None,
        pieces: int = 0,
        types: dict[Signal, ua.VariantType] | None = None,
    ) -> None:
        self._types = TYPES | {signal: (TYPES[signal][0], kind) for signal, kind in (types or {}).items()}
        self._shows: dict[Signal, Value] = {Signal.PIECES: pieces}
        self._server = Server(user_manager=OneUser() if user else None)
        self._port, self._certificates, self._user = port, certificates, user
        self.nodes: dict[Signal, Node] = {}

    async def __aenter__(self) -> Self:
        server = self._server
        await server.init()
        server.set_endpoint(f"opc.tcp://127.0.0.1:{self._port}/plc")
        if self._certificates is not None:
            certificate, key = self._certificates
            await server.load_certificate(certificate)
            await server.load_private_key(key)
            server.set_security_policy(
                [ua.SecurityPolicyType.Basic256Sha256_SignAndEncrypt], permission_ruleset=SimpleRoleRuleset()
            )
        else:
            server.set_security_policy([ua.SecurityPolicyType.NoSecurity])
        space = await server.register_namespace(NAMESPACE)
        begins = {
            signal: (self._shows.get(signal, value), kind) for signal, (value, kind) in self._types.items()
        }
        self.nodes = await add_controller(server, space, "Press", begins)
        for node in self.nodes.values():
            await node.set_writable()
        await server.start()
        if not self._port:
            self._port = server.bserver.port
        return self

    async def __aexit__(self, *_: object) -> None:
        await self._server.stop()

    @property
    def url(self) -> str:
        return f"opc.tcp://127.0.0.1:{self._port}/plc"

    @property
    def port(self) -> int:
        return self._port

    async def put(self, signal: Signal, value: Value | None, status: int = ua.StatusCodes.Good) -> None:
        """Show a value."""
        await self.nodes[signal].write_value(shown(signal, value, self._types, ua.StatusCode(status)))

    def refuse(self, signal: Signal, values: set[Value]) -> None:
        """Refuse these values from now on, and take others."""

        def write(node: NodeData, attribute: ua.AttributeIds, data: ua.DataValue) -> None:
            if data.Value is not None and data.Value.Value in values:
                raise ua.UaStatusCodeError(ua.StatusCodes.BadOutOfRange)
            node.attributes[attribute].value = data

        space = self._server.iserver.aspace
        space.set_attribute_value_setter(self.nodes[signal].nodeid, ua.AttributeIds.Value, write)

    def note_writes(self, *signals: Signal) -> list[tuple[Signal, Value]]:
        """Note what is written to these nodes from now on, in its order."""
        written: list[tuple[Signal, Value]] = []
        space = self._server.iserver.aspace

        def noting(signal: Signal) -> Callable[[NodeData, ua.AttributeIds, ua.DataValue], None]:
            def write(node: NodeData, attribute: ua.AttributeIds, data: ua.DataValue) -> None:
                node.attributes[attribute].value = data
                if data.Value is not None:
                    written.append((signal, data.Value.Value))

            return write

        for signal in signals:
            space.set_attribute_value_setter(self.nodes[signal].nodeid, ua.AttributeIds.Value, noting(signal))
        return written

    async def read(self, signal: Signal) -> Value:
        """What it was told, or shows."""
        read: Value = await self.nodes[signal].read_value()
        return read

    async def until(self, signal: Signal, value: Value) -> None:
        """Wait until it has been told something."""
        async with asyncio.timeout(PATIENCE_S):
            shown = await self.read(signal)
            while shown != value:
                await asyncio.sleep(0.02)
                shown = await self.read(signal)


def mapping(signals: tuple[Signal, ...]) -> dict[str, dict[str, str]]:
    """A mapping file's `signals`, for its nodes."""
    return {signal.value: {"node": f"nsu={NAMESPACE};s=Press.{signal.value}"} for signal in signals}
