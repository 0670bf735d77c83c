"""A PostgreSQL server of one's own, which may be killed."""

from __future__ import annotations

import asyncio
from pathlib import Path

import asyncpg
import pytest

from dray.adapters.processes import PROC
from dray_sim.bench.postgres import PostgresServer


async def connect(server: PostgresServer) -> asyncpg.Connection:
    return await asyncpg.connect(host="127.0.0.1", port=server.port, user="dray", database="postgres")


def test_a_killed_server_is_gone_at_once_and_has_what_was_committed_when_it_is_back(
    mortal_postgres: PostgresServer, tmp_path: Path
) -> None:
    server = mortal_postgres

    async def story() -> None:
        connection = await connect(server)
        await connection.execute("CREATE TABLE kept (it INTEGER)")
        await connection.execute("INSERT INTO kept VALUES (7)")
        port, pid = server.port, connection.get_server_pid()
        await server.kill()
        # Whoever was its parent may not have asked yet how it has ended.
        stat = PROC / str(pid) / "stat"
        assert not stat.exists() or ") Z " in stat.read_text()
        with pytest.raises((OSError, asyncpg.PostgresError, asyncpg.InterfaceError)):
            await connection.execute("SELECT 1")
        with pytest.raises(OSError, match="Connect call failed"):
            await connect(server)
        server.start()
        assert server.port == port
        connection = await connect(server)
        assert await connection.fetchval("SELECT it FROM kept") == 7
        await connection.close()

    asyncio.run(story())
    copy = tmp_path / "copy.dump"
    server.dump(copy)
    assert b"kept" in copy.read_bytes()
