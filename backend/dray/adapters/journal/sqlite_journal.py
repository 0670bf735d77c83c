"""An agent's journal in service: a small SQLite file of its own on the agent's computer.

Opening it begins a life. Every write is on the disk when it returns, and is atomic even when the power fails in the
middle.

A file with flipped bytes, half a file, or a restored older copy is worse than none: the agent would follow outdated
commitments. So a journal is checked completely when it is opened. A damaged one is moved aside; the agent starts without
it, as after a loss, and reports that.
"""

from __future__ import annotations

import logging
import sqlite3
import time
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, closing, contextmanager
from pathlib import Path
from zlib import crc32

import msgspec

from dray.adapters.journal.lives import Lives
from dray.adapters.journal.quarantine import set_aside
from dray.errors import UnavailableError
from dray.memory import Changes, Memory, Note
from dray.messages import Event
from dray.messages.history import HISTORY_KEPT

BUSY_S = 5.0
"""Longest wait for another process that has the file open: a backup, or this agent's last life as it ends."""

LAYOUT = 1
"""The version of the tables."""

_TABLES = f"""
CREATE TABLE IF NOT EXISTS life (
    only INTEGER PRIMARY KEY CHECK (only = 1),
    agent TEXT NOT NULL,
    incarnation INTEGER NOT NULL,
    lost TEXT NOT NULL,
    checksum INTEGER NOT NULL
) STRICT;
CREATE TABLE IF NOT EXISTS note (
    place INTEGER PRIMARY KEY,
    name TEXT NOT NULL UNIQUE,
    line BLOB NOT NULL,
    checksum INTEGER NOT NULL
) STRICT;
CREATE TABLE IF NOT EXISTS event (
    place INTEGER PRIMARY KEY AUTOINCREMENT,
    incarnation INTEGER NOT NULL,
    number INTEGER NOT NULL,
    line BLOB NOT NULL,
    checksum INTEGER NOT NULL,
    UNIQUE (incarnation, number)
) STRICT;
PRAGMA user_version = {LAYOUT};
"""

_encode = msgspec.json.Encoder().encode
_read_note: msgspec.json.Decoder[Note] = msgspec.json.Decoder(Note)
_read_event = msgspec.json.Decoder(Event)

_log = logging.getLogger(__name__)


def read_events(file: Path) -> list[Event]:
    """All events still in a journal, in order; begins no life.

    Raises:
        UnavailableError: the file cannot be read, or is no journal.
    """
    with _told(file), closing(sqlite3.connect(f"file:{file}?mode=ro", uri=True, timeout=BUSY_S)) as base:
        rows = base.execute("SELECT line FROM event ORDER BY place")
        return [_read_event.decode(line) for (line,) in rows]


def read_memory(file: Path) -> dict[str, Note]:
    """The notes in a journal, by name; begins no life.

    Raises:
        UnavailableError: the file cannot be read, or is no journal.
    """
    with _told(file), closing(sqlite3.connect(f"file:{file}?mode=ro", uri=True, timeout=BUSY_S)) as base:
        return {name: _read_note.decode(line) for name, line in base.execute("SELECT name, line FROM note")}


