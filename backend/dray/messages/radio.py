"""Messages over the radio between vehicles when there is no WLAN (paper, case 3).

These are vehicles' shortened heartbeats and each message that is defined with `radio`: for transports under way, right of way, and
calls for help. Negotiation (bids, announcements, awards, claims) and history do not fit.

The radio's range, hops and frame length belong to the hardware and are not defined here.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from msgspec import UNSET
from msgspec.structs import replace

from dray.messages.base import Message
from dray.messages.floor.traffic import (
    PlaceRequested,
    YieldAsked,
    YieldRefused,
)
from dray.messages.heartbeat import AtvHeartbeat
from dray.messages.link import Link
from dray.messages.people.call import HelpCall

DISPENSABLE: tuple[dict[str, Any], ...] = (
    {"way": ()},
    {"watches": ()},
    {
        "body_wait": UNSET,
        "software": "",
        "dwell_point": "",
        "about_problem": UNSET,
        "sent_to_charge": False,
        "in_reserve": False,
        "left_empty": "",
    },
    {"floor": UNSET, "closures": UNSET},
    {"out_of_service": UNSET, "lost_wlan": UNSET},
)
"""Fields that a heartbeat leaves out so that it fits into a frame, the least needed first."""


AVOID_NODES = (16, 4, 0)
"""Numbers of nodes in `avoid`, nearest first, that are tried until a message about right of way fits into a frame."""


CALL_ASKED, REASON_CHARS = (8, 2), 100
"""Numbers of asked operators in a call, nearest first, that are tried until it fits; and the characters of its reason."""


def shortened_word(message: Message) -> Iterator[Message]:
    """A message other than a heartbeat as it goes over the radio: whole, and then ever shorter."""
    yield message
    if isinstance(message, PlaceRequested | YieldAsked | YieldRefused):
        for nodes in AVOID_NODES:
            yield replace(message, avoid=message.avoid[:nodes])
    elif isinstance(message, HelpCall):
        for asked in CALL_ASKED:
            yield replace(message, reason=message.reason[:REASON_CHARS], asked=message.asked[:asked])


def shortened(heartbeat: AtvHeartbeat) -> Iterator[AtvHeartbeat]:
    """A heartbeat as it goes over the radio: whole, and then ever shorter."""
    short = replace(heartbeat, link=Link.MESH)
    yield short
    for left_out in DISPENSABLE:
        short = replace(short, **left_out)
        yield short
