"""What lies at a machine, which not every heartbeat of it tells: details at a change and now and then, the rest at the full rate (paper, 3.2)."""

from __future__ import annotations

from msgspec import UNSET
from msgspec.structs import replace

from dray.messages.heartbeat import MachineHeartbeat

STOCK_EVERY_S = 10.0
"""Where it has not changed: whoever comes, or has missed a heartbeat, knows it then."""


def with_stock(heartbeat: MachineHeartbeat, before: MachineHeartbeat | None) -> MachineHeartbeat:
    """A heartbeat that tells what lies at its machine, as far as that is known.

    Args:
        heartbeat: the newest one.
        before: the one before it, made whole likewise; None for none.
    """
    if before is None or before.incarnation != heartbeat.incarnation:
        return heartbeat
    left_out = {
        name: getattr(before, name)
        for name in ("buffers", "goods", "documents")
        if getattr(heartbeat, name) is UNSET
    }
    return replace(heartbeat, **left_out) if left_out else heartbeat
