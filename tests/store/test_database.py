"""Opening a database, and what a commit promises."""

from __future__ import annotations

import asyncio
import stat
import threading
from pathlib import Path
from random import Random

import pytest
from history import made, same_clock, tell
from postgres_databases import Postgres
from sqlalchemy import Connection, text, update

from dray.errors import UnavailableError
from dray.store import Database, Store, open_store
from dray.store.database import dialect
from dray.store.orders.progress import Goal
from dray.store.tables import incarnations

pytestmark = pytest.mark.anyio


async def settings(url: str, names: dict[str, str]) -> dict[str, object]:
    """What a connection that reads is asked, by a name for each question."""
    store = await open_store(url)
    try:
        async with store.database.read() as connection:
            return {
                name: (await connection.execute(text(question))).scalar_one()
                for name, question in names.items()
            }
    finally:
        await store.close()


async def test_sqlite_writes_through_and_checks_foreign_keys(sqlite_url: str) -> None:
    names = ("journal_mode", "synchronous", "foreign_keys", "busy_timeout")
    assert await settings(sqlite_url, {name: f"PRAGMA {name}" for name in names}) == {
        "journal_mode": "wal",
        "synchronous": 2,
        "foreign_keys": 1,
        "busy_timeout": 5000,
    }


async def test_no_thread_answers_once_it_is_closed_wherever_a_reader_was_cancelled(sqlite_url: str) -> None:
    others = set(threading.enumerate())
    store = await open_store(sqlite_url)

    async def read() -> None:
        async with store.read() as reading:
            await reading.ping()

    for turns in range(40):
        reader = asyncio.create_task(read())
        for _ in range(turns):
            await asyncio.sleep(0)
        reader.cancel()
        await asyncio.gather(reader, return_exceptions=True)
    await store.close()
    left = set(threading.enumerate()) - others
    assert not [thread.name for thread in left if "_connection_worker_thread" in thread.name]


async def test_a_cancelled_writer_with_a_cursor_that_is_half_read_leaves_its_turn_to_others(
    sqlite_url: str,
) -> None:
    store = await open_store(sqlite_url)
    held: list[object] = []
    written = asyncio.Event()

    async def write() -> None:
        async with store.database.write() as connection:
            driver = (await connection.get_raw_connection()).driver_connection
            held.append(
                await driver.execute("INSERT INTO incarnations (plant, incarnation) VALUES ('plant', 7)")
            )
            held.append(await driver.execute("SELECT name FROM sqlite_schema"))
            written.set()
            await connection.execute(text("SELECT 1 FROM incarnations"))
            await asyncio.Event().wait()

    writer = asyncio.create_task(write())
    await asyncio.wait_for(written.wait(), 60)
    writer.cancel()
    await asyncio.wait([writer])
    assert await store.next_incarnation("plant") == 1
    assert held
    await store.close()


def modes(folder: Path) -> dict[str, int]:
    """Who may do what with the files of a folder, by their names."""
    return {file.name: stat.S_IMODE(file.stat().st_mode) for file in folder.iterdir()}


async def test_nobody_else_may_read_a_file_that_holds_the_key_for_commands(tmp_path: Path) -> None:
    store = await open_store(f"sqlite+aiosqlite:///{tmp_path / 'new.db'}")
    try:
        found = modes(tmp_path)
    finally:
        await store.close()
    assert found == dict.fromkeys(("new.db", "new.db-wal", "new.db-shm"), 0o600)


async def test_postgresql_writes_through_and_readers_cannot_write(postgresql_url: str) -> None:
    names = ("synchronous_commit", "lock_timeout", "transaction_isolation", "transaction_read_only")
    assert await settings(postgresql_url, {name: f"SHOW {name}" for name in names}) == {
        "synchronous_commit": "on",
        "lock_timeout": "5s",
        "transaction_isolation": "repeatable read",
        "transaction_read_only": "on",
    }


