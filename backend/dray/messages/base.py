"""What all messages have in common, and the values that their fields may take.

The bounds are checked where bytes are read (`dray.codec`); inside a process a struct is believed. They
keep out what would do harm (a negative quantity, an id that is a wildcard), not what is merely odd.
"""

from __future__ import annotations

from typing import Annotated

import msgspec
from msgspec import Meta

WIRE_VERSION = 2
"""Raised when a receiver of the older version could misunderstand; new optional fields do not raise it."""

Id = Annotated[
    str, Meta(pattern=r"^[^\s/*?#$@]{1,128}(?!\n)$", description="Names one thing; a chunk of a key.")
]
"""Without what has a meaning in a key on the bus: its separator, its wildcards, the mark of what no wildcard
matches, and white space."""

IdOrNone = Annotated[str, Meta(pattern=r"^[^\s/*?#$@]{0,128}(?!\n)$", description="An id; empty for none.")]

Text = Annotated[str, Meta(max_length=1000)]
"""Words for people. What is longer than a page is no message."""

Count = Annotated[int, Meta(ge=0, le=2**53)]
"""Pieces and numbers in a sequence; up to what every JSON reader, a browser's too, holds exactly."""

Seconds = Annotated[float, Meta(ge=-1e11, le=1e11)]
"""A time on the plant's clock, or a length of time: at most three thousand years."""

Metres = Annotated[float, Meta(ge=-1e6, le=1e6)]
"""A place or a distance in the plant: none is a thousand kilometres wide."""

MetresPerSecond = Annotated[float, Meta(ge=-100.0, le=100.0)]

Radians = Annotated[float, Meta(ge=-1e3, le=1e3)]
"""Not wrapped: a vehicle that has turned round often may say so."""

Fraction = Annotated[float, Meta(ge=0.0, le=1.0)]


CLOCKS_AGREE_S = 1.0
"""Clocks of one plant agree within this. It is added wherever a time by one clock is judged by another one."""

CLOCK_WRONG_S = 300.0
"""A clock that is wrong by more is not corrected for. Computers that ask NTP are right within milliseconds; one that was
set by hand is a few minutes off; beyond that a clock has lost its battery, or takes its time from elsewhere."""


class Part(msgspec.Struct, frozen=True, gc=False):
    """A part of a message: an immutable value with no name of its own on the wire."""


class Message(msgspec.Struct, frozen=True, gc=False, tag_field="type", tag=True):
    """One utterance: immutable, named on the wire by its class name in `type`.

    Fields that a receiver does not know are ignored, so an agent of a newer software may add some.
    """
