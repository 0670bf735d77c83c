"""A machine's stock, which only some of its heartbeats contain: those after a change, and one now and then (paper, 3.2)."""

from __future__ import annotations

from msgspec import UNSET
from msgspec.structs import replace

from dray.messages.heartbeat import MachineHeartbeat

STOCK_EVERY_S = 10.0
"""Interval of heartbeats with unchanged stock, for agents that have joined or missed one."""


def with_stock(heartbeat: MachineHeartbeat, before: MachineHeartbeat | None) -> MachineHeartbeat:
    """A heartbeat with its machine's stock filled in, as far as it is known.

    Args:
        heartbeat: the newest one.
        before: the one before it, filled in likewise; None for none.
    """
    if before is None or before.incarnation != heartbeat.incarnation:
        return heartbeat
    left_out = {
        name: getattr(before, name)
        for name in ("buffers", "goods", "documents")
        if getattr(heartbeat, name) is UNSET
    }
    return replace(heartbeat, **left_out) if left_out else heartbeat