async def test_a_write_that_raises_is_undone(store: Store) -> None:
    async def half_a_write() -> None:
        async with store.write() as work:
            await work.incarnations.next("plant")
            raise RuntimeError

    with pytest.raises(RuntimeError):
        await half_a_write()
    assert await store.next_incarnation("plant") == 1


async def test_a_reader_does_not_wait_for_a_writer(store: Store) -> None:
    async with store.write() as writing:
        await writing.incarnations.next("plant")
        async with store.read() as reading:
            await reading.ping()


async def test_a_reader_sees_one_moment_whatever_is_written_meanwhile(store: Store) -> None:
    async with store.read() as reading:
        assert await reading.events.known() == []
        async with store.write() as writing:
            await writing.events.add(tell("M1", made("G1", 1)), same_clock)
        assert await reading.events.known() == []
    async with store.read() as reading:
        assert [life.agent for life in await reading.events.known()] == ["M1"]


async def test_writers_of_two_processes_take_turns(url: str) -> None:
    one, other = await open_store(url), await open_store(url)
    given = await asyncio.gather(*(store.next_incarnation("plant") for store in (one, other) * 10))
    await one.close()
    await other.close()
    assert sorted(given) == list(range(1, 21))


def count_one(connection: Connection) -> None:
    """As `next_incarnation`, in one piece."""
    connection.execute(update(incarnations).values(incarnation=incarnations.c.incarnation + 1))


async def test_a_transaction_in_one_piece_takes_its_turn_among_others(url: str) -> None:
    one, other = await open_store(url), await open_store(url)
    await one.next_incarnation("plant")
    await asyncio.gather(
        *(store.database.do(count_one) for store in (one, other) * 10),
        *(store.next_incarnation("plant") for store in (one, other) * 10),
    )
    assert await one.next_incarnation("plant") == 42
    await one.close()
    await other.close()


async def test_a_transaction_in_one_piece_that_raises_is_undone_and_the_next_is_not(store: Store) -> None:
    def raises(connection: Connection) -> None:
        count_one(connection)
        raise KeyError("a bug")

    await store.next_incarnation("plant")
    with pytest.raises(KeyError):
        await store.database.do(raises)
    await store.database.do(count_one)
    assert await store.next_incarnation("plant") == 3


async def test_a_transaction_in_one_piece_that_is_cancelled_leaves_its_turn_to_others(store: Store) -> None:
    await store.next_incarnation("plant")
    for turns in range(6):
        await store.database.do(count_one)
        doing = asyncio.create_task(store.database.do(count_one))
        for _ in range(turns):
            await asyncio.sleep(0)
        doing.cancel()
        await asyncio.wait([doing])
    before = await store.next_incarnation("plant")
    assert before >= 8, "what had ended before"
    await store.database.do(count_one)
    assert await store.next_incarnation("plant") == before + 2


def _text_file(folder: Path) -> Path:
    path = folder / "notes.txt"
    path.write_text("this is no database at all, and long enough to have a header\n" * 20)
    return path


@pytest.mark.parametrize(
    ("make", "names"),
    [
        (lambda folder: folder / "missing" / "dray.db", "folder exists"),
        (lambda folder: folder, "folder exists"),
        (_text_file, "some other file"),
    ],
    ids=["no folder", "a folder", "some other file"],
)
async def test_a_database_that_cannot_be_used_is_named_with_a_remedy(
    tmp_path: Path, make: object, names: str
) -> None:
    path = make(tmp_path)  # type: ignore[operator]
    with pytest.raises(UnavailableError, match=names) as raised:
        await open_store(f"sqlite+aiosqlite:///{path}")
    assert str(path) in str(raised.value)
    assert "--db" in str(raised.value)


