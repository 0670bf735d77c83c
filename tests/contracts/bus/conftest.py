"""The world of each bus, one after another."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

from buses import KINDS, WORLDS, World

from dray.adapters.security.certificates import Authority


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A certificate of the plant `p` that names all agents of the tests."""
    made = tmp_path_factory.mktemp("certificates")
    authority = Authority.make("p")
    authority.write(made)
    authority.issue(made, "p", KINDS)
    return made


@pytest.fixture(params=list(WORLDS.values()), ids=list(WORLDS))
def world(request: pytest.FixtureRequest, folder: Path) -> World:
    made: World = request.param(folder)
    return made
