"""What the tests of commands share: a database that has all tables and no rows."""

from __future__ import annotations

from pathlib import Path

import pytest
from databases import Files


@pytest.fixture
def database(files: Files, tmp_path: Path) -> str:
    """As people write its URL."""
    return files.new(tmp_path).replace("+aiosqlite", "")
