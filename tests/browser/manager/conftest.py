"""A factory that all modules share whose tests fill in forms."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import pytest


@pytest.fixture(scope="session")
def forms(start_dray: Callable[..., Any]) -> Iterator[Any]:
    """A factory in which nobody orders but tests. Its time stands; a test lets it pass.

    It is for all tests that fill in forms. Each names things of its own, and leaves no order to be made.
    """
    dray = start_dray("--speed", "20", "--no-demand", stepped=True)
    # Everybody has been heard.
    dray.advance(5.0)
    yield dray
    assert dray.stop() == 0, dray.output()
