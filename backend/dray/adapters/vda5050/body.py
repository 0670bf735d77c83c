"""The port `dray.ports.Body` for a vehicle with VDA 5050: it runs the master on a clock and a link."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from datetime import UTC, datetime
from typing import Any, Protocol

import msgspec

from dray.adapters.vda5050.control.master import MasterControl
from dray.adapters.vda5050.events import (
    Cancel,
    Effect,
    Event,
    Heard,
    Instructed,
    Linked,
    Memory,
    Note,
    Remember,
    Say,
    Tell,
    Unlinked,
    Woke,
    kind_of,
)
from dray.adapters.vda5050.profile import Profile
from dray.body import Instruction, Report, UnplacedVehicle, VehicleInstruction, VehicleState, bounded
from dray.ports import Clock, nobody_hears
from dray.supervision import Failures

HEARD = ("state", "visualization", "connection", "factsheet")
"""The vehicle's topics that its master subscribes to."""


class Address(msgspec.Struct, frozen=True):
    """A vehicle's address in topics."""

    manufacturer: str
    serial: str


class World(Protocol):
    """The surroundings of the body, beside its clock."""

    def publish(self, topic: str, data: bytes) -> None:
        """Publish to the vehicle on one of its topics (the last chunk), at most once; dropped while the broker is away."""

    def remember(self, memory: Memory) -> None:
        """Store the memory; it is durable at the return."""

    def note(self, text: str) -> None:
        """Tell people, once."""


class VehicleBody:
    """Implements `dray.ports.Body`.

    A failure of the master by our own fault is counted, logged, and reported as the vehicle's problem; the next message is served. A
    failing instruction ends its agent, as any bug of an agent does.

    Args:
        control: its master.
        profile: it names the protocol version.
        address: the vehicle's address.
        clock: the plant's.
        world: the link and the disk.
        to_wall_s: the plant's clock as unix time, for the headers of messages.

    Attributes:
        said: number of messages to the vehicle, by topic; the header contains the next number.
        control: its master.
        address: the vehicle's address.
        placed: set once the vehicle has told its place, which no report tells.
        failures: failed events, by topic of a message, or by name of another event.
        record: called with every event and its effects; by default it does nothing.
    """

    def __init__(
        self,
        control: MasterControl,
        profile: Profile,
        address: Address,
        clock: Clock,
        world: World,
        to_wall_s: Callable[[float], float] = lambda plant_s: plant_s,
    ) -> None:
        self.control = control
        self._version, self.address = profile.dialect.version, address
        self.failures = Failures(f"{address.manufacturer}/{address.serial}")
        self.record: Callable[..., None] | None = None
        self._clock, self._world, self._to_wall_s = clock, world, to_wall_s
        self.said: dict[str, int] = {"order": 0, "instantActions": 0}
        self._report: Callable[[Report], None] = nobody_hears
        self._waiting: list[Report] = []
        self._armed_s = float("inf")
        self._is_ended = False
        self.placed = asyncio.Event()

    # --- the port --------------------------------------------------------------------------------

    def instruct(self, instruction: Instruction) -> None:
        """See `dray.ports.Body`. Instructions for a workcell are ignored: no report would fit them."""
        if isinstance(instruction, VehicleInstruction):
            self._handle(Instructed(instruction))

    def sense(self) -> VehicleState | UnplacedVehicle:
        """See `dray.ports.Body`: the last reported state."""
        control = self.control
        return bounded(control.sense() if control.is_known else UnplacedVehicle(control.why_unknown))

    def attach(self, report: Callable[[Report], None]) -> None:
        """See `dray.ports.Body`."""
        self._report = report

    # --- the link --------------------------------------------------------------------------------

    def on_message(self, topic: str, data: bytes) -> None:
        """Handle a message of the vehicle on one of its topics (the last chunk)."""
        self._handle(Heard(topic, data))

    def on_link(self) -> None:
        """The broker is connected."""
        self._handle(Linked())

    def on_link_lost(self, reason: str) -> None:
        """The connection to the broker is lost."""
        self._handle(Unlinked(reason))

    def cancel(self) -> None:
        """Cancel the order that the vehicle has: for commissioning."""
        self._handle(Cancel())

    def end(self) -> None:
        """Ignore all later events."""
        self._is_ended = True

    # --- how it is done --------------------------------------------------------------------------

    def _handle(self, event: Event) -> None:
        if self._is_ended:
            return
        now_s = self._clock.now_s()
        effects = self._effects(event, now_s)
        if self.control.is_known:
            self.placed.set()
        if self.record is not None:
            self.record(now_s, event, *effects)
        for effect in effects:
            match effect:
                case Say(topic, body):
                    self._world.publish(topic, msgspec.json.encode(self._header(topic) | body))
                case Tell(report):
                    self._waiting.append(report)
                case Remember(memory):
                    self._world.remember(memory)
                case Note(text):
                    self._world.note(text)
        if self._waiting:
            self._clock.call_at(self._clock.now_s(), self._flush)
        self._arm()

    def _effects(self, event: Event, now_s: float) -> list[Effect]:
        try:
            return self.control.handle(event, now_s)
        except Exception:
            if isinstance(event, Instructed):
                raise
            self.failures.note(kind_of(event))
            return self.control.fail(event, now_s)

    def _header(self, topic: str) -> dict[str, Any]:
        number = self.said[topic]
        self.said[topic] += 1
        moment = datetime.fromtimestamp(self._to_wall_s(self._clock.now_s()), UTC)
        return {
            "headerId": number,
            "timestamp": moment.isoformat(timespec="milliseconds").replace("+00:00", "Z"),
            "version": self._version,
            "manufacturer": self.address.manufacturer,
            "serialNumber": self.address.serial,
        }

    def _flush(self) -> None:
        """Send the waiting reports, but never inside an instruction."""
        while self._waiting:
            self._report(bounded(self._waiting.pop(0)))

    def _arm(self) -> None:
        wake_s = self.control.wake_at_s
        if wake_s < self._armed_s:
            self._armed_s = wake_s
            self._clock.call_at(wake_s, self._wake)

    def _wake(self) -> None:
        now_s = self._clock.now_s()
        if now_s < self._armed_s:
            return  # This call was replaced by an earlier one.
        self._armed_s = float("inf")
        if now_s >= self.control.wake_at_s:
            self._handle(Woke())
        elif not self._is_ended:
            self._arm()
