"""An agent's journal in the simulation: notes that outlive its worker, as a disk would."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

import msgspec

from dray.memory import Changes, Memory, Note
from dray.messages import Event

HISTORY_FACTS = 1000
"""Facts kept for agents that missed some: with 300 agents in one memory some 150 MB at worst. At one fact in ten
seconds they cover nearly three hours of a historian's absence."""

_READ: msgspec.json.Decoder[dict[str, Note]] = msgspec.json.Decoder(dict[str, Note])


class HeldJournal:
    """Implements `dray.ports.Journal` in memory; the factory that restarts the agent holds it.

    Args:
        incarnation: of the first life.
        events_kept: its bound, over all lives.

    Invariant: the kept events of one life are a run of numbers without a gap, for they are appended in
    order and forgotten oldest first.
    """

    def __init__(self, *, incarnation: int = 1, events_kept: int = HISTORY_FACTS) -> None:
        self._incarnation = incarnation
        self._memory: dict[str, Note] = {}
        self._events: deque[Event] = deque(maxlen=events_kept)
        self._lost = ""

    @property
    def incarnation(self) -> int:
        """See `dray.ports.Journal`."""
        return self._incarnation

    @property
    def memory(self) -> Memory:
        """See `dray.ports.Journal`: the same as a disk would give back, so only serialisable content."""
        return _READ.decode(msgspec.json.encode(self._memory))

    @property
    def lost(self) -> str:
        """See `dray.ports.Journal`."""
        return self._lost

    def lose(self, reason: str) -> None:
        """Lose all content for the agent's next life, as when its disk has failed."""
        self._memory = {}
        self._events.clear()
        self._lost = reason

    def begin_life(self) -> None:
        """The agent is started once more."""
        self._incarnation += 1

    def write(self, events: Sequence[Event], changes: Changes) -> None:
        """See `dray.ports.Journal`."""
        self._events.extend(events)
        if events:
            self._lost = ""
        for name, note in changes.items():
            if note is None:
                self._memory.pop(name, None)
            else:
                self._memory[name] = note

    def kept(self, incarnation: int) -> tuple[int, int]:
        """See `dray.ports.Journal`."""
        numbers = [event.number for event in self._events if event.incarnation == incarnation]
        return (numbers[0], numbers[-1]) if numbers else (1, 0)

    def earlier(self, before: int, most: int) -> list[tuple[int, int, int]]:
        """See `dray.ports.Journal`."""
        lives = sorted({event.incarnation for event in self._events if event.incarnation < before})
        return [(life, *self.kept(life)) for life in lives[-most:]]

    def events(self, incarnation: int, first: int, last: int) -> list[Event]:
        """See `dray.ports.Journal`."""
        return [
            event
            for event in self._events
            if event.incarnation == incarnation and first <= event.number <= last
        ]
