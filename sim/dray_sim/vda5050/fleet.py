"""A simulated factory whose vehicles are behind VDA 5050, joined to their agents in memory: no broker, and time may jump."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from msgspec.structs import replace

from dray.adapters.vda5050.body import Address, VehicleBody
from dray.adapters.vda5050.control.master import MasterControl
from dray.adapters.vda5050.events import Memory
from dray.adapters.vda5050.profile import Profile
from dray.plant import Plant
from dray.plant.model import VehicleSpec
from dray.ports import Body, Clock
from dray.supervision import Failures
from dray_sim.bodies.vehicle.vehicle import SimVehicle
from dray_sim.vda5050.misbehaviour import Misbehaviour
from dray_sim.vda5050.own_map import OwnMap
from dray_sim.vda5050.vehicle import Vda5050Vehicle
from dray_sim.vda5050.words import Words

DELAY_S = 0.02
"""Transit time of a message: a broker on the vehicle's own computer."""

MANUFACTURER = "Dray"

Carry = Callable[[str, bytes, Callable[[bytes], None]], None]
"""Called with a vehicle's id, a message, and the function that delivers it."""


class MemoryFleet:
    """The vehicles of a factory, each with its master.

    Args:
        plant: the layout.
        clock: the plant's.
        profile_of: each vehicle's profile, by its id; None for a vehicle that is simulated without VDA 5050.
        quirks_of: each vehicle's misbehaviour.
        own_map_of: each vehicle's own ids and frame; None for the plant's.
        carry: brings a message of a vehicle or to it; by default each as it is, after `DELAY_S`.

    Attributes:
        vehicles: by id.
        bodies: of the present lives, by id.
        notes: the masters' messages for people.
    """

    def __init__(
        self,
        plant: Plant,
        clock: Clock,
        profile_of: Callable[[str], Profile | None],
        quirks_of: Callable[[str], Misbehaviour] = lambda _: Misbehaviour(),
        carry: Carry | None = None,
        own_map_of: Callable[[str], OwnMap | None] = lambda _: None,
    ) -> None:
        self._own_map_of = own_map_of
        self._carry = carry or self._bring
        self._plant, self._clock = plant, clock
        self._profile_of, self._quirks_of = profile_of, quirks_of
        self._chargers = {plant.node_of(charger): charger for charger in plant.chargers}
        self.vehicles: dict[str, Vda5050Vehicle] = {}
        self.bodies: dict[str, VehicleBody] = {}
        self.notes: list[str] = []
        self._memories: dict[str, Memory] = {}
        self._is_meeting = False
        """A new life is told how its vehicle is, before anything else happens."""

    def embody(self, spec: VehicleSpec, sim: SimVehicle, life: int) -> Body:
        """The body of one life of a vehicle's agent: it has heard the vehicle."""
        profile = self._profile_of(spec.id)
        if profile is None:
            return sim
        kind, address = self._plant.vehicle_types[spec.type], Address(MANUFACTURER, spec.id)
        if spec.id not in self.vehicles:
            words = Words(profile.version, MANUFACTURER, spec.id, self._plant.id, self._quirks_of(spec.id))
            self.vehicles[spec.id] = Vda5050Vehicle(
                sim,
                kind,
                lambda node: self._chargers.get(node, ""),
                self._clock,
                lambda topic, data, _retain: self._tell(spec.id, topic, data),
                words,
                self._plant.corners,
                self._own_map_of(spec.id),
            )
        else:
            self.bodies[spec.id].end()
        control = MasterControl(
            spec.id, self._plant, kind, profile, life=life, memory=self._memories.get(spec.id)
        )
        world = _World(self, spec.id)
        body = self.bodies[spec.id] = VehicleBody(control, profile, address, self._clock, world)
        body.failures = LoudFailures(spec.id)
        self._is_meeting = True
        self.vehicles[spec.id].introduce()
        self._is_meeting = False
        body.on_link()
        return body

    def _tell(self, atv: str, topic: str, data: bytes) -> None:
        if self._is_meeting:
            self.bodies[atv].on_message(topic, data)
        elif atv in self.bodies:
            self._carry(atv, data, partial(self.bodies[atv].on_message, topic))

    def say(self, atv: str, topic: str, data: bytes) -> None:
        """Deliver a master's message to its vehicle."""
        self._carry(atv, data, partial(self.vehicles[atv].on_message, topic))

    def _bring(self, _atv: str, data: bytes, hand: Callable[[bytes], None]) -> None:
        self._clock.call_at(self._clock.now_s() + DELAY_S, partial(hand, data))

    def remember(self, atv: str, memory: Memory) -> None:
        """Keep the memory for the next life."""
        self._memories[atv] = replace(memory)


class LoudFailures(Failures):
    """Failures that end the run, where it looks for our own bugs only."""

    def note(self, kind: str) -> None:
        """Raise it again."""
        super().note(kind)
        raise  # noqa: PLE0704 - it is called where an exception is handled


class _World:
    """The world of one master."""

    def __init__(self, fleet: MemoryFleet, atv: str) -> None:
        self._fleet, self._atv = fleet, atv

    def publish(self, topic: str, data: bytes) -> None:
        self._fleet.say(self._atv, topic, data)

    def remember(self, memory: Memory) -> None:
        self._fleet.remember(self._atv, memory)

    def note(self, text: str) -> None:
        self._fleet.notes.append(f"{self._atv}: {text}")
