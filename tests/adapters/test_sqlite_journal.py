"""What only a journal on a disk has to bear: a process that is killed, and a file that is not what it should be."""

from __future__ import annotations

import signal
import subprocess
import sys
from contextlib import closing
from pathlib import Path

import pytest

from dray.adapters.sqlite_journal import SqliteJournal, read_events
from dray.errors import UnavailableError
from dray.memory import AtvMemory
from dray.messages import Event
from dray.messages.fact import OrderFulfilled

KILLED = """
import sys
from pathlib import Path
from dray.adapters.sqlite_journal import SqliteJournal
from dray.memory import AtvMemory
from dray.messages import Event
from dray.messages.fact import OrderFulfilled

journal = SqliteJournal(Path(sys.argv[1]), events_kept=1000)
number = 0
while True:
    number += 1
    journal.write([Event("A", 1, number, 0.0, OrderFulfilled("O"))], AtvMemory(speed_frac=number / 1e6))
    print(number, flush=True)
"""


def test_what_a_killed_process_has_written_is_there_and_each_write_wholly(tmp_path: Path) -> None:
    file = tmp_path / "journal.db"
    with subprocess.Popen(
        [sys.executable, "-c", KILLED, str(file)], stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        told = [int(process.stdout.readline()) for _ in range(30)]
        process.send_signal(signal.SIGKILL)
        told += [int(line) for line in process.stdout]
    with closing(SqliteJournal(file, events_kept=1000)) as journal:
        first, last = journal.kept(1)
        assert journal.incarnation == 2
        assert (first, last) in {(1, told[-1]), (1, told[-1] + 1)}
        assert journal.memory == AtvMemory(speed_frac=last / 1e6)


@pytest.mark.parametrize("content", [b"no database at all" * 100, b""], ids=["nonsense", "a folder"])
def test_a_file_that_is_no_journal_is_named(tmp_path: Path, content: bytes) -> None:
    file = tmp_path / "journal.db"
    if content:
        file.write_bytes(content)
    else:
        file.mkdir()
    for read in (lambda: SqliteJournal(file, events_kept=10), lambda: read_events(file)):
        with pytest.raises(UnavailableError, match=rf"the journal {file}: .*move the file away"):
            read()


def test_a_history_is_read_over_all_lives_and_begins_none(tmp_path: Path) -> None:
    file = tmp_path / "journal.db"
    told = [Event("A", life, number, 0.0, OrderFulfilled("O")) for life in (1, 2) for number in (1, 2, 3)]
    for life in (1, 2):
        with closing(SqliteJournal(file, events_kept=5)) as journal:
            journal.write([event for event in told if event.incarnation == life], None)
    assert read_events(file) == told[1:]
    with closing(SqliteJournal(file, events_kept=5)) as journal:
        assert journal.incarnation == 3
        assert read_events(file) == told[1:]


def test_a_write_that_fails_leaves_what_was_there(tmp_path: Path) -> None:
    with closing(SqliteJournal(tmp_path / "journal.db", events_kept=10)) as journal:
        event = Event("A", 1, 1, 0.0, OrderFulfilled("O"))
        journal.write([event], AtvMemory(speed_frac=0.5))
        # A number is given once; a second event of the same number is our own bug.
        with pytest.raises(UnavailableError):
            journal.write([event], AtvMemory(speed_frac=0.75))
        assert journal.memory == AtvMemory(speed_frac=0.5)
        assert journal.events(1, 1, 9) == [event]


def event(number: int) -> Event:
    return Event("A", 1, number, 0.0, OrderFulfilled("O"))


def test_a_write_that_sqlite_has_taken_back_by_itself_is_told_with_its_cause(tmp_path: Path) -> None:
    with closing(SqliteJournal(tmp_path / "journal.db", events_kept=10)) as journal:
        # As it does when the disk is full.
        journal._base.execute(
            "CREATE TRIGGER full BEFORE INSERT ON event BEGIN SELECT RAISE(ROLLBACK, 'the disk is full'); END"
        )
        with pytest.raises(UnavailableError, match="the disk is full"):
            journal.write([event(1)], None)
        journal._base.execute("DROP TRIGGER full")
        journal.write([event(1)], None)
        assert journal.events(1, 1, 9) == [event(1)]


def test_a_write_that_fails_at_its_end_hinders_no_later_one(tmp_path: Path) -> None:
    with closing(SqliteJournal(tmp_path / "journal.db", events_kept=10)) as journal:
        journal._base.executescript(
            """
            PRAGMA foreign_keys = ON;
            CREATE TABLE debt (owed INTEGER REFERENCES life (only) DEFERRABLE INITIALLY DEFERRED);
            CREATE TRIGGER owe AFTER INSERT ON event BEGIN INSERT INTO debt VALUES (2); END;
            """
        )
        with pytest.raises(UnavailableError, match="FOREIGN KEY"):
            journal.write([event(1)], None)
        journal._base.execute("DROP TRIGGER owe")
        journal.write([event(2)], None)
        assert journal.events(1, 1, 9) == [event(2)]
