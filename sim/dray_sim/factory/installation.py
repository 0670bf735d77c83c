"""The parts of a simulated agent that outlive its process, and the factories of its lives and their bodies."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from dray.plant.model import VehicleSpec
from dray.ports import Body
from dray.protocol.runtime.events import Agent
from dray_sim.bodies.gate import Gate
from dray_sim.bodies.stores import Storage
from dray_sim.bodies.vehicle.vehicle import SimVehicle
from dray_sim.bodies.workcell import SimWorkcell
from dray_sim.clock.computer import ComputerClock
from dray_sim.factory.journal import HeldJournal

MakeAgent = Callable[[int, str, int], Agent]
"""Makes an agent for one life, from the number of that life, the version of its software, and the number of
transports of its probation."""


Embody = Callable[[VehicleSpec, SimVehicle, int], Body]
"""Makes the body of one life of a vehicle's agent, from the vehicle and the number of that life."""


MakeBody = Callable[[int], Body | None]
"""Makes the body of one life of an agent, from its number; None for an agent without a body."""


@dataclass(slots=True)
class Installation:
    """The parts of an agent that outlive its process.

    Attributes:
        make: its next life.
        body: makes the body of each life.
        journal: its persisted state and events.
        clock: of its computer.
        software: the version that it runs.
        newest: the next version, ready to run; empty for none.
    """

    make: MakeAgent
    body: MakeBody
    journal: HeldJournal
    clock: ComputerClock
    software: str
    newest: str = ""


def directly(_spec: VehicleSpec, vehicle: SimVehicle, _life: int) -> Body:
    """An `Embody` that puts nothing between a vehicle and its agent."""
    return vehicle


class Bodies:
    """Makes the bodies of the agents of machines, storages and the gate: one for each life of an agent, by its number.

    This class puts nothing between an agent and the simulated thing. A subclass puts controllers or people there.

    Attributes:
        has_levels: whether stations learn by the levels of controllers what lies in their storages.
    """

    has_levels = False

    def embody_machine(self, workcell: SimWorkcell, _life: int) -> Body:
        """The body of the next life of a machine's agent."""
        return workcell

    def embody_store(self, storage: Storage, _life: int) -> Body:
        """The body of the next life of a station."""
        return storage

    def embody_gate(self, gate: Gate, _life: int) -> Body:
        """The body of the next life of the gate's agent."""
        return gate


def always(body: Body | None) -> MakeBody:
    """The same for all lives."""
    return lambda _life: body
