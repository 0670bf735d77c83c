"""Databases for tests: empty ones that have all tables, on SQLite and on a PostgreSQL of the tests' own.

Making the tables takes longer than most tests, so it is done once per run: a database for one test is a copy,
of a file or by PostgreSQL's own template.
"""

from __future__ import annotations

import asyncio
import shutil
from itertools import count
from pathlib import Path

import asyncpg

from dray.store import open_store
from dray_sim.bench.postgres import PostgresServer

CONFIGURATION = {
    # A test's data need not survive anything.
    "fsync": "off",
    "full_page_writes": "off",
    "max_connections": "50",
}

TEMPLATE = "empty"


def make_tables(url: str) -> None:
    """Let a database have all tables and no rows."""

    async def make() -> None:
        await (await open_store(url)).close()

    asyncio.run(make())


class Files:
    """SQLite databases.

    Args:
        home: where the empty one is made.
    """

    def __init__(self, home: Path) -> None:
        self._empty = home / "empty.db"
        make_tables(_file_url(self._empty))

    def new(self, folder: Path) -> str:
        """The URL of an empty database, `dray.db` in this folder."""
        return _file_url(Path(shutil.copy(self._empty, folder / "dray.db")))


def _file_url(path: Path) -> str:
    return f"sqlite+aiosqlite:///{path}"


class Postgres(PostgresServer):
    """A server that has an empty database for every test.

    Args:
        programs: where PostgreSQL's are.
    """

    def __init__(self, programs: Path) -> None:
        self._numbers = count(1)
        super().__init__(programs, CONFIGURATION)
        try:
            self._administer(f"CREATE DATABASE {TEMPLATE}")
            make_tables(self.url(TEMPLATE))
        except BaseException:
            self.close()
            raise

    def new(self) -> str:
        """The URL of an empty database."""
        name = f"test_{next(self._numbers)}"
        self._administer(f"CREATE DATABASE {name} TEMPLATE {TEMPLATE}")
        return self.url(name)

    def drop(self, url: str) -> None:
        """Remove a database that `new` has made, whoever still uses it."""
        self._administer(f"DROP DATABASE {url.rpartition('/')[2]} WITH (FORCE)")

    def _administer(self, command: str) -> None:
        async def administer() -> None:
            connection = await asyncpg.connect(
                host="127.0.0.1", port=self.port, user="dray", database="postgres"
            )
            try:
                await connection.execute(command)
            finally:
                await connection.close()

        asyncio.run(administer())
