"""Opening a database, and what a commit promises."""

from __future__ import annotations

import sqlite3
from pathlib import Path

import pytest
from history import made, same_clock, tell
from sqlalchemy import text

from dray.errors import UnavailableError
from dray.store import Database, Store, open_store
from dray.store import database as database_module
from dray.store.progress import Goal

pytestmark = pytest.mark.anyio


async def test_every_connection_writes_through_and_checks_foreign_keys(store: Store) -> None:
    async with store.database.read() as connection:
        found = {
            pragma: (await connection.execute(text(f"PRAGMA {pragma}"))).scalar_one()
            for pragma in ("journal_mode", "synchronous", "foreign_keys", "busy_timeout")
        }
    assert found == {"journal_mode": "wal", "synchronous": 2, "foreign_keys": 1, "busy_timeout": 5000}


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


async def test_a_database_that_another_process_writes_to_is_not_waited_for_for_ever(
    url: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    await (await open_store(url)).close()
    monkeypatch.setattr(database_module, "BUSY_TIMEOUT_MS", 1)
    other = sqlite3.connect(tmp_path / "dray.db", isolation_level=None)
    other.execute("BEGIN IMMEDIATE")
    try:
        with pytest.raises(UnavailableError, match="another process"):
            await Database.open(url)
    finally:
        other.close()


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
