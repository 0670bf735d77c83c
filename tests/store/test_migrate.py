"""Migrations, up and down."""

from __future__ import annotations

from contextlib import suppress

import pytest
from alembic import command
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext
from alembic.script import ScriptDirectory
from history import a_day, keep, order, same_clock
from postgres_databases import SHAPE
from sqlalchemy import Connection, Inspector, inspect, text

from dray.errors import UnavailableError
from dray.store import Store, Work, downgrade, open_store, upgrade
from dray.store.access.api_keys import ApiKey
from dray.store.access.audit import AuditFilter
from dray.store.access.digest import digest
from dray.store.database.migrate import CONNECTION, configuration, migrations_folder, revisions
from dray.store.database.searching import Sought
from dray.store.history.events import EventFilter
from dray.store.orders.tracking_links import Link
from dray.store.tables import metadata

pytestmark = pytest.mark.anyio

SCRIPTS = ScriptDirectory.from_config(configuration())

NEWEST, BEFORE, *_ = (each.revision for each in SCRIPTS.walk_revisions())


def comparable(_thing: object, name: str | None, kind: str, *_rest: object) -> bool:
    """Indexes of expressions are told by each database in words of its own; `test_every_way_of_sorting_is_read_from_an_index` knows them."""
    return kind != "index" or "_by_" not in str(name)


@pytest.mark.filterwarnings("ignore:Skipped unsupported reflection of expression-based index")
@pytest.mark.filterwarnings("ignore:autogenerate skipping metadata-specified expression-based index")
async def test_the_migrations_make_the_tables_that_the_code_knows(store: Store) -> None:
    async with store.database.read() as connection:
        differences = await connection.run_sync(
            lambda sync: compare_metadata(
                MigrationContext.configure(sync, opts={"include_object": comparable}), metadata
            )
        )
    assert differences == []


async def test_all_the_way_down_leaves_nothing_and_up_again_works(store: Store) -> None:
    await downgrade(store.database, "base")
    async with store.database.read() as connection:
        left = await connection.run_sync(lambda sync: inspect(sync).get_table_names())
    assert set(left) <= {"alembic_version", "sqlite_sequence"}
    await upgrade(store.database)
    await keep(store, order())


async def test_upgrading_twice_keeps_what_is_there(store: Store) -> None:
    await keep(store, order())
    await upgrade(store.database)
    async with store.read() as work:
        assert await work.orders.get("O-1") == order()


OLDER = [each.revision for each in SCRIPTS.walk_revisions()][1:]
"""All revisions but the newest, the newest of them first."""


async def assert_it_is_all_there(work: Work, revision: str) -> None:
    """Since it was at this revision."""
    assert await work.orders.get("O-1") == order(), revision
    assert await work.orders.get("O-2") == order(2), revision
    kept = await work.events.page(EventFilter(), None, 100, newest_first=False)
    assert [row.number for row in kept] == [event.number for event in a_day()], revision
    assert await work.links.find(order().token) == Link("O-1", order().created_at_s), revision


def go_up(connection: Connection, revision: str) -> None:
    """Go up in the transaction of this connection."""
    config = configuration()
    config.attributes[CONNECTION] = connection
    command.upgrade(config, revision)


OF_SQLITE = "SELECT tbl_name, type, name, sql FROM sqlite_master ORDER BY tbl_name, type, name"

LOOKED_UP: dict[tuple[object, ...], object] = {}
"""Shapes of SQLite's tables, by what its schema says of them: most of them are the same at most revisions."""


def all_of_it(connection: Connection) -> object:
    """All tables and all rows of them, in whatever order they and their columns are."""
    looked = inspect(connection)
    tables = looked.get_table_names()
    rows = {
        table: sorted(
            str(sorted(row._mapping.items())) for row in connection.execute(text(f'SELECT * FROM "{table}"'))
        )
        for table in tables
    }
    if connection.dialect.name != "sqlite":
        return rows, connection.execute(text(SHAPE)).scalar()
    schema = [tuple(each) for each in connection.execute(text(OF_SQLITE))]
    shape = {
        table: shape_of(looked, table, tuple(each for each in schema if each[0] == table)) for table in tables
    }
    return rows, shape, [(name, sql) for _, kind, name, sql in schema if kind in ("index", "trigger")]


def shape_of(looked: Inspector, table: str, said: tuple[object, ...]) -> object:
    """Columns and constraints of a table, whose rows of the schema are these."""
    if said not in LOOKED_UP:
        LOOKED_UP[said] = [
            sorted(map(str, each))
            for each in (
                looked.get_columns(table),
                looked.get_unique_constraints(table),
                looked.get_foreign_keys(table),
                looked.get_check_constraints(table),
                looked.get_pk_constraint(table).items(),
            )
        ]
    return LOOKED_UP[said]


