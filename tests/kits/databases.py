"""Databases for tests: empty ones that have all tables, on SQLite; `postgres_databases` has those on PostgreSQL.

Making the tables takes longer than most tests, so it is done once per run: a database for one test is a copy,
of a file or by PostgreSQL's own template.
"""

from __future__ import annotations

import asyncio
import shutil
from pathlib import Path

from dray.store import open_store


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
