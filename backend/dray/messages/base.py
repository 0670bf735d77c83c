"""What all messages have in common, and the values that their fields may take.

The bounds are checked where bytes are read (`dray.codec`); inside a process a struct is believed. They
keep out what would do harm (a negative quantity, an id that is a wildcard), not what is merely odd.
"""

from __future__ import annotations

from typing import Annotated, Any, ClassVar

import msgspec
from msgspec import Meta

from dray.messages.kinds import NOBODY, Kind

WIRE_VERSION = 2
"""Raised when a receiver of the older version could misunderstand; new optional fields do not raise it."""

Id = Annotated[
    str, Meta(pattern=r"^[^\s/*?#$@]{1,128}(?!\n)$", description="Names one thing; a chunk of a key.")
]
"""Without what has a meaning in a key on the bus: its separator, its wildcards, the mark of what no wildcard
matches, and white space."""

IdOrNone = Annotated[str, Meta(pattern=r"^[^\s/*?#$@]{0,128}(?!\n)$", description="An id; empty for none.")]

TEXT_MAX = 1000
"""Characters. What is longer than a page is no message."""

Text = Annotated[str, Meta(max_length=TEXT_MAX)]
"""Words for people."""

COUNT_MAX = 2**53

Count = Annotated[int, Meta(ge=0, le=COUNT_MAX)]
"""Pieces and numbers in a sequence; up to what every JSON reader, a browser's too, holds exactly."""

LONGEST_S = 1e11

Seconds = Annotated[float, Meta(ge=-LONGEST_S, le=LONGEST_S)]
"""A time on the plant's clock, or a length of time: at most three thousand years."""

METRES_MAX = 1e6

Metres = Annotated[float, Meta(ge=-METRES_MAX, le=METRES_MAX)]
"""A place or a distance in the plant: none is a thousand kilometres wide."""

SPEED_MAX_MPS = 100.0

MetresPerSecond = Annotated[float, Meta(ge=-SPEED_MAX_MPS, le=SPEED_MAX_MPS)]

HEADING_MAX_RAD = 1e3

Radians = Annotated[float, Meta(ge=-HEADING_MAX_RAD, le=HEADING_MAX_RAD)]
"""Not wrapped: a vehicle that has turned round often may say so."""

Fraction = Annotated[float, Meta(ge=0.0, le=1.0)]


_TURNING = dict.fromkeys((*range(0x202A, 0x202F), *range(0x2066, 0x206A)), "\ufffd")
"""Characters that turn the direction of the text behind them (Unicode, TR9)."""


def encodable(text: str) -> str:
    """Text from outside that can be written as UTF-8, and reads as it is written.

    A lone surrogate, which JSON and YAML can hold, becomes U+FFFD, and so does what makes text read in another order.
    """
    if text.isascii():
        return text
    return text.encode("utf-16", "surrogatepass").decode("utf-16", "replace").translate(_TURNING)


CLOCKS_AGREE_S = 1.0
"""Clocks of one plant agree within this. It is added wherever a time by one clock is judged by another one."""

CLOCK_WRONG_S = 300.0
"""A clock that is wrong by more is not corrected for. Computers that ask NTP are right within milliseconds; one that was
set by hand is a few minutes off; beyond that a clock has lost its battery, or takes its time from elsewhere."""


class Part(msgspec.Struct, frozen=True, gc=False):
    """A part of a message: an immutable value with no name of its own on the wire."""


class MessageType(msgspec.StructMeta):
    """The type of messages: each says where it is defined who may say it."""

    def __new__(
        cls,
        name: str,
        bases: tuple[type, ...],
        namespace: dict[str, Any],
        *,
        said_by: frozenset[Kind] = NOBODY,
        signed: str = "",
        radio: bool = False,
        **config: Any,
    ) -> Any:
        said = {"said_by": said_by, "signed": signed, "radio": radio}
        return super().__new__(cls, name, bases, namespace | said, **config)


class Message(msgspec.Struct, metaclass=MessageType, frozen=True, gc=False, tag_field="type", tag=True):
    """One utterance: immutable, named on the wire by its class name in `type`.

    Fields that a receiver does not know are ignored, so an agent of a newer software may add some.

    Attributes:
        said_by: the kinds of agents that may say it.
        signed: its field that says who speaks; empty where none does.
        radio: whether it goes over the radio between vehicles when there is no WLAN.
    """

    said_by: ClassVar[frozenset[Kind]]
    signed: ClassVar[str]
    radio: ClassVar[bool]
