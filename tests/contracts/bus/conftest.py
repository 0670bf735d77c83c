"""The world of each bus, one after another."""

from __future__ import annotations

import sys
from collections.abc import Generator
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

from buses import KINDS, WORLDS, Certified, World

from dray.adapters.security.certificates import Authority


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Certificates of the plant `p`, in a folder for each session; each names all agents of the tests."""
    made = tmp_path_factory.mktemp("certificates")
    authority = Authority.make("p")
    for place in range(Certified.COUNT):
        own = made / str(place)
        authority.write(own)
        authority.issue(own, "p", KINDS)
    return made


@pytest.fixture(params=list(WORLDS.values()), ids=list(WORLDS))
def world(request: pytest.FixtureRequest, folder: Path) -> World:
    made: World = request.param(folder)
    return made


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """A test that fails tells what its bus has counted: what was refused, and what was lost on the way."""
    report = yield
    world = getattr(item, "funcargs", {}).get("world")
    if report.failed and isinstance(world, World):
        report.sections.append(("the bus", world.told()))
    return report
