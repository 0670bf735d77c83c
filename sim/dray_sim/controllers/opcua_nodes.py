"""The nodes of one simulated controller in an OPC UA server: an object, and a variable for each of its signals."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeVar

from asyncua import ua
from asyncua.common.node import Node
from asyncua.server.server import Server

from dray.adapters.signals.signal import LEVEL, Value

S = TypeVar("S", bound=str)

Types = Mapping[S, tuple[Value, ua.VariantType]]
"""The first value and the type of each signal."""


async def add_controller(server: Server, space: int, name: str, types: Types[S]) -> dict[S, Node]:
    """Add a controller, with nodes as `ns=2;s=NAME.pieces` or `ns=2;s=NAME.level.shaft`; none is writable yet.

    Args:
        server: that gets the nodes.
        space: the index of its namespace.
        name: of the controller.
        types: of its signals.
    """
    place = await server.nodes.objects.add_object(_id(name, space), ua.QualifiedName(name, space))
    return {
        signal: await place.add_variable(
            _id(f"{name}.{short(signal)}", space),
            ua.QualifiedName(short(signal), space),
            value,
            kind,
        )
        for signal, (value, kind) in types.items()
    }


def short(signal: str) -> str:
    """The name of a signal's node: that of the signal, or `level.shaft`."""
    return f"level.{signal.removeprefix(LEVEL)}" if signal.startswith(LEVEL) else str(signal)


def shown(
    signal: S, value: Value | None, types: Types[S], status: ua.StatusCode | None = None
) -> ua.DataValue:
    """The value of a signal for its node, or none, with the controller's status code."""
    return ua.DataValue(ua.Variant(value, types[signal][1]), status or ua.StatusCode())


def _id(name: str, space: int) -> ua.NodeId:
    return ua.NodeId.from_string(f"ns={space};s={name}")
