"""A factory whose invariants are watched."""

from __future__ import annotations

import pytest
from watched import Watched


@pytest.fixture
def watched() -> Watched:
    return Watched()
