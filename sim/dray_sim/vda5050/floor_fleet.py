"""The vehicles of a simulated floor at a broker, for agents that are processes of their own: each speaks VDA 5050."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping

from dray.adapters.vda5050.link import BrokerAddress
from dray.adapters.vda5050.profile import load_profile
from dray.plant import Plant
from dray.ports import Clock
from dray_sim.bodies.vehicle.vehicle import SimVehicle
from dray_sim.vda5050.on_broker import VehicleOnBroker, words_of

MANUFACTURER, PROFILE = "Dray", "dray-sim"
"""Manufacturer and profile with which each vehicle's agent is started; its serial number is its id."""


async def speak_vda5050(
    plant: Plant, vehicles: Mapping[str, SimVehicle], clock: Clock, broker: BrokerAddress
) -> None:
    """Let all vehicles speak until cancelled; a broker that is away is waited for.

    Args:
        plant: the layout.
        vehicles: their bodies.
        clock: of the loop on which the bodies work.
        broker: where it is.
    """
    version = load_profile(PROFILE).version
    async with asyncio.TaskGroup() as group:
        for name, body in vehicles.items():
            kind = plant.vehicle_types[plant.fleet[name].type]
            words = words_of(version, MANUFACTURER, name, plant.id)
            group.create_task(VehicleOnBroker(body, kind, plant, clock, broker, words).run(), name=name)
