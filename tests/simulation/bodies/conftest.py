"""The yard in which bodies are tried, and a vehicle in it."""

from __future__ import annotations

import pytest
from yard import Yard

from dray_sim.bodies.vehicle.vehicle import SimVehicle


@pytest.fixture
def yard() -> Yard:
    return Yard()


@pytest.fixture
def vehicle(yard: Yard) -> SimVehicle:
    return yard.vehicle()
