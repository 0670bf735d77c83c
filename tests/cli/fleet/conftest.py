"""What the tests of fleets share."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

from fleets import Fleet


@pytest.fixture
def fleet(tmp_path: Path) -> Iterator[Fleet]:
    """A fleet that runs."""
    started = Fleet(tmp_path)
    yield started
    if started.process.poll() is None:
        started.stop()
