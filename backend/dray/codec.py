"""Bytes <-> messages: the only validator of what comes from the wire.

A message travels as UTF-8 JSON in an envelope: ``{"v": 2, "from": "ATV-07", "m": {"type": "Bid", ...}}``.
`v` is the wire version, `from` the sender; `t` carries the trace context, if any. Unknown fields are ignored, so
newer software may add some. A newer *version* is refused, because we could misunderstand it.

The bounds of values are written on the fields in `dray.messages` and checked here. The protocol decides whether a
message makes sense now.
"""

from __future__ import annotations

from typing import Annotated

import msgspec
from msgspec import Meta

from dray.errors import NewerVersion, WireError
from dray.messages import WIRE_VERSION, AnyMessage, Message
from dray.messages.base import Id

MAX_BYTES = 64 * 1024
"""The longest message we read. The longest legitimate one, a machine's heartbeat with fifty open tasks, has some 15 kB.
The bound protects our memory."""


Context = Annotated[str, Meta(max_length=256, description="A trace, as W3C traceparent; empty for none.")]
"""Longer than today's 55 characters: a later version of that standard may append something."""


class Envelope(msgspec.Struct, frozen=True, gc=False):
    """A message with its sender and version, as it goes over the wire."""

    v: int
    sender: Id = msgspec.field(name="from")
    m: AnyMessage
    t: Context = ""
    """The trace to which the message belongs; agents without tracing leave it out."""


class _Version(msgspec.Struct, gc=False):
    """The part of an envelope that all versions share."""

    v: int


_encoder = msgspec.json.Encoder()
_decoder = msgspec.json.Decoder(Envelope)
_version_decoder = msgspec.json.Decoder(_Version)

# A decoder's own words for broken JSON, a wrong type or value, bad UTF-8, and nesting without end.
_FAULTS = (msgspec.MsgspecError, ValueError, RecursionError)


def encode(sender: str, message: Message, context: str = "") -> bytes:
    """Write one message; the same message always gives the same bytes.

    Args:
        sender: the id of the agent that says it.
        message: one of `AnyMessage`.
        context: the trace to which it belongs, if any.

    Returns:
        UTF-8 JSON. It may be longer than `MAX_BYTES`; then no peer reads it.
    """
    envelope = {"v": WIRE_VERSION, "from": sender, "m": message}
    return _encoder.encode(envelope | {"t": context} if context else envelope)


def decode(data: bytes) -> tuple[str, Message]:
    """Read one message; as `decode_with_context`, without the trace."""
    sender, message, _ = decode_with_context(data)
    return sender, message


def decode_with_context(data: bytes) -> tuple[str, Message, str]:
    """Read one message.

    Returns:
        The sender's id, the message, and its trace; empty for none.

    Raises:
        NewerVersion: its wire version is unknown to us.
        WireError: it is no message of ours. No other error is raised for any bytes.
    """
    if len(data) > MAX_BYTES:
        raise WireError(f"{len(data)} bytes, more than {MAX_BYTES}", data)
    try:
        envelope = _decoder.decode(data)
    except _FAULTS as fault:
        # A newer version may look different inside, so ask for the version before blaming the peer.
        _refuse_newer(data)
        raise WireError(str(fault), data) from fault
    if envelope.v != WIRE_VERSION:
        _refuse_newer(data)
        raise WireError(f"wire version {envelope.v} was never spoken", data)
    return envelope.sender, envelope.m, envelope.t


def _refuse_newer(data: bytes) -> None:
    try:
        version = _version_decoder.decode(data).v
    except _FAULTS:
        return
    if version > WIRE_VERSION:
        raise NewerVersion(f"wire version {version}, and we speak {WIRE_VERSION}; update this software", data)
