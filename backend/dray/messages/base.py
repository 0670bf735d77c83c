"""What all messages have in common."""

from __future__ import annotations

import msgspec

WIRE_VERSION = 1
"""Raised when a receiver of the older version could misunderstand; new optional fields do not raise it."""


class Part(msgspec.Struct, frozen=True, gc=False):
    """A part of a message: an immutable value with no name of its own on the wire."""


class Message(msgspec.Struct, frozen=True, gc=False, tag_field="type", tag=True):
    """One utterance: immutable, named on the wire by its class name in `type`.

    Fields that a receiver does not know are ignored, so an agent of a newer software may add some.
    """
