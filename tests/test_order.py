"""In which order tests run: long ones are dealt out and begin early, and what waits for other processes does not run at one time."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

HERE = Path(__file__).parent


@dataclass(frozen=True)
class Found:
    """A test, as far as its place goes."""

    path: Path
    number: int


def found(*modules: str, each: int = 1) -> list[Any]:
    """So many tests of each of these modules."""
    return [Found(HERE / f"{module}.py", number) for module in modules for number in range(each)]


WAITING = found(
    "adapters/zenoh/test_zenoh_bus",
    "cli/fleet/test_fleet",
    "delivery/test_service",
    "traffic/test_slow_links",
)

SHORT = found(*(f"protocol/test_{number}" for number in range(20)), each=20)

BROWSERS = found(*(f"browser/manager/test_page_{number}" for number in range(12)), each=5)


@pytest.fixture
def ours(pytestconfig: pytest.Config) -> Any:
    """The conftest of all tests."""
    return pytestconfig.pluginmanager.get_plugin(str(HERE / "conftest.py"))


def shares(order: list[Any], workers: int) -> list[list[Any]]:
    """What each worker begins with, as pytest-xdist deals tests out."""
    cuts = [len(order) * number // workers for number in range(workers + 1)]
    return [order[begin:end] for begin, end in pairwise(cuts)]


def test_the_longest_are_modules_that_there_are_and_none_of_them_waits(ours: Any) -> None:
    assert [module for module in ours.LONGEST if not (HERE / f"{module}.py").exists()] == []
    assert [module for module in ours.LONGEST if module.startswith(ours.WAITING)] == []
    assert (HERE / ours.BROWSER).is_dir()


@pytest.mark.parametrize("workers", [1, 2, 3, 4, 6])
def test_every_test_runs_once_and_those_of_a_long_module_in_a_row(ours: Any, workers: int) -> None:
    long = found(*ours.LONGEST, each=5)
    items = [*BROWSERS, *SHORT[:100], *long, *WAITING, *SHORT[100:]]
    order = ours.mixed(items, workers)
    assert sorted(order, key=items.index) == items
    for module in {each.path for each in (*long, *BROWSERS)}:
        numbers = [number for number, each in enumerate(order) if each.path == module]
        assert numbers == list(range(numbers[0], numbers[-1] + 1))
    assert [each for each in order if each in SHORT] == SHORT


@pytest.mark.parametrize("workers", [2, 4, 6])
def test_each_worker_has_as_many_long_modules_and_ends_with_short_tests(ours: Any, workers: int) -> None:
    long = found(*ours.LONGEST[:12], each=5)
    dealt = shares(ours.mixed([*BROWSERS, *SHORT, *long], workers), workers)
    assert {
        len({each.path for each in share} & {each.path for each in (*long, *BROWSERS)}) for share in dealt
    } == {24 // workers}
    assert dealt[0][: len(long) // 12] == long[:5]
    for number, share in enumerate(dealt):
        begun = next(at for at, each in enumerate(share) if each not in SHORT)
        short = sum(each in SHORT for each in share)
        assert begun == short * number // workers, "each a part later than the one before"
        assert all(each in SHORT for each in share[-(short // workers) :])


def test_what_waits_stands_at_the_begin_and_in_the_middle(ours: Any) -> None:
    order = ours.mixed([*WAITING, *SHORT], 4)
    assert order[:2] == WAITING[:2]
    # The share of the first worker of two, and of the third of four, begins with it.
    assert order[len(order) // 2 :][:2] == WAITING[2:]


def test_a_few_chosen_tests_are_all_run(ours: Any) -> None:
    few = [*found(ours.LONGEST[0], each=7), *WAITING[:1], *SHORT[:2]]
    assert sorted(ours.mixed(few, 6), key=few.index) == few