class SqliteJournal:
    """Implements `dray.ports.Journal`.

    Args:
        file: created when missing; named after its agent. `lives` counts beside it.
        events_kept: maximum number of events, over all lives.

    Attributes:
        writes: number of writes in this life.
        writing_s: total duration of the writes.

    Raises:
        UnavailableError: the file cannot be read or written, or belongs to another agent; also from every write.
    """

    def __init__(self, file: Path, *, events_kept: int = HISTORY_KEPT) -> None:
        self._file, self._events_kept = file, events_kept
        self.writes = 0
        self.writing_s = 0.0
        with self._told():
            file.parent.mkdir(parents=True, exist_ok=True)
            lives = Lives(file.with_suffix(".lives"))
            lost = ""
            try:
                self._base = _open(file, lives.count)
            except _Damaged as damage:
                lost = f"{damage}; it is kept as {set_aside(file).name}"
                self._base = _open(file, lives.count)
            try:
                self._begin_life(lives, lost)
            except BaseException:
                self._base.close()
                raise
        if self._lost:
            _log.error("%s begins without its memory: %s", file, self._lost)

    def _begin_life(self, lives: Lives, lost: str) -> None:
        with self._transaction():
            known = self._base.execute("SELECT agent, incarnation, lost FROM life").fetchone()
            agent, last, untold = known or (self._file.stem, 0, "")
            if agent != self._file.stem:
                raise UnavailableError(
                    f"the journal {self._file}",
                    f"is that of {agent}",
                    f"give it back, or move it away: {self._file.stem} then begins without a memory",
                )
            life = lives.next(last)
            if not known and not lost and lives.count != 0:
                lost = "it is not there, though its agent has lived before"
            self._incarnation, self._lost = life, lost or untold
            self._base.execute(
                "INSERT OR REPLACE INTO life VALUES (1, ?, ?, ?, ?)",
                (agent, life, self._lost, _checksum(f"{agent} {life} {self._lost}".encode())),
            )
        # The journal's count is never lower than the one beside it: a lower count means an old copy.
        with self._transaction():
            (life,) = self._base.execute("SELECT incarnation FROM life").fetchone()
            lives.write(life)

    @property
    def incarnation(self) -> int:
        """See `dray.ports.Journal`."""
        return self._incarnation

    @property
    def lost(self) -> str:
        """See `dray.ports.Journal`."""
        return self._lost

    @property
    def memory(self) -> Memory:
        """See `dray.ports.Journal`."""
        with self._told():
            return _memory_in(self._base)

    def write(self, events: Sequence[Event], changes: Changes) -> None:
        """See `dray.ports.Journal`."""
        began_s = time.perf_counter()
        rows = [_event_row(event) for event in events]
        with self._told(), self._transaction():
            if rows:
                self._base.executemany(
                    "INSERT INTO event (incarnation, number, line, checksum) VALUES (?, ?, ?, ?)", rows
                )
                self._base.execute(
                    "DELETE FROM event WHERE place <= (SELECT max(place) FROM event) - ?",
                    (self._events_kept,),
                )
                self._note_reported()
            for name, note in changes.items():
                self._write_note(name, note)
        self.writes += 1
        self.writing_s += time.perf_counter() - began_s

    def kept(self, incarnation: int) -> tuple[int, int]:
        """See `dray.ports.Journal`."""
        with self._told():
            first, last = self._base.execute(
                "SELECT min(number), max(number) FROM event WHERE incarnation = ?", (incarnation,)
            ).fetchone()
        return (1, 0) if first is None else (first, last)

    def earlier(self, before: int, most: int) -> list[tuple[int, int, int]]:
        """See `dray.ports.Journal`."""
        with self._told():
            rows = self._base.execute(
                "SELECT incarnation, min(number), max(number) FROM event WHERE incarnation < ?"
                " GROUP BY incarnation ORDER BY incarnation DESC LIMIT ?",
                (before, most),
            )
            return list(rows)[::-1]

    def events(self, incarnation: int, first: int, last: int) -> list[Event]:
        """See `dray.ports.Journal`."""
        with self._told():
            rows = self._base.execute(
                "SELECT line FROM event WHERE incarnation = ? AND number BETWEEN ? AND ? ORDER BY number",
                (incarnation, first, last),
            )
            return [_read_event.decode(line) for (line,) in rows]

    def forget(self) -> None:
        """Delete the memory, and keep the history: the agent's commitments are void."""
        with self._told():
            self._base.execute("DELETE FROM note")

    def close(self) -> None:
        """Close the file. Twice is harmless."""
        self._base.close()

    def _write_note(self, name: str, note: Note | None) -> None:
        if note is None:
            self._base.execute("DELETE FROM note WHERE name = ?", (name,))
            return
        line = _encode(note)
        self._base.execute(
            "INSERT INTO note (name, line, checksum) VALUES (?, ?, ?) "
            "ON CONFLICT (name) DO UPDATE SET line = excluded.line, checksum = excluded.checksum",
            (name, line, _checksum(name.encode() + line)),
        )

    def _note_reported(self) -> None:
        """The first events of a life report an earlier loss: no later life needs to."""
        if self._lost:
            self._lost = ""
            told = _checksum(f"{self._file.stem} {self._incarnation} ".encode())
            self._base.execute(
                "UPDATE life SET lost = '', checksum = ? WHERE incarnation = ?", (told, self._incarnation)
            )

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


