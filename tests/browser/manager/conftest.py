"""A running factory for each module of tests that says with which options."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import pytest


@pytest.fixture(scope="module")
def factory(request: pytest.FixtureRequest, start_dray: Callable[..., Any]) -> Iterator[str]:
    """The address of a factory that runs with what the module's `OPTIONS` say; it ends in order."""
    dray = start_dray(*request.module.OPTIONS)
    yield dray.url
    assert dray.stop() == 0, dray.output()
