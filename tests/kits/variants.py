"""What is tried in several ways: one of them in `make test`, the others in `make test-long`; or in `make campaign`."""

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


def in_campaigns(ways: Iterable[Any], *soon: Any) -> list[Any]:
    """Parameters of a test that takes long in every way.

    Args:
        ways: all of them; several values are a tuple.
        soon: those that are in `make test-long`; the others are left to `make campaign`.
    """
    every = list(ways)
    assert all(way in every for way in soon), "there is no such way"
    marks = {True: pytest.mark.slow, False: pytest.mark.campaign}
    return [
        pytest.param(*(way if isinstance(way, tuple) else (way,)), marks=marks[way in soon]) for way in every
    ]