class _Damaged(Exception):
    """A journal that must not be used; gives the reason."""


def _open(file: Path, lives: int | None) -> sqlite3.Connection:
    """Open a journal, create it when missing, and check it completely.

    Args:
        file: the journal.
        lives: the least number of its agent's lives; None when unknown.

    Raises:
        _Damaged: it differs from what was written.
        sqlite3.Error: it is not usable at present.
    """
    # Autocommit: transactions begin and end explicitly.
    base = sqlite3.connect(file, timeout=BUSY_S, isolation_level=None)
    try:
        base.execute("PRAGMA journal_mode = WAL")
        # The default of a WAL loses the last writes when the power fails.
        base.execute("PRAGMA synchronous = FULL")
        if base.execute("SELECT count(*) FROM sqlite_schema").fetchone() == (0,):
            base.executescript(_TABLES)
        else:
            _read_through(base, lives)
    except (TypeError, ValueError) as error:
        # Wrong types or text can make the driver itself fail on names, values and error texts.
        base.close()
        raise _Damaged("it is damaged: it holds what was never written") from error
    except sqlite3.DatabaseError as error:
        base.close()
        if getattr(error, "sqlite_errorcode", sqlite3.SQLITE_CORRUPT) & 0xFF in _DAMAGES:
            raise _Damaged(f"it is damaged: {error}") from error
        raise
    except BaseException:
        base.close()
        raise
    return base


_DAMAGES = (sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB, sqlite3.SQLITE_ERROR, sqlite3.SQLITE_MISMATCH)
"""SQLite's error codes for wrong bytes; for wrong tables it reports an SQL error."""


def _read_through(base: sqlite3.Connection, lives: int | None) -> None:
    """Check that every byte is as it was written.

    Raises:
        _Damaged: one is not.
        sqlite3.Error: reading failed.
    """
    (layout,) = base.execute("PRAGMA user_version").fetchone()
    if layout != LAYOUT:
        raise _Damaged(f"it is of another version of Dray, with layout {layout} and not {LAYOUT}")
    (found,) = base.execute("PRAGMA integrity_check(1)").fetchone()
    if found != "ok":
        raise _Damaged(f"it is damaged: {found.splitlines()[-1]}")
    lived = base.execute("SELECT agent, incarnation, lost, checksum FROM life").fetchall()
    rows = [("life", f"{agent} {last} {lost}".encode(), told) for agent, last, lost, told in lived]
    notes = base.execute("SELECT name, line, checksum FROM note")
    rows += (("note", name.encode() + line, told) for name, line, told in notes)
    events = base.execute("SELECT incarnation, number, line, checksum FROM event")
    rows += (("event", b"%d %d %s" % (life, number, line), told) for life, number, line, told in events)
    for table, line, checksum in rows:
        if _checksum(line) != checksum:
            raise _Damaged(f"it is damaged: a row of {table} is not what was written")
    if lived and lives is not None and lived[0][1] < lives:
        raise _Damaged(f"it is an old copy, of life {lived[0][1]}, and its agent has had {lives}")
    try:
        _memory_in(base)
    except msgspec.MsgspecError as error:
        raise _Damaged(f"its memory is of another version of Dray: {error}") from error


def _memory_in(base: sqlite3.Connection) -> Memory:
    notes = base.execute("SELECT name, line FROM note ORDER BY place")
    return {name: _read_note.decode(line) for name, line in notes}


def _event_row(event: Event) -> tuple[int, int, bytes, int]:
    line = _encode(event)
    checksum = _checksum(b"%d %d %s" % (event.incarnation, event.number, line))
    return event.incarnation, event.number, line, checksum


def _checksum(line: bytes) -> int:
    return crc32(line)


@contextmanager
def _told(file: Path) -> Iterator[None]:
    """Report errors of the file in our own words."""
    try:
        yield
    except (sqlite3.Error, OSError, msgspec.MsgspecError) as error:
        remedy = (
            "make room and let the agent write there, or move the file away: it then forgets its contracts. "
            "A damaged file is moved aside by the agent's next life"
        )
        reason = (isinstance(error, OSError) and error.strerror) or str(error)
        raise UnavailableError(f"the journal {file}", reason, remedy) from error