@pytest.mark.parametrize("how", ["random bytes", "random bytes in its schema", "cut off"])
async def test_a_damaged_database_works_or_is_named_with_a_remedy(tmp_path: Path, how: str) -> None:
    path, rng, complaints = tmp_path / "dray.db", Random(how), list[str]()
    url = f"sqlite+aiosqlite:///{path}"
    sound = await open_store(url)
    await sound.next_incarnation("plant")
    await sound.close()
    whole = path.read_bytes()
    for _ in range(30):
        at = rng.randrange(len(whole) if how != "random bytes in its schema" else 4096)
        path.write_bytes(whole[:at] + (b"" if how == "cut off" else rng.randbytes(4096) + whole[at + 4096 :]))
        if complaint := await _complaint(url):
            complaints.append(complaint)
    assert complaints
    for complaint in complaints:
        assert f"database {path}: " in complaint
        assert "backup" in complaint


async def _complaint(url: str) -> str:
    """What is wrong with a database by what its opening and some use of it say; empty for nothing."""
    try:
        store = await open_store(url)
        try:
            await store.next_incarnation("plant")
            async with store.read() as work:
                await work.orders.totals()
        finally:
            await store.close()
    except UnavailableError as error:
        return str(error)
    return ""


async def test_a_database_that_another_process_writes_to_is_not_waited_for_for_ever(
    store: Store, url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(dialect, "BUSY_TIMEOUT_MS", 1)
    async with store.write():
        with pytest.raises(UnavailableError, match="lock"):
            await Database.open(url)


async def test_a_server_that_is_not_there_is_named_without_its_password(postgresql_url: str) -> None:
    url = postgresql_url.replace("dray@", "dray:hunter2@").replace("/test_", "/no_test_")
    with pytest.raises(UnavailableError, match=r"does not exist.*DRAY_DATABASE_URL") as raised:
        await open_store(url)
    assert "hunter2" not in str(raised.value)
    with pytest.raises(UnavailableError, match="DRAY_DATABASE_URL"):
        await open_store("postgresql+asyncpg://dray@127.0.0.1:1/dray")


async def test_a_server_that_is_started_anew_is_used_again(postgres: Postgres, postgresql_url: str) -> None:
    store = await open_store(postgresql_url)
    assert await store.next_incarnation("plant") == 1
    await store.database.do(count_one)
    postgres.stop()
    try:
        with pytest.raises(UnavailableError):
            await store.next_incarnation("plant")
        with pytest.raises(UnavailableError):
            await store.database.do(count_one)
        with pytest.raises(UnavailableError):
            async with store.read() as work:
                await work.ping()
    finally:
        postgres.start()
    assert await store.next_incarnation("plant") == 3
    await store.database.do(count_one)
    postgres.stop()
    postgres.start()
    # That its connection has ended is nothing to be told.
    await store.database.do(count_one)
    assert await store.next_incarnation("plant") == 6
    await store.close()


async def test_an_outage_has_one_line_in_the_log_and_its_end_another_however_many_ask_in_vain(
    postgres: Postgres, postgresql_url: str, caplog: pytest.LogCaptureFixture
) -> None:
    store = await open_store(postgresql_url)
    postgres.stop()
    try:
        for _ in range(5):
            with pytest.raises(UnavailableError):
                await store.next_incarnation("plant")
        assert [record.levelname for record in caplog.records] == ["WARNING"]
        assert "cannot be written" in caplog.text
    finally:
        postgres.start()
    await store.next_incarnation("plant")
    await store.next_incarnation("plant")
    await store.close()
    _, ended = caplog.records
    assert "can be written again" in ended.getMessage()
    assert "5 asked in vain" in ended.getMessage()


async def test_incarnations_grow_over_restarts(url: str) -> None:
    given = []
    for _ in range(3):
        store = await open_store(url)
        given += [await store.next_incarnation("plant"), await store.next_incarnation("other")]
        await store.close()
    assert given == [1, 1, 2, 2, 3, 3]


async def test_a_start_goes_on_after_the_lives_that_agents_had_by_themselves(store: Store) -> None:
    assert await store.next_incarnation("plant") == 1
    async with store.write() as work:
        await work.events.add(tell("M1", made("G1", 1), life=4), same_clock)
    assert await store.next_incarnation("plant") == 5
    async with store.write() as work:
        await work.goals.put([Goal("G2", incarnation=9)])
    assert await store.next_incarnation("plant") == 10
