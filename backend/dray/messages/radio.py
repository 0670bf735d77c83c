"""What goes over the radio between vehicles when there is no WLAN (paper, case 3).

That is vehicles' heartbeats, in parts, and each message that is defined with `radio`: what a transport that is under way needs to
come to its end, who may drive where, and calls for help. No negotiation: bids, announcements, awards, claims and history do not fit.

The radio itself (range, hops, length of a frame) is hardware, and not said here.
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
    {"body_wait": UNSET, "software": "", "dwell_point": "", "about_problem": UNSET, "sent_to_charge": False},
    {"floor": UNSET, "closures": UNSET},
    {"out_of_service": UNSET, "lost_wlan": UNSET},
)
"""What a heartbeat leaves out so that it fits into a frame, in this order: what others can do without first."""


AVOID_NODES = (16, 4, 0)
"""Of where nobody may make room, a place request or a request to make room says so many nodes, the nearest first, until it fits into a frame."""


CALL_ASKED, REASON_CHARS = (8, 2), 100
"""Of a call's words so much is said by radio, and of whom it asks so many names, the nearest first, until it fits."""


def shortened_word(message: Message) -> Iterator[Message]:
    """What is no heartbeat as it goes over the radio: whole, and then ever shorter."""
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
