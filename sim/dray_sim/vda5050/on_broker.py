"""A simulated vehicle behind a real broker: the messages of `Vda5050Vehicle`, by MQTT."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from dray.adapters.vda5050.link import BrokerAddress, MqttLink
from dray.plant import Plant
from dray.plant.model import VehicleType
from dray.ports import Clock
from dray_sim.bodies.vehicle.vehicle import SimVehicle
from dray_sim.vda5050.misbehaviour import Misbehaviour
from dray_sim.vda5050.vehicle import Vda5050Vehicle
from dray_sim.vda5050.words import Words

HEARD = ("order", "instantActions")


class VehicleOnBroker:
    """One vehicle.

    Args:
        body: drives, picks and drops.
        kind: of its type.
        plant: where its chargers are.
        clock: the plant's.
        broker: where it is.
        words: its version and name.

    Attributes:
        vehicle: None before the first connection to the broker.
    """

    def __init__(
        self,
        body: SimVehicle,
        kind: VehicleType,
        plant: Plant,
        clock: Clock,
        broker: BrokerAddress,
        words: Words,
    ) -> None:
        self._body, self._kind, self._clock, self._words = body, kind, clock, words
        self._chargers = {plant.node_of(charger): charger for charger in plant.chargers}
        self._corners = plant.corners
        will = json.dumps(words.connection("CONNECTIONBROKEN", clock.now_s())).encode()
        self._link = MqttLink(broker, words.prefix, f"vehicle-{words.serial}", HEARD, will)
        self.vehicle: Vda5050Vehicle | None = None

    async def run(self) -> None:
        """Speak and listen until cancelled."""
        await self._link.run(self)

    def on_link(self) -> None:
        """Say that it is there, and how it is."""
        if self.vehicle is None:
            self.vehicle = Vda5050Vehicle(
                self._body,
                self._kind,
                lambda node: self._chargers.get(node, ""),
                self._clock,
                self._publish,
                self._words,
                self._corners,
            )
        else:
            self.vehicle.introduce()

    def on_link_lost(self, reason: str) -> None:
        """Do nothing: the vehicle drives to the end of its base."""

    def on_message(self, topic: str, data: bytes) -> None:
        """Handle a message; an invalid one is ignored."""
        if self.vehicle is not None:
            self.vehicle.on_message(topic, data)

    def _publish(self, topic: str, data: bytes, retain: bool) -> None:
        self._link.publish(topic, data, retain=retain)


@asynccontextmanager
async def on_broker(vehicle: VehicleOnBroker) -> AsyncIterator[VehicleOnBroker]:
    """A vehicle that runs as long as the context lasts."""
    task = asyncio.create_task(vehicle.run())
    try:
        yield vehicle
    finally:
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)


def words_of(
    version: str, manufacturer: str, serial: str, map_id: str, quirks: Misbehaviour | None = None
) -> Words:
    """The name of one vehicle, which behaves unless it is told otherwise."""
    return Words(version, manufacturer, serial, map_id, quirks or Misbehaviour())
