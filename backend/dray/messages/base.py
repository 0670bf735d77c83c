"""The common part of all messages, and the types of their fields.

Bounds are checked where bytes are read (`dray.codec`); inside a process structs are trusted. They keep out harmful values (a
negative quantity, an id that is a wildcard), and not merely odd ones.
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
"""An id holds no character with a meaning in a key on the bus: separator, wildcards, the mark that no wildcard matches, and white
space."""

IdOrNone = Annotated[str, Meta(pattern=r"^[^\s/*?#$@]{0,128}(?!\n)$", description="An id; empty for none.")]

TEXT_MAX = 1000
"""Maximum characters of a text: a page."""

Text = Annotated[str, Meta(max_length=TEXT_MAX)]
"""Words for people."""

COUNT_MAX = 2**53

Count = Annotated[int, Meta(ge=0, le=COUNT_MAX)]
"""Pieces and sequence numbers, up to the largest integer that every JSON reader, also a browser's, holds exactly."""

LONGEST_S = 1e11

Seconds = Annotated[float, Meta(ge=-LONGEST_S, le=LONGEST_S)]
"""A time on the plant's clock, or a duration: at most three thousand years."""

METRES_MAX = 1e6

Metres = Annotated[float, Meta(ge=-METRES_MAX, le=METRES_MAX)]
"""A coordinate or a distance in the plant: at most a thousand kilometres."""

SPEED_MAX_MPS = 100.0

MetresPerSecond = Annotated[float, Meta(ge=-SPEED_MAX_MPS, le=SPEED_MAX_MPS)]

HEADING_MAX_RAD = 1e3

Radians = Annotated[float, Meta(ge=-HEADING_MAX_RAD, le=HEADING_MAX_RAD)]
"""An angle that is not wrapped: several full turns are allowed."""

Fraction = Annotated[float, Meta(ge=0.0, le=1.0)]


_TURNING = dict.fromkeys((*range(0x202A, 0x202F), *range(0x2066, 0x206A)), "\ufffd")
"""Characters that change the direction of the text after them (Unicode, TR9)."""


def encodable(text: str) -> str:
    """Make text from outside safe to write as UTF-8 and to read in its written order.

    Lone surrogates, which JSON and YAML can hold, and characters that change the text's direction become U+FFFD.
    """
    if text.isascii():
        return text
    return text.encode("utf-16", "surrogatepass").decode("utf-16", "replace").translate(_TURNING)


CLOCKS_AGREE_S = 1.0
"""Largest difference of clocks in one plant. It is added wherever a time by one clock is compared with another clock."""

CLOCK_WRONG_S = 300.0
"""Largest error of a clock that is corrected. With NTP the error is milliseconds; set by hand, a few minutes. Beyond that, the clock
has lost its battery or uses another time."""


class Part(msgspec.Struct, frozen=True, gc=False):
    """A part of a message: an immutable value with no name of its own on the wire."""


class MessageType(msgspec.StructMeta):
    """The type of messages: each class names the kinds of agents that may send it."""

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
    """One message: immutable, named on the wire by its class name in `type`.

    Receivers ignore unknown fields, so newer software may add some.

    Attributes:
        said_by: the kinds of agents that may send it.
        signed: its field that names the sender; empty when it has none.
        radio: whether it goes over the radio between vehicles when there is no WLAN.
    """

    said_by: ClassVar[frozenset[Kind]]
    signed: ClassVar[str]
    radio: ClassVar[bool]
