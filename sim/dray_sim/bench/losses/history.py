"""The history of a fleet: all facts of all agents, each once, from wherever they are kept.

The database has the facts that the historian heard or asked for; the journals have the newest facts of the agents. An
agent journals a fact before it publishes it, so both together also have facts that a kill kept from the bus.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from itertools import groupby
from pathlib import Path

import msgspec

from dray.adapters.journal.sqlite_journal import read_events
from dray.messages import Event
from dray.messages.fact import AnyFact
from dray.store import Store
from dray.store.history.events import EventFilter, EventRow

PAGE = 1_000
"""Rows that are read at once."""

_read_fact: msgspec.json.Decoder[AnyFact] = msgspec.json.Decoder(AnyFact)


class History:
    """All that agents have told."""

    def __init__(self) -> None:
        self._events: dict[tuple[str, int, int], Event] = {}

    def add(self, events: Iterable[Event]) -> None:
        """Add events; an event that is there already stays."""
        for event in events:
            self._events.setdefault((event.agent, event.incarnation, event.number), event)

    def lacking(self, events: Iterable[Event]) -> list[str]:
        """Those of these events that are missing, in the words of `holes`."""
        lacking: dict[tuple[str, int], list[int]] = {}
        for event in events:
            if (event.agent, event.incarnation, event.number) not in self._events:
                lacking.setdefault((event.agent, event.incarnation), []).append(event.number)
        return _in_words(lacking)

    @property
    def events(self) -> list[Event]:
        """All events by time; those of one agent by their number."""
        numbered = [self._events[place] for place in sorted(self._events)]
        return sorted(numbered, key=lambda event: event.at_s)

    @property
    def holes(self) -> list[str]:
        """Gaps in the numbers of an agent's events, for example "ATV1, life 2: 7 to 9, 12"."""
        numbers: dict[tuple[str, int], set[int]] = {}
        for agent, life, number in self._events:
            numbers.setdefault((agent, life), set()).add(number)
        missing = {place: set(range(1, max(there))) - there for place, there in numbers.items()}
        return _in_words(missing)


def _in_words(numbers: Mapping[tuple[str, int], Iterable[int]]) -> list[str]:
    """Texts by agent and life; a life with no numbers is left out."""
    return [
        f"{agent}, life {life}: {', '.join(_runs(lacking))}"
        for (agent, life), each in sorted(numbers.items())
        if (lacking := sorted(each))
    ]


def _runs(numbers: Iterable[int]) -> Iterator[str]:
    """Numbers in a row in one word, as "7 to 9"."""
    for _, run in groupby(enumerate(numbers), lambda placed: placed[1] - placed[0]):
        first, *_, last = 2 * [number for _, number in run]
        yield str(first) if first == last else f"{first} to {last}"


async def read_database(store: Store) -> list[Event]:
    """All that the historian has written."""
    found: list[Event] = []
    after: int | None = None
    async with store.read() as work:
        while rows := await work.events.page(EventFilter(), after, PAGE, newest_first=False):
            found += map(_event, rows)
            after = rows[-1].position
    return found


def read_journals(folder: Path) -> list[Event]:
    """All that the journals of a folder still have."""
    return [event for file in sorted(folder.glob("*.db")) for event in read_events(file)]


def _event(row: EventRow) -> Event:
    return Event(row.agent, row.incarnation, row.number, row.plant_s, _read_fact.decode(row.fact))
