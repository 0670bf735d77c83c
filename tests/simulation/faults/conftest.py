"""A world to which faults are done, and the faults in it."""

from __future__ import annotations

import pytest
from fault_world import FakeWorld

from dray_sim.faults import Faults


@pytest.fixture
def world() -> FakeWorld:
    return FakeWorld()


@pytest.fixture
def faults(world: FakeWorld) -> Faults:
    return Faults(world)
