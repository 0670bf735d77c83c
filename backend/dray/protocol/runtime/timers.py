"""An agent's alarms, by name, each with its time."""

from __future__ import annotations

from collections.abc import Hashable
from zlib import crc32

from dray.protocol.runtime.events import NEVER_S


class Timers:
    """Named alarms of one agent, with a single wake-up time `next_s`.

    Setting an alarm again moves it. Due alarms come in the order of their times, then in the order in which they
    were set.
    """

    __slots__ = ("_at_s", "next_s")

    def __init__(self) -> None:
        self._at_s: dict[Hashable, float] = {}
        self.next_s = NEVER_S
        """The earliest alarm time; `NEVER_S` if none is set."""

    def set(self, name: Hashable, at_s: float) -> None:
        """Sound `name` at `at_s`."""
        before_s = self._at_s.pop(name, NEVER_S)
        self._at_s[name] = at_s
        if at_s <= self.next_s:
            self.next_s = at_s
        elif before_s == self.next_s:
            self.next_s = min(self._at_s.values())

    def clear(self, name: Hashable) -> None:
        """Cancel `name`; ignored if it is not set."""
        before_s = self._at_s.pop(name, NEVER_S)
        if before_s == self.next_s:
            self.next_s = min(self._at_s.values(), default=NEVER_S)

    def is_set(self, name: Hashable) -> bool:
        return name in self._at_s

    def due(self, now_s: float) -> list[Hashable]:
        """Remove and return all due alarms."""
        if now_s < self.next_s:
            return []
        at_s_of = self._at_s
        names = [name for name, at_s in at_s_of.items() if at_s <= now_s]
        if len(names) > 1:
            names.sort(key=at_s_of.__getitem__)
        for name in names:
            del at_s_of[name]
        self.next_s = min(at_s_of.values()) if at_s_of else NEVER_S
        return names


def spread_frac(agent: str) -> float:
    """A fraction from 0 to nearly 1 that follows from an agent's name.

    Agents that start together must not do everything together for ever.
    """
    return crc32(agent.encode()) % 1000 / 1000
