"""Shutting out: the agents that nobody listens to any more, by a manager's decision.

There is one list, and a gateway says it again and again on a key of its own, so that whoever joins later
learns it too. The list with the highest number counts, whichever gateway has said it; whoever has heard it
keeps it, and asks it of every message (`dray.messages.speakers`).
"""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta

from dray.messages.base import Count, Id, Message
from dray.messages.kinds import GATEWAYS

MAX_SHUT_OUT = 256
"""Agents that are shut out at once: a large plant's. With ids of the greatest length the message is still half of
what a bus carries (`dray.codec.MAX_BYTES`)."""


class ShutOut(Message, said_by=GATEWAYS, frozen=True):
    """Everybody who is shut out at present; whoever is not named is heard."""

    number: Count
    """Grows with every decision: its time, in milliseconds of unix time, or one more than the one before."""
    agents: Annotated[tuple[Id, ...], Meta(max_length=MAX_SHUT_OUT)] = ()