class TakenBackError(Exception):
    """Ends a transaction that is to leave nothing behind."""


@pytest.mark.filterwarnings("ignore:Skipped unsupported reflection of expression-based index")
async def test_down_to_any_older_dray_and_up_again_keeps_orders_and_history(
    store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It goes down by one step at a time, and each time up again. Where the first step up gives just what was there before, the way up from there has been
    gone already; else it goes all the way up from here."""
    monkeypatch.setattr(ScriptDirectory, "from_config", lambda _config: SCRIPTS)
    await keep(store, order(), order(2))
    async with store.write() as work:
        await work.links.add(order().token, Link("O-1", order().created_at_s))
        await work.events.add(a_day(), same_clock)
    newer = NEWEST
    async with store.database.read() as connection:
        above = await connection.run_sync(all_of_it)
    for revision in OLDER:
        await downgrade(store.database, revision)
        with suppress(TakenBackError):
            async with store.database.write() as connection:
                here = await connection.run_sync(all_of_it)
                await connection.run_sync(go_up, newer)
                if await connection.run_sync(all_of_it) != above:
                    await connection.run_sync(go_up, NEWEST)
                    await assert_it_is_all_there(Work(connection), revision)
                raise TakenBackError
        newer, above = revision, here


async def test_keys_of_an_older_dray_keep_working_and_get_bounds(store: Store) -> None:
    await downgrade(store.database, "0034")
    async with store.database.write() as connection:
        for name, place in (("wide", ""), ("button", "M8")):
            await connection.execute(
                text(
                    "INSERT INTO api_keys (id, name, token_hash, scopes, created_at_s, place)"
                    f" VALUES ('{name}', '{name}', '{digest(name)}', 'transports:call', 1.0, '{place}')"
                )
            )
    await upgrade(store.database)
    async with store.read() as work:
        wide, button = await work.api_keys.find("wide"), await work.api_keys.find("button")
    assert wide is not None
    assert button is not None
    assert (wide.places, wide.open_max, wide.open_each_max, wide.priority) == ("", 500, 200, "urgent")
    assert (button.places, button.open_max, button.open_each_max, button.priority) == ("M8", 50, 20, "urgent")
    async with store.write() as work:
        await work.api_keys.add(
            "cell", ApiKey(id="cell", name="cell", scopes="transports:call", created_at_s=2.0, places="M8 M9")
        )
    await downgrade(store.database, "0034")
    async with store.database.read() as connection:
        rows = await connection.execute(text("SELECT id, place FROM api_keys ORDER BY id"))
    assert [tuple(row) for row in rows] == [("button", "M8"), ("cell", "M8"), ("wide", "")]
    await upgrade(store.database)


async def test_lines_of_an_older_audit_log_are_found_by_words(store: Store) -> None:
    await downgrade(store.database, "0040")
    async with store.database.write() as connection:
        for number, who in enumerate(("Jörg", "ANA", "boss"), 1):
            await connection.execute(
                text(
                    "INSERT INTO audit (at_s, who, who_kind, from_ip, session, action, target, result, detail)"
                    f" VALUES ({number}.0, '{who}', 'person', '127.0.0.1', '', 'order.place', 'O-{number}', 'done', :detail)"
                ),
                {"detail": '{"customer":"Müller"}' if number == 2 else "{}"},
            )
    await upgrade(store.database)
    async with store.read() as work:
        for word, position in (("JÖRG", 1), ("ana", 2), ("müller", 2), ("o-3", 3)):
            [found] = await work.audit.page(AuditFilter(words=(Sought(word),)), None, 10)
            assert found.position == position


async def test_a_database_of_a_newer_dray_is_left_alone(store: Store, url: str) -> None:
    async with store.database.write() as connection:
        await connection.execute(text("UPDATE alembic_version SET version_num = '9999'"))
    with pytest.raises(UnavailableError, match="newer Dray"):
        await open_store(url)
    assert await revisions(store.database) == ("9999", NEWEST, False)


async def test_which_tables_there_are_is_told_and_changes_nothing(store: Store) -> None:
    assert await revisions(store.database) == (NEWEST, NEWEST, True)
    await downgrade(store.database, BEFORE)
    assert await revisions(store.database) == (BEFORE, NEWEST, True)
    await downgrade(store.database, "base")
    assert await revisions(store.database) == (None, NEWEST, True)


def test_the_migrations_are_found_and_have_one_head() -> None:
    assert (migrations_folder() / "env.py").is_file()
    assert ScriptDirectory.from_config(configuration()).get_current_head() == "0050"
