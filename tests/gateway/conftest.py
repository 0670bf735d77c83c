"""A running gateway per test on a database of its own, and the helper module beside it."""

from __future__ import annotations

import asyncio
import shutil
import sys
from collections.abc import AsyncIterator
from pathlib import Path

import pytest

from dray.store import open_store

sys.path.insert(0, str(Path(__file__).parent))

from gateway_kit import House, database_url, gateway


@pytest.fixture
def anyio_backend() -> str:
    return "asyncio"


@pytest.fixture(scope="session")
def empty_database(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A file with all tables and no rows: copying it is quicker than making its tables anew."""
    folder = tmp_path_factory.mktemp("empty")

    async def make() -> None:
        await (await open_store(database_url(folder))).close()

    asyncio.run(make())
    return folder / "dray.db"


@pytest.fixture
def url(empty_database: Path, tmp_path: Path) -> str:
    """The address of an empty database."""
    shutil.copy(empty_database, tmp_path / "dray.db")
    return database_url(tmp_path)


@pytest.fixture
async def house(url: str) -> AsyncIterator[House]:
    """A running gateway, with nobody else on the bus."""
    async with gateway(url) as house:
        yield house
