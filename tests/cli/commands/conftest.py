"""What the tests of commands share: a database that has all tables and no rows."""

from __future__ import annotations

import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest
from databases import Files

sys.path.insert(0, str(Path(__file__).parent))

from fake_gateway import FakeGateway


@pytest.fixture
def database(files: Files, tmp_path: Path) -> str:
    """As people write its URL."""
    return files.new(tmp_path).replace("+aiosqlite", "")


@pytest.fixture
def gateway() -> Iterator[FakeGateway]:
    with FakeGateway() as server:
        thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.01})
        thread.start()
        yield server
        server.shutdown()
        thread.join()
