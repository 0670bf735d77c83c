"""The vehicles of a simulated factory behind a real broker: each speaks VDA 5050, and its agent is its master."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Coroutine

import msgspec

from dray.adapters.vda5050.body import HEARD, Address, VehicleBody
from dray.adapters.vda5050.control.master import MasterControl
from dray.adapters.vda5050.events import Memory
from dray.adapters.vda5050.link import BrokerAddress, MqttLink
from dray.adapters.vda5050.profile import Profile, load_profile
from dray.plant import Plant
from dray.plant.model import VehicleSpec
from dray.ports import Body, Clock
from dray_sim.bodies.vehicle.vehicle import SimVehicle
from dray_sim.vda5050.on_broker import VehicleOnBroker, words_of

MANUFACTURER = "Dray"

LOOK_S = 0.05

_log = logging.getLogger(__name__)


def all_versions() -> tuple[Profile, ...]:
    """One profile for each version: 3.0 with updates and a horizon, 2.1 with updates, 2.0 in steps."""
    newest = load_profile("dray-sim")
    return (
        newest,
        msgspec.structs.replace(newest, version="2.1", horizon=0),
        msgspec.structs.replace(newest, version="2.0", updates=False, horizon=0, base_m=0.0),
    )


class BrokerFleet:
    """All vehicles, and their masters.

    Args:
        plant: the layout.
        clock: of the loop that this is made on.
        broker: where it is.
        to_wall_s: the plant's clock as unix time.
        profiles: of the vehicles, by turns in the order of the fleet.

    Attributes:
        bodies: of the present lives, by vehicle.
    """

    def __init__(
        self,
        plant: Plant,
        clock: Clock,
        broker: BrokerAddress,
        to_wall_s: Callable[[float], float],
        profiles: tuple[Profile, ...] = (),
    ) -> None:
        self._plant, self._clock, self._broker, self._to_wall_s = plant, clock, broker, to_wall_s
        self._profiles = profiles or all_versions()
        self.bodies: dict[str, _Kept] = {}
        self._vehicles: dict[str, VehicleOnBroker] = {}
        self._memories: dict[str, Memory] = {}
        self._links: dict[str, asyncio.Task[None]] = {}

    def embody(self, spec: VehicleSpec, sim: SimVehicle, life: int) -> Body:
        """The body of one life of a vehicle's agent; a later life gets the vehicle's last messages."""
        kind = self._plant.vehicle_types[spec.type]
        if spec.id not in self._vehicles:
            profile = self._profiles[len(self._vehicles) % len(self._profiles)]
            words = words_of(profile.version, MANUFACTURER, spec.id, self._plant.id)
            vehicle = VehicleOnBroker(sim, kind, self._plant, self._clock, self._broker, words)
            self._vehicles[spec.id] = vehicle
            self._start(f"vehicle {spec.id}", vehicle.run())
            said: dict[str, bytes] = {}
        else:
            old = self.bodies[spec.id]
            profile, said = old.profile, old.last
            old.end()
        control = MasterControl(
            spec.id, self._plant, kind, profile, life=life, memory=self._memories.get(spec.id)
        )
        address = Address(MANUFACTURER, spec.id)
        prefix = profile.topic(MANUFACTURER, spec.id, "").rstrip("/")
        link = MqttLink(self._broker, prefix, f"dray-{spec.id}", HEARD)
        world = _World(self, spec.id, link)
        body = self.bodies[spec.id] = _Kept(control, profile, address, self._clock, world, self._to_wall_s)
        for topic, data in said.items():
            body.on_message(topic, data)
        self._start(f"master {spec.id}", link.run(body))
        return body

    async def ready(self) -> None:
        """Wait until all vehicles have reported their positions.

        Raises:
            Exception: that of an ended link, a fault of ours.
        """
        # The bodies have no common event to wait for.
        while not all(body.control.is_known for body in self.bodies.values()):
            for link in self._links.values():
                if link.done():
                    link.result()
            await asyncio.sleep(LOOK_S)

    async def end(self) -> None:
        """Leave the broker."""
        for task in self._links.values():
            task.cancel()
        await asyncio.gather(*self._links.values(), return_exceptions=True)

    def remember(self, atv: str, memory: Memory) -> None:
        """Keep the memory for the next life."""
        self._memories[atv] = memory

    def _start(self, name: str, link: Coroutine[None, None, None]) -> None:
        if name in self._links:
            self._links[name].cancel()
        task = self._links[name] = asyncio.create_task(link, name=name)
        task.add_done_callback(_tell_end)


class _Kept(VehicleBody):
    """Keeps the vehicle's last messages for the next life.

    Attributes:
        profile: of the vehicle.
        last: by topic.
    """

    def __init__(
        self,
        control: MasterControl,
        profile: Profile,
        address: Address,
        clock: Clock,
        world: _World,
        to_wall_s: Callable[[float], float],
    ) -> None:
        super().__init__(control, profile, address, clock, world, to_wall_s)
        self.profile = profile
        self.last: dict[str, bytes] = {}

    def on_message(self, topic: str, data: bytes) -> None:
        self.last[topic] = data
        super().on_message(topic, data)


class _World:
    """The world of one master."""

    def __init__(self, fleet: BrokerFleet, atv: str, link: MqttLink) -> None:
        self._fleet, self._atv, self._link = fleet, atv, link

    def publish(self, topic: str, data: bytes) -> None:
        self._link.publish(topic, data)

    def remember(self, memory: Memory) -> None:
        self._fleet.remember(self._atv, memory)

    def note(self, text: str) -> None:
        _log.warning("%s: %s", self._atv, text)


def _tell_end(task: asyncio.Task[None]) -> None:
    if not task.cancelled() and (error := task.exception()) is not None:
        _log.error("the link of %s has ended", task.get_name(), exc_info=error)
