"""What `dray plant ready` finds of a database."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Any

import pytest
from alembic.script import ScriptDirectory
from databases import Files
from ready_kit import NOW_S, seen
from sqlalchemy import text

from dray.cli.runtime.gateway.authority import authority_of
from dray.cli.runtime.ready.database import database
from dray.cli.runtime.ready.finding import Finding, Verdict
from dray.messages import MachineHeartbeat, MachineStatus
from dray.settings import Settings
from dray.store import open_store
from dray.store.database.migrate import configuration

OLDEST = list(ScriptDirectory.from_config(configuration()).walk_revisions())[-1].revision


async def in_database(url: str, now_s: float = NOW_S, **fields: Any) -> dict[str, Finding]:
    return {each.name: each async for each in database(Settings.load(database_url=url, **fields), now_s)}


@pytest.fixture
def url(files: Files, tmp_path: Path) -> str:
    return files.new(tmp_path)


@pytest.mark.anyio
async def test_a_database_that_is_not_there_is_not_made(tmp_path: Path) -> None:
    file = tmp_path / "none.db"
    found = await in_database(f"sqlite:///{file}")
    assert seen(found["database"], Verdict.MISSING, "there is no file")
    assert found["database"].todo == f"dray db upgrade --db sqlite:///{file}"
    assert not await asyncio.to_thread(file.exists)


@pytest.mark.anyio
async def test_what_is_no_database_is_said(tmp_path: Path) -> None:
    (tmp_path / "other.db").write_bytes(b"no database" * 100)
    found = await in_database(f"sqlite:///{tmp_path / 'other.db'}")
    assert seen(found["database"], Verdict.MISSING, "not a database")


@pytest.mark.anyio
async def test_a_database_of_this_version_knows_no_gateway_and_no_agent_yet(url: str) -> None:
    found = await in_database(url)
    assert seen(found["database"], Verdict.OK, "can be written")
    assert seen(found["historian"], Verdict.MISSING, "it has recorded no agent yet")
    assert seen(found["signed commands"], Verdict.MISSING, "no gateway has started")


@pytest.mark.anyio
async def test_the_key_of_the_gateway_has_to_be_one_that_agents_believe(url: str) -> None:
    store = await open_store(url)
    public = (await authority_of(store)).public.hex()
    await store.close()
    assert (await in_database(url))["signed commands"].verdict is Verdict.UNKNOWN
    trusted = await in_database(url, trusted_keys=(public.upper(),))
    assert trusted["signed commands"].verdict is Verdict.OK
    other = await in_database(url, trusted_keys=("00" * 32,))
    assert other["signed commands"].verdict is Verdict.MISSING


@pytest.mark.anyio
async def test_a_historian_that_writes_nothing_is_missing(url: str) -> None:
    store = await open_store(url)
    beat = MachineHeartbeat(machine="SAW", incarnation=1, seq=1, at_s=0.0, status=MachineStatus.IDLE)
    async with store.write() as work:
        await work.samples.add([beat], lambda s: NOW_S + s)
    await store.close()
    assert (await in_database(url, NOW_S + 290.0))["historian"].verdict is Verdict.OK
    late = (await in_database(url, NOW_S + 600.0))["historian"]
    assert seen(late, Verdict.MISSING, "for 10 min")


@pytest.mark.anyio
@pytest.mark.parametrize(
    ("revision", "said"), [(OLDEST, f"at migration {OLDEST} and not "), ("9999", "of a newer Dray")]
)
async def test_tables_of_another_version_are_told(url: str, revision: str, said: str) -> None:
    store = await open_store(url)
    async with store.database.write() as connection:
        await connection.execute(text("UPDATE alembic_version SET version_num = :it"), {"it": revision})
    await store.close()
    assert seen((await in_database(url))["database"], Verdict.MISSING, said)
