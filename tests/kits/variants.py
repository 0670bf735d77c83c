"""What is tried in several ways: one of them in `make test`, the others in `make test-long`."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import pytest


def later(*ways: tuple[Any, ...]) -> list[Any]:
    """Parameters of a test, each with several values, that are left to `make test-long`."""
    return [pytest.param(*way, marks=pytest.mark.slow) for way in ways]


def variants(ways: Iterable[Any], *quick: Any) -> list[Any]:
    """Parameters of a test.

    Args:
        ways: all of them.
        quick: those that are in `make test`; the first one where none is named.
    """
    every = list(ways)
    chosen = quick or (every[0],)
    assert all(way in every for way in chosen), "there is no such way"
    return [way if way in chosen else pytest.param(way, marks=pytest.mark.slow) for way in every]
