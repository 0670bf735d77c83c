"""What goes over the radio between vehicles when there is no WLAN (paper, case 3).

Heartbeats, and what a transport that is under way needs to come to its end. No negotiation: bids, announcements, awards, claims and history do not fit.

The radio itself (range, hops, length of a frame) is hardware, and not said here.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from msgspec.structs import replace

from dray.messages.base import Message
from dray.messages.command import CommandAnswered, VehicleCommand
from dray.messages.contract import (
    Confirmed,
    Declined,
    Docked,
    DockHeld,
    DockOpened,
    Handover,
    HandoverAccepted,
    Release,
    Resigned,
    Superseded,
    TakenOver,
    Withdrawn,
)
from dray.messages.heartbeat import AtvHeartbeat, Link

CARRIED_BY_RADIO: frozenset[type[Message]] = frozenset(
    {
        CommandAnswered,
        Confirmed,
        Declined,
        DockHeld,
        DockOpened,
        Docked,
        Handover,
        HandoverAccepted,
        Release,
        Resigned,
        Superseded,
        TakenOver,
        VehicleCommand,
        Withdrawn,
    }
)
"""What may go by radio beside heartbeats, in both directions."""

DISPENSABLE: tuple[dict[str, Any], ...] = ({"way": ()}, {"watches": ()}, {"software": "", "dwell_point": ""})
"""What a heartbeat leaves out so that it fits into a frame, in this order: what others can do without first."""


def shortened(heartbeat: AtvHeartbeat) -> Iterator[AtvHeartbeat]:
    """A heartbeat as it goes over the radio: whole, and then ever shorter."""
    short = replace(heartbeat, link=Link.MESH)
    yield short
    for left_out in DISPENSABLE:
        short = replace(short, **left_out)
        yield short
