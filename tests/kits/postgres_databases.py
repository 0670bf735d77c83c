"""Databases for tests on a PostgreSQL of the tests' own. Importing it imports all benchmarks, one of which has that server."""

from __future__ import annotations

import asyncio
from itertools import count
from pathlib import Path

import asyncpg
import pytest
from databases import make_tables

from dray_sim.bench.postgres import MISSING, PostgresServer, installed

CONFIGURATION = {
    # A test's data need not survive anything.
    "fsync": "off",
    "full_page_writes": "off",
    "max_connections": "50",
}

TEMPLATE = "empty"

SHUT_OUT = """
SELECT pg_terminate_backend(pid, 10000) FROM pg_stat_activity
WHERE datname = current_database() AND pid <> pg_backend_pid()
"""

SHAPE = """
SELECT md5(string_agg(line, E'\\n' ORDER BY line)) FROM (
    SELECT concat_ws(' ', table_name, column_name, data_type, column_default, is_nullable) AS line
        FROM information_schema.columns WHERE table_schema = 'public'
    UNION ALL SELECT indexdef FROM pg_indexes WHERE schemaname = 'public'
    UNION ALL SELECT concat_ws(' ', conrelid::regclass, pg_get_constraintdef(oid)) FROM pg_constraint
    UNION ALL SELECT concat_ws(' ', tgrelid::regclass, tgname) FROM pg_trigger
    UNION ALL SELECT 'version ' || version_num FROM alembic_version
    UNION ALL SELECT setconfig::text FROM pg_db_role_setting WHERE setdatabase =
        (SELECT oid FROM pg_database WHERE datname = current_database())
) AS lines
"""
"""All that a test may change beside rows."""

EMPTY = """
DO $$
DECLARE it regclass;
BEGIN
    SET LOCAL session_replication_role = replica;
    FOR it IN SELECT c.oid FROM pg_class c WHERE relnamespace = 'public'::regnamespace AND relkind = 'r'
            AND relname <> 'alembic_version' LOOP
        EXECUTE 'DELETE FROM ' || it;
    END LOOP;
    FOR it IN SELECT c.oid FROM pg_class c WHERE relnamespace = 'public'::regnamespace AND relkind = 'S' LOOP
        EXECUTE 'ALTER SEQUENCE ' || it || ' RESTART';
    END LOOP;
    INSERT INTO change_log (kind, subject, status, at_s) VALUES ('begin', '', '', 0);
END $$
"""
"""References between rows are not looked at while all rows go. The change log begins with a line, as its migration has it."""


def programs() -> Path:
    """Where PostgreSQL's are; a test that needs them is skipped where there are none."""
    found = installed()
    if found is None:
        pytest.skip(MISSING)
    return found


class Postgres(PostgresServer):
    """A server that has an empty database for every test: one that was emptied, since a new one takes ten times as long.

    Args:
        programs: where PostgreSQL's are.
    """

    def __init__(self, programs: Path) -> None:
        self._numbers = count(1)
        self._empty: list[str] = []
        super().__init__(programs, CONFIGURATION)
        try:
            self._ask("postgres", f"CREATE DATABASE {TEMPLATE}")
            make_tables(self.url(TEMPLATE))
            self._shape = self._ask(TEMPLATE, SHAPE)
        except BaseException:
            self.close()
            raise

    def new(self) -> str:
        """The URL of an empty database."""
        if self._empty:
            return self.url(self._empty.pop())
        name = f"test_{next(self._numbers)}"
        self._ask("postgres", f"CREATE DATABASE {name} TEMPLATE {TEMPLATE}")
        return self.url(name)

    def take_back(self, url: str) -> None:
        """Empty a database that `new` has made, whoever still uses it; remove it, where a test has changed its tables."""
        name = url.rpartition("/")[2]
        if self._ask(name, SHUT_OUT, SHAPE) == self._shape:
            self._ask(name, EMPTY)
            self._empty.append(name)
        else:
            self._ask("postgres", f"DROP DATABASE {name} WITH (FORCE)")

    def _ask(self, database: str, *commands: str) -> object:
        """What the last of these commands answers first."""

        async def ask() -> object:
            connection = await asyncpg.connect(
                host="127.0.0.1", port=self.port, user="dray", database=database
            )
            try:
                for command in commands[:-1]:
                    await connection.execute(command)
                return await connection.fetchval(commands[-1])
            finally:
                await connection.close()

        return asyncio.run(ask())
