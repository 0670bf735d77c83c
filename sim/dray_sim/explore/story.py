"""What came before a violation, in lines that a person can read.

Heartbeats are left out: there are many, and what matters in them is said otherwise too. When the
violation names tasks or agents, what was said about them is told further back than the rest.
"""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Iterator
from enum import Enum
from typing import NamedTuple

import msgspec

from dray.messages import Event, Heartbeat, Message, Production, Transport

KEPT = 20_000
"""Utterances kept while a trial is played again: all of it, but for the longest."""

LAST = 30
"""Lines of whatever was said at the end."""

ABOUT = 40
"""Lines about what the violation names."""

_NAMES = re.compile(r"[A-Za-z][\w.-]*\d[\w.-]*\w|[A-Z]+\d+")


class Line(NamedTuple):
    """One thing that was said or done."""

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
    """An ear that keeps what was said, and tells it afterwards."""

    def __init__(self) -> None:
        self._lines: deque[Line] = deque(maxlen=KEPT)

    def hear(self, at_s: float, sender: str, address: str, message: Message) -> None:
        """Keep one utterance."""
        if not isinstance(message, Heartbeat):
            to = address[1:] if address.startswith(">") else "all"
            self._lines.append(Line(at_s, sender, to, message))

    def note(self, at_s: float, what: str) -> None:
        """Keep something that was done, a fault say."""
        self._lines.append(Line(at_s, "", "", what))

    def tell(self, broken: str) -> tuple[str, ...]:
        """The lines that lead to a violation, oldest first.

        Args:
            broken: its words; what they name is looked for.
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
    about = {getattr(said, field, None) for field in ("task", "goal", "order")}
    tasks = {name for name in names if name in about}
    return bool(tasks)


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
