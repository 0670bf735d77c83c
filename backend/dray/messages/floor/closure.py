"""Closures: what people have closed to vehicles, made slow or one-way, for a time or until they open it again.

There is one list. A gateway repeats it on a key of its own, so that vehicles that join or return later learn it, too. The list
with the highest number counts, from any gateway. A vehicle obeys only signed words (`dray.messages.people.command`), so the
list carries a signature over all of it.
"""

from __future__ import annotations

from enum import StrEnum
from math import floor
from typing import Annotated

import msgspec
from msgspec import Meta

from dray.messages.base import Count, Id, IdOrNone, Message, Metres, Part, Seconds
from dray.messages.kinds import GATEWAYS

MAX_CLOSURES = 64
"""Maximum closures at one time. More would shut the plant; with the longest ids the message is still within what a bus carries
(`dray.codec.MAX_BYTES`)."""

MAX_CORNERS = 12
"""Maximum corners of an outline; bounded for the same reason."""

Corner = tuple[Metres, Metres]
"""x and y (m)."""

SLOWEST_MPS = 0.1
"""Slowest limit of a slow lane: a slower vehicle looks like a standing one."""


class ClosureKind(StrEnum):
    """What a closure does to the lanes that it concerns."""

    CLOSED = "closed"
    """No vehicle enters them; those inside leave."""
    SLOW = "slow"
    """They are driven at `speed_mps` at most."""
    ONE_WAY = "one_way"
    """A lane is driven from `start` to `end` only."""


class Closure(Part, frozen=True):
    """One decision of a person about one lane, one node, one area or one outline: exactly one of them is named."""

    closure: Id
    kind: ClosureKind
    by: Id
    """The person who has decided it."""
    start: IdOrNone = ""
    end: IdOrNone = ""
    """The nodes at the ends of a lane. Both directions are meant, if there are two, unless it becomes one-way. On a two-lane road the
    lane beside it is meant, too."""
    node: IdOrNone = ""
    """A node: all lanes that lead into it. A crossing of two-lane roads: all lanes over it."""
    area: IdOrNone = ""
    """An area of the plant: its nodes, and the lanes that cross it."""
    outline: Annotated[tuple[Corner, ...], Meta(max_length=MAX_CORNERS)] = ()
    """The corners of a drawn part of the floor: its nodes, and the lanes that cross it, as with an area."""
    speed_mps: Annotated[float, Meta(ge=SLOWEST_MPS, le=100.0)] | None = None
    """For SLOW."""
    until_s: Seconds | None = None
    """When it ends by itself (plant clock); None for never: a person opens it."""


class Closures(Message, said_by=GATEWAYS, frozen=True):
    """All present closures; everything else is open."""

    number: Count
    """Grows with every decision: its time, in milliseconds of unix time, or one more than the one before."""
    signature: Annotated[bytes, Meta(min_length=64, max_length=64)]
    """Ed25519, over `closed_words`."""
    closures: Annotated[tuple[Closure, ...], Meta(max_length=MAX_CLOSURES)] = ()


def closed_words(number: int, closures: tuple[Closure, ...]) -> bytes:
    """The bytes that a list's signature covers: a JSON array without white space, numbers as whole thousandths."""
    return _encoder.encode(
        (
            "dray closures 1",
            number,
            tuple(
                (
                    each.closure,
                    each.kind.value,
                    each.by,
                    each.start,
                    each.end,
                    each.node,
                    each.area,
                    tuple((_thousandths(x_m), _thousandths(y_m)) for x_m, y_m in each.outline),
                    _thousandths(each.speed_mps),
                    _thousandths(each.until_s),
                )
                for each in closures
            ),
        )
    )


_encoder = msgspec.json.Encoder()


def _thousandths(value: float | None) -> int | None:
    """Halves are rounded up, as in `dray.messages.people.command`."""
    return None if value is None else floor(value * 1000.0 + 0.5)
