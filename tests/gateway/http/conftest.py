"""Side work of its own, and a pipe that makes a piece of it wait."""

from __future__ import annotations

import os
from collections.abc import AsyncIterator
from pathlib import Path

import pytest

from dray.gateway.http.side_work import SideWork


@pytest.fixture
async def side() -> AsyncIterator[SideWork]:
    work = SideWork()
    yield work
    await work.close()


@pytest.fixture
def pipe(tmp_path: Path) -> Path:
    """Its reader waits for a writer, and its writer for a reader."""
    path = tmp_path / "pipe"
    os.mkfifo(path)
    return path
