"""A message's stamp: the sender's life, the message's number, and its seal.

The stamp is Zenoh's attachment, in MessagePack. Numbers count one sender's messages on one key from 1, so that a receiver
sees the losses in between.
"""

from __future__ import annotations

from typing import Annotated

import msgspec

from dray.errors import WireError

KNOWN = 10_000
"""Maximum senders and keys with a known last number: ten times those of a plant of three hundred agents."""

NEVER_HEARD = -1
"""A number below all lives."""

Number = Annotated[int, msgspec.Meta(ge=0)]


class Stamp(msgspec.Struct, frozen=True, gc=False, array_like=True):
    """The data beside a message.

    Attributes:
        life: the sender's life (`dray.ports.Bus.join`).
        number: the message's number in this life on this key.
        seal: see `dray.adapters.security.seals`; empty on a bus without certificates.
    """

    life: Number
    number: Number
    seal: bytes = b""


_encoder = msgspec.msgpack.Encoder()
_decoder = msgspec.msgpack.Decoder(Stamp)

write_stamp = _encoder.encode


def read_stamp(data: bytes) -> Stamp:
    """Read a stamp.

    Raises:
        WireError: it is invalid.
    """
    try:
        return _decoder.decode(data)
    except (msgspec.MsgspecError, ValueError, RecursionError) as fault:
        raise WireError(f"its stamp: {fault}", data) from fault


class Tally:
    """Counts missing messages, by the numbers of received ones."""

    def __init__(self) -> None:
        self._last: dict[tuple[str, str], tuple[int, int]] = {}

    def skipped(self, sender: str, key: str, stamp: Stamp) -> int:
        """The number of missing messages between this one and the last of its sender and key.

        None are missing before the first received one; late and repeated messages count nothing.
        """
        place = (sender, key)
        life, last = self._last.get(place, (NEVER_HEARD, 0))
        if stamp.life < life or (stamp.life == life and stamp.number <= last):
            return 0
        if len(self._last) >= KNOWN:
            self._last.clear()
        self._last[place] = (stamp.life, stamp.number)
        return stamp.number - last - 1 if stamp.life == life else 0

    def is_news(self, sender: str, key: str, stamp: Stamp) -> bool:
        """Whether a message is later than all counted ones of its sender and key."""
        life, last = self._last.get((sender, key), (NEVER_HEARD, 0))
        return (stamp.life, stamp.number) > (life, last)

    def forget(self) -> None:
        """Start again after an interruption of listening, without missing messages."""
        self._last.clear()
