"""What of a simulated agent outlives its process, and how its lives and their bodies are made."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from dray.plant.model import VehicleSpec
from dray.ports import Body
from dray.protocol.runtime.events import Agent
from dray_sim.bodies.vehicle.vehicle import SimVehicle
from dray_sim.bodies.workcell import SimWorkcell
from dray_sim.clock.computer import ComputerClock
from dray_sim.factory.journal import HeldJournal

MakeAgent = Callable[[int, str, int], Agent]
"""Makes an agent for one life, from the number of that life, the version of its software, and the transports
that it has to do well on probation."""


Embody = Callable[[VehicleSpec, SimVehicle, int], Body]
"""Makes the body of one life of a vehicle's agent, from the vehicle and the number of that life."""


MakeBody = Callable[[int], Body | None]
"""Makes the body of one life of an agent, from its number; None for one that only talks."""


@dataclass(slots=True)
class Installation:
    """What of an agent outlives its process.

    Attributes:
        make: its next life.
        body: makes what each life of it acts with.
        journal: what it has written down.
        clock: of its computer.
        software: the version that it runs.
        newest: the one that lies ready; empty for no other.
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


EmbodyMachine = Callable[[SimWorkcell, int], Body]
"""Makes the body of one life of a machine's agent, from the workcell and the number of that life."""


def itself(workcell: SimWorkcell, _life: int) -> Body:
    """An `EmbodyMachine` that puts nothing between a workcell and its agent."""
    return workcell


def always(body: Body | None) -> MakeBody:
    """The same for all lives."""
    return lambda _life: body
