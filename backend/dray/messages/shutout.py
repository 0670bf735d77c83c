"""Shutting out: agents whose messages are ignored, by a manager's decision.

There is one list. A gateway repeats it on a key of its own, so that agents that join later learn it, too. The list with the highest
number counts, from any gateway. Each agent keeps it and checks every message against it (`dray.messages.speakers`). It silences no
gateway.
"""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta

from dray.messages.base import Count, Id, Message
from dray.messages.kinds import GATEWAYS

MAX_SHUT_OUT = 256
"""Maximum agents on the list: all of a large plant. With the longest ids the message is half of what a bus carries
(`dray.codec.MAX_BYTES`)."""


class ShutOut(Message, said_by=GATEWAYS, frozen=True):
    """All agents that are shut out at present; all others are heard."""

    number: Count
    """Grows with every decision: its time, in milliseconds of unix time, or one more than the one before."""
    agents: Annotated[tuple[Id, ...], Meta(max_length=MAX_SHUT_OUT)] = ()
