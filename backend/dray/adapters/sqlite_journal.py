"""An agent's journal in service: a small SQLite file of its own on the agent's computer.

Opening it begins a life. Every write is on the disk when it returns, and is there wholly or not at all,
also when the power fails in the middle.
"""

from __future__ import annotations

import sqlite3
import time
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, closing, contextmanager
from pathlib import Path

import msgspec

from dray.errors import UnavailableError
from dray.memory import Memory
from dray.messages import Event

BUSY_S = 5.0
"""Wait for another process that has the file open: a backup, or this agent's last life as it ends."""

EVENTS_KEPT = 10_000
"""Some 5 MB on the disk. A strategist whose machines come and go tells a thousand facts in minutes, and what
it forgets before the historian is back is gone for good."""

_TABLES = """
CREATE TABLE IF NOT EXISTS life (
    only INTEGER PRIMARY KEY CHECK (only = 1),
    incarnation INTEGER NOT NULL,
    memory BLOB
) STRICT;
CREATE TABLE IF NOT EXISTS event (
    place INTEGER PRIMARY KEY AUTOINCREMENT,
    incarnation INTEGER NOT NULL,
    number INTEGER NOT NULL,
    line BLOB NOT NULL,
    UNIQUE (incarnation, number)
) STRICT;
"""

_encode = msgspec.json.Encoder().encode
_read_memory: msgspec.json.Decoder[Memory] = msgspec.json.Decoder(Memory)
_read_event = msgspec.json.Decoder(Event)


def read_events(file: Path) -> list[Event]:
    """All that a journal still has of its agent's history, in order; begins no life.

    Raises:
        UnavailableError: the file cannot be read, or is no journal.
    """
    with _told(file), closing(sqlite3.connect(f"file:{file}?mode=ro", uri=True, timeout=BUSY_S)) as base:
        rows = base.execute("SELECT line FROM event ORDER BY place")
        return [_read_event.decode(line) for (line,) in rows]


class SqliteJournal:
    """Implements `dray.ports.Journal`.

    Args:
        file: made when it is not there.
        events_kept: its bound, over all lives.

    Attributes:
        writes: that were done in this life.
        writing_s: how long they took, all together.

    Raises:
        UnavailableError: the file cannot be read or written, or is no journal; also from every write.
    """

    def __init__(self, file: Path, *, events_kept: int = EVENTS_KEPT) -> None:
        self._file, self._events_kept = file, events_kept
        self.writes = 0
        self.writing_s = 0.0
        with self._told():
            file.parent.mkdir(parents=True, exist_ok=True)
            # Autocommit: transactions begin and end where it is written.
            self._base = sqlite3.connect(file, timeout=BUSY_S, isolation_level=None)
            self._base.execute("PRAGMA journal_mode = WAL")
            # The default of a WAL loses the last writes when the power fails.
            self._base.execute("PRAGMA synchronous = FULL")
            self._base.executescript(_TABLES)
            self._base.execute(
                "INSERT INTO life VALUES (1, 1, NULL) ON CONFLICT DO UPDATE SET incarnation = incarnation + 1"
            )
            life, memory = self._base.execute("SELECT incarnation, memory FROM life").fetchone()
            self._incarnation: int = life
            self._memory = None if memory is None else _read_memory.decode(memory)

    @property
    def incarnation(self) -> int:
        """See `dray.ports.Journal`."""
        return self._incarnation

    @property
    def memory(self) -> Memory | None:
        """See `dray.ports.Journal`."""
        return self._memory

    def write(self, events: Sequence[Event], memory: Memory | None) -> None:
        """See `dray.ports.Journal`."""
        began_s = time.perf_counter()
        lines = [(event.incarnation, event.number, _encode(event)) for event in events]
        with self._told(), self._transaction():
            self._base.executemany("INSERT INTO event (incarnation, number, line) VALUES (?, ?, ?)", lines)
            if lines:
                self._base.execute(
                    "DELETE FROM event WHERE place <= (SELECT max(place) FROM event) - ?",
                    (self._events_kept,),
                )
            if memory is not None:
                self._base.execute("UPDATE life SET memory = ?", (_encode(memory),))
        if memory is not None:
            self._memory = memory
        self.writes += 1
        self.writing_s += time.perf_counter() - began_s

    def kept(self, incarnation: int) -> tuple[int, int]:
        """See `dray.ports.Journal`."""
        with self._told():
            first, last = self._base.execute(
                "SELECT min(number), max(number) FROM event WHERE incarnation = ?", (incarnation,)
            ).fetchone()
        return (1, 0) if first is None else (first, last)

    def events(self, incarnation: int, first: int, last: int) -> list[Event]:
        """See `dray.ports.Journal`."""
        with self._told():
            rows = self._base.execute(
                "SELECT line FROM event WHERE incarnation = ? AND number BETWEEN ? AND ? ORDER BY number",
                (incarnation, first, last),
            )
            return [_read_event.decode(line) for (line,) in rows]

    def forget(self) -> None:
        """Forget the memory, and keep the history: what the agent was bound by is no more."""
        with self._told():
            self._base.execute("UPDATE life SET memory = NULL")
        self._memory = None

    def close(self) -> None:
        """Let go of the file. Twice is harmless."""
        self._base.close()

    @contextmanager
    def _transaction(self) -> Iterator[None]:
        self._base.execute("BEGIN IMMEDIATE")
        try:
            yield
            self._base.execute("COMMIT")
        except BaseException:
            # On a full disk, say, SQLite has rolled back by itself.
            if self._base.in_transaction:
                self._base.execute("ROLLBACK")
            raise

    def _told(self) -> AbstractContextManager[None]:
        return _told(self._file)


@contextmanager
def _told(file: Path) -> Iterator[None]:
    """Tell what is wrong with the file in words of ours."""
    try:
        yield
    except (sqlite3.Error, OSError, msgspec.MsgspecError) as error:
        remedy = (
            "make room and let the agent write there, or move the file away: it then forgets its contracts"
        )
        reason = (isinstance(error, OSError) and error.strerror) or str(error)
        raise UnavailableError(f"the journal {file}", reason, remedy) from error
