"""In which order tests run: what takes longest first, and what waits for other processes not at one time."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

HERE = Path(__file__).parent


@dataclass(frozen=True)
class Found:
    """A test, as far as its place goes."""

    path: Path


def places(*names: str) -> list[Any]:
    return [Found(HERE / f"{name}.py") for name in names]


WAITING = places(
    "adapters/zenoh/test_zenoh_bus",
    "cli/fleet/test_fleet",
    "delivery/test_service",
    "traffic/test_slow_links",
)

OTHERS = places(*(f"protocol/test_{number}" for number in range(6)))


@pytest.fixture
def ours(pytestconfig: pytest.Config) -> Any:
    """The conftest of all tests."""
    return pytestconfig.pluginmanager.get_plugin(str(HERE / "conftest.py"))


def test_what_takes_longest_begins_first(ours: Any) -> None:
    longest = places(f"simulation/scenarios/{ours.LONGEST}") * 2
    mixed = ours.mixed([*OTHERS[:3], *WAITING, *longest, *OTHERS[3:]])
    assert mixed[:2] == longest
    assert len(mixed) == len(longest) + len(WAITING) + len(OTHERS)


def test_the_longest_is_a_module_that_there_is(ours: Any) -> None:
    assert list(HERE.rglob(f"{ours.LONGEST}.py"))


def test_what_waits_stands_at_the_begin_and_in_the_middle_and_nothing_is_left_out(ours: Any) -> None:
    mixed = ours.mixed([*WAITING, *OTHERS])
    assert mixed == [*WAITING[:2], *OTHERS[:3], *WAITING[2:], *OTHERS[3:]]
    # The share of the first worker of two, and of the third of four, begins with it.
    assert mixed[len(mixed) // 2] == WAITING[2]
