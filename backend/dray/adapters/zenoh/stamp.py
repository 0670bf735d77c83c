"""What a message carries beside itself: which life of its sender it is from, its number, and its seal.

The stamp is Zenoh's attachment, in MessagePack. Numbers count one sender's messages on one key from 1, so
that a receiver sees what has been lost between two of them.
"""

from __future__ import annotations

from typing import Annotated

import msgspec

from dray.errors import WireError

KNOWN = 10_000
"""Senders and keys whose last number is known: ten times those of a plant of three hundred agents."""

NEVER_HEARD = -1
"""Before every life."""

Number = Annotated[int, msgspec.Meta(ge=0)]


class Stamp(msgspec.Struct, frozen=True, gc=False, array_like=True):
    """What stands beside a message.

    Attributes:
        life: which life of its sender it is from (`dray.ports.Bus.join`).
        number: the how-manyth of this life on this key.
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
        WireError: it is none.
    """
    try:
        return _decoder.decode(data)
    except (msgspec.MsgspecError, ValueError, RecursionError) as fault:
        raise WireError(f"its stamp: {fault}", data) from fault


class Tally:
    """Finds out how many messages have not come, by the numbers of those that have."""

    def __init__(self) -> None:
        self._last: dict[tuple[str, str], tuple[int, int]] = {}

    def skipped(self, sender: str, key: str, stamp: Stamp) -> int:
        """How many messages are missing between this one and the last of its sender and key.

        Nothing is missing before the first that is heard, and none that comes late or twice.
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
        """Whether a message is later than all that were counted of its sender and key."""
        life, last = self._last.get((sender, key), (NEVER_HEARD, 0))
        return (stamp.life, stamp.number) > (life, last)

    def forget(self) -> None:
        """Begin anew: what is not listened to is not missed."""
        self._last.clear()
