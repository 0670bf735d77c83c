"""The trace of a run: one fingerprint over all messages, and the last of them in words.

Two runs with one seed have the same fingerprint; otherwise something in them depends on a source outside the seed.
"""

from __future__ import annotations

import hashlib
from collections import deque
from struct import Struct
from typing import TYPE_CHECKING, NamedTuple

from dray.codec import encode

if TYPE_CHECKING:
    from dray.messages import Message

TAIL = 200
"""Utterances kept for printing after a failure: some seconds of a busy plant."""

_HEAD = Struct("<dII")
"""The time, and the lengths of the following parts, so that no two utterances write the same bytes."""


class Utterance(NamedTuple):
    """One message with its sender, address and time."""

    at_s: float
    sender: str
    address: str
    """A key, or ``>`` and the one agent it was sent to."""
    message: Message

    def __str__(self) -> str:
        return f"{self.at_s:12.6f} s  {self.sender} {self.address}  {self.message!r}"


class Trace:
    """A `Listener` that listens to every utterance on a network, at the moment it is said.

    Args:
        tail: how many of the last utterances to keep.

    Attributes:
        tail: the last utterances, oldest first.
        counts: utterances per message type, in the order of the first of each.
    """

    def __init__(self, tail: int = TAIL) -> None:
        self.tail: deque[Utterance] = deque(maxlen=tail)
        self.counts: dict[type[Message], int] = {}
        # 16 bytes: enough that two runs never meet by chance, short enough to read out loud.
        self._hash = hashlib.blake2b(digest_size=16)

    def on_message(self, at_s: float, sender: str, address: str, message: Message) -> None:
        """Note one utterance."""
        data = encode(sender, message)
        name = address.encode()
        self._hash.update(_HEAD.pack(at_s, len(name), len(data)) + name + data)
        kind = type(message)
        self.counts[kind] = self.counts.get(kind, 0) + 1
        self.tail.append(Utterance(at_s, sender, address, message))

    def hexdigest(self) -> str:
        """The fingerprint of all that was said so far."""
        return self._hash.hexdigest()

    def counts_by_name(self) -> dict[str, int]:
        """Utterances per message type, the most frequent first."""
        named = {kind.__name__: number for kind, number in self.counts.items()}
        return dict(sorted(named.items(), key=lambda item: (-item[1], item[0])))
