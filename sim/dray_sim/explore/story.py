"""The events before a violation, in lines that a person can read.

Heartbeats are left out: there are many, and other messages tell their important content too. When the violation names
tasks, goals or orders, all changes of their state are told, with the faults of that time.
"""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Iterator
from enum import Enum
from typing import NamedTuple

import msgspec

from dray.messages import (
    Bid,
    Docked,
    DockHeld,
    Event,
    Heartbeat,
    Message,
    Production,
    TaskAnnounced,
    Transport,
)
from dray.messages.fact import BidReceived, BidRefused, BidSent, PieceMade, RoundFailed, TaskOpened

KEPT = 20_000
"""Utterances kept while a run is played again: all of them, except in the longest runs."""

LAST = 20
"""Lines about the end of the run."""

ABOUT = 80
"""Lines about the names in the violation."""

REPEATED = (
    Bid,
    BidReceived,
    BidRefused,
    BidSent,
    Docked,
    DockHeld,
    PieceMade,
    RoundFailed,
    TaskAnnounced,
    TaskOpened,
)
"""Messages that are repeated while nothing changes."""

_NAMES = re.compile(r"[A-Za-z][\w.-]*\d[\w.-]*\w|[A-Z]+\d+")


class Line(NamedTuple):
    """One message or event."""

    at_s: float
    who: str
    to: str
    what: Message | str

    def __str__(self) -> str:
        if isinstance(self.what, str):
            return f"{self.at_s:9.3f} s  {self.what}"
        if type(self.what) is Event:
            return f"{self.at_s:9.3f} s  {self.who} notes {_words(self.what.fact)}"
        return f"{self.at_s:9.3f} s  {self.who} to {self.to}: {_words(self.what)}"


class Story:
    """A listener that keeps the messages, and tells them afterwards."""

    def __init__(self) -> None:
        self._lines: deque[Line] = deque(maxlen=KEPT)

    def on_message(self, at_s: float, sender: str, address: str, message: Message) -> None:
        """Keep one utterance."""
        if not isinstance(message, Heartbeat):
            to = address[1:] if address.startswith(">") else "all"
            line = Line(at_s, sender, to, message)
            # An announcement goes to many cells.
            if not self._lines or self._lines[-1] != line:
                self._lines.append(line)

    def note(self, at_s: float, what: str) -> None:
        """Keep something that was done, a fault say."""
        self._lines.append(Line(at_s, "", "", what))

    def tell(self, broken: str) -> tuple[str, ...]:
        """The lines that lead to a violation, oldest first.

        Args:
            broken: its words; the lines about their names are looked for.
        """
        lines = list(self._lines)
        told = dict.fromkeys(range(max(0, len(lines) - LAST), len(lines)))
        names = set(_NAMES.findall(broken))
        about = [at for at, line in enumerate(lines) if _concerns(line, names)]
        told |= dict.fromkeys(about[-ABOUT:])
        return tuple(str(lines[at]) for at in sorted(told))


def _concerns(line: Line, names: set[str]) -> bool:
    if isinstance(line.what, str):
        return True
    said = line.what.fact if type(line.what) is Event else line.what
    if isinstance(said, REPEATED):
        return False
    return any(getattr(said, field, None) in names for field in ("task", "goal", "order"))


def _words(said: msgspec.Struct) -> str:
    return f"{type(said).__name__} {' '.join(_parts(said))}"


def _parts(said: msgspec.Struct) -> Iterator[str]:
    for name in said.__struct_fields__:
        value = getattr(said, name)
        if isinstance(value, Transport):
            yield f"{value.quantity} x {value.item} to {value.destination}"
        elif isinstance(value, Production):
            yield f"{value.quantity} x {value.product}"
        elif isinstance(value, Enum):
            yield f"{name}={value.value}"
        elif isinstance(value, float):
            yield f"{name}={value:.1f}"
        elif isinstance(value, str | int) and value not in ("", 0):
            yield f"{name}={value}"
