"""What only a journal on a disk has to bear: a process that is killed, and a file that is not what it should be."""

from __future__ import annotations

import contextlib
import signal
import subprocess
import sys
import time
from contextlib import closing
from pathlib import Path
from random import Random

import pytest

from dray.adapters.journal.quarantine import KEPT
from dray.adapters.journal.sqlite_journal import SqliteJournal, read_events
from dray.errors import UnavailableError
from dray.memory import WHOLE, AtvMemory
from dray.messages import Event
from dray.messages.fact import OrderFulfilled

KILLED = """
import sys
from pathlib import Path
from dray.adapters.journal.sqlite_journal import SqliteJournal
from dray.memory import AtvMemory
from dray.messages import Event
from dray.messages.fact import OrderFulfilled

journal = SqliteJournal(Path(sys.argv[1]), events_kept=1000)
number = 0
while True:
    number += 1
    journal.write([Event("A", 1, number, 0.0, OrderFulfilled("O"))], {"": AtvMemory(speed_frac=number / 1e6)})
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
        assert journal.memory == {WHOLE: AtvMemory(speed_frac=last / 1e6)}


def test_a_folder_in_the_place_of_a_journal_is_named(tmp_path: Path) -> None:
    file = tmp_path / "journal.db"
    file.mkdir()
    for read in (lambda: SqliteJournal(file, events_kept=10), lambda: read_events(file)):
        with pytest.raises(UnavailableError, match=rf"the journal {file}: .*move the file away"):
            read()


def test_a_folder_in_the_place_of_the_number_of_lives_is_named(tmp_path: Path) -> None:
    (tmp_path / "journal.lives").mkdir()
    with pytest.raises(UnavailableError, match=rf"the journal {tmp_path / 'journal.db'}: Is a directory"):
        SqliteJournal(tmp_path / "journal.db")


def lived(file: Path, *, events: int = 300) -> bytes:
    """A journal that has seen two lives; what is in its file."""
    for life in (1, 2):
        with closing(SqliteJournal(file)) as journal:
            journal.write(
                [
                    Event(file.stem, life, number, 0.0, OrderFulfilled(f"O{number}"))
                    for number in range(1, events)
                ],
                {WHOLE: AtvMemory(speed_frac=0.5)},
            )
    return file.read_bytes()


def torn(whole: bytes, how: str, rng: Random) -> bytes:
    """The bytes of a file after something has happened to its disk."""
    at = rng.randrange(len(whole))
    match how:
        case "a flipped bit":
            return whole[:at] + bytes([whole[at] ^ (1 << rng.randrange(8))]) + whole[at + 1 :]
        case "random bytes":
            return whole[:at] + rng.randbytes(min(4096, len(whole) - at)) + whole[at + 4096 :]
        case "cut off":
            return whole[:at]
    return rng.randbytes(len(whole))


@pytest.mark.parametrize("how", ["a flipped bit", "random bytes", "cut off", "nothing but random bytes"])
def test_a_damaged_journal_is_moved_aside_and_its_agent_begins_a_greater_life(
    tmp_path: Path, how: str
) -> None:
    file, rng = tmp_path / "ATV1.db", Random(how)
    whole = lived(file)
    damaged = 0
    for attempt in range(30):
        for each in tmp_path.glob("ATV1.db*"):
            each.unlink()
        file.write_bytes(torn(whole, how, rng))
        (tmp_path / "ATV1.lives").write_text("2 1ad5be0d\n")
        with closing(SqliteJournal(file)) as journal:
            assert journal.incarnation == 3, attempt
            if journal.lost:
                damaged += 1
                # Of a file that was cut off at its first byte there is nothing to be kept.
                assert list(tmp_path.glob("ATV1.db.damaged-*")) or "not there" in journal.lost
                assert journal.memory == {}
                assert journal.kept(2) == (1, 0)
            else:
                assert journal.memory == {WHOLE: AtvMemory(speed_frac=0.5)}
                assert [event.number for event in journal.events(2, 1, 300)] == list(range(1, 300))
            journal.write([Event("ATV1", 3, 1, 0.0, OrderFulfilled("O"))], {WHOLE: AtvMemory()})
        with closing(SqliteJournal(file)) as journal:
            assert (journal.incarnation, journal.lost, journal.memory) == (4, "", {WHOLE: AtvMemory()})
    # Some bits of a file mean nothing: unused room in its pages, say.
    assert damaged > 10


def test_an_old_copy_that_was_put_back_is_no_memory(tmp_path: Path) -> None:
    file = tmp_path / "ATV1.db"
    copy = lived(file)
    for _ in range(2):
        SqliteJournal(file).close()
    file.write_bytes(copy)
    with closing(SqliteJournal(file)) as journal:
        assert (journal.incarnation, journal.memory) == (5, {})
        assert "an old copy, of life 2, and its agent has had 4" in journal.lost


def test_a_journal_of_another_agent_is_left_alone_and_named(tmp_path: Path) -> None:
    mine, others = tmp_path / "ATV1.db", tmp_path / "ATV2.db"
    lived(others)
    others.rename(mine)
    for _ in range(2):
        with pytest.raises(
            UnavailableError, match=r"ATV1\.db: is that of ATV2; give it back, or move it away"
        ):
            SqliteJournal(mine)
    mine.rename(others)
    with closing(SqliteJournal(others)) as journal:
        assert (journal.incarnation, journal.memory) == (3, {WHOLE: AtvMemory(speed_frac=0.5)})


@pytest.mark.parametrize("content", ["", "17", "1\ufffd", "99 00000000", "x" * 10_000])
def test_a_torn_number_of_lives_counts_for_nothing_beside_a_whole_journal(
    tmp_path: Path, content: str
) -> None:
    file, lives = tmp_path / "ATV1.db", tmp_path / "ATV1.lives"
    lived(file)
    lives.write_text(content)
    with closing(SqliteJournal(file)) as journal:
        assert (journal.incarnation, journal.lost) == (3, "")
    assert lives.read_text() == "3 6dd28e9b\n"


def test_a_number_of_lives_never_falls_though_both_files_are_torn(tmp_path: Path) -> None:
    file, lives = tmp_path / "ATV1.db", tmp_path / "ATV1.lives"
    before_s = time.time()
    last = 0
    for attempt in range(3):
        lives.write_bytes(b"\xff\xfe")
        file.write_bytes(Random(attempt).randbytes(10_000))
        if attempt < 2:
            with closing(SqliteJournal(file)) as journal:
                assert journal.incarnation >= max(last, int(before_s))
                assert journal.lost
                last = journal.incarnation
            with closing(SqliteJournal(file)) as journal:
                assert journal.incarnation == last + 1


def test_only_the_newest_damaged_files_are_kept(tmp_path: Path) -> None:
    file = tmp_path / "ATV1.db"
    for number in range(2 * KEPT):
        content = b"%d" % number * 5000
        file.write_bytes(content)
        SqliteJournal(file).close()
        aside = sorted(each.read_bytes() for each in tmp_path.glob("ATV1.db.damaged-*"))
        assert len(aside) == min(number + 1, KEPT)
        assert content in aside
    assert not list(tmp_path.glob("*-wal"))


def test_a_write_behind_a_damaged_file_is_not_read_as_one_of_the_next(tmp_path: Path) -> None:
    file = tmp_path / "ATV1.db"
    lived(file)
    with closing(SqliteJournal(file)) as hung:
        hung.write([], {WHOLE: AtvMemory(speed_frac=0.75)})
        file.write_bytes(b"\0" * 20_000)
        with closing(SqliteJournal(file)) as journal:
            assert (journal.incarnation, journal.memory) == (4, {})
            assert journal.lost
            with contextlib.suppress(UnavailableError):
                hung.write([], {WHOLE: AtvMemory(speed_frac=0.25)})
            assert journal.memory == {}
        with closing(SqliteJournal(file)) as journal:
            assert (journal.incarnation, journal.memory) == (5, {})


def test_a_loss_is_in_the_log(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    file = tmp_path / "ATV1.db"
    file.write_bytes(b"no database at all" * 100)
    SqliteJournal(file).close()
    assert (
        f"{file} begins without its memory: it is damaged: file is not a database; it is kept as"
        in caplog.text
    )


def test_a_history_is_read_over_all_lives_and_begins_none(tmp_path: Path) -> None:
    file = tmp_path / "journal.db"
    told = [Event("A", life, number, 0.0, OrderFulfilled("O")) for life in (1, 2) for number in (1, 2, 3)]
    for life in (1, 2):
        with closing(SqliteJournal(file, events_kept=5)) as journal:
            journal.write([event for event in told if event.incarnation == life], {})
    assert read_events(file) == told[1:]
    with closing(SqliteJournal(file, events_kept=5)) as journal:
        assert journal.incarnation == 3
        assert read_events(file) == told[1:]


def test_a_write_that_fails_leaves_what_was_there(tmp_path: Path) -> None:
    with closing(SqliteJournal(tmp_path / "journal.db", events_kept=10)) as journal:
        event = Event("A", 1, 1, 0.0, OrderFulfilled("O"))
        journal.write([event], {WHOLE: AtvMemory(speed_frac=0.5)})
        # A number is given once; a second event of the same number is our own bug.
        with pytest.raises(UnavailableError):
            journal.write([event], {WHOLE: AtvMemory(speed_frac=0.75)})
        assert journal.memory == {WHOLE: AtvMemory(speed_frac=0.5)}
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
            journal.write([event(1)], {})
        journal._base.execute("DROP TRIGGER full")
        journal.write([event(1)], {})
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
            journal.write([event(1)], {})
        journal._base.execute("DROP TRIGGER owe")
        journal.write([event(2)], {})
        assert journal.events(1, 1, 9) == [event(2)]
