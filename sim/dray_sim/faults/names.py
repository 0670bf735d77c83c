"""Agents and things that faults may name: a fault with an unknown name is an error."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from dray.errors import InputError
from dray.messages.keys import GATE, STRATEGIST
from dray.plant import Plant
from dray_sim.faults.kinds import (
    ClockSet,
    Crashed,
    DoorFailed,
    Fault,
    JournalLost,
    LaneBlocked,
    LoadDropped,
    LoadShifted,
    MachineBroken,
    PoweredOff,
    SentAway,
    VehicleBroken,
)
from dray_sim.network.coverage import access_points_of
from dray_sim.network.faults import AccessPointDown, CoverageHole, LinkTrouble, Partition, RadioCut, WlanCut

LISTENERS = ("gateway", "historian", "desk")
"""Agents that may be on the network without being of the factory: their cable can be pulled."""

SHOWN = 8
"""Names in an error message: enough to see how they look."""


class FaultError(InputError):
    """A fault that cannot be begun, or that is no fault at all.

    Attributes:
        field: where, as ``schedule[2].fault.agent``.
        reason: the error and its remedy.
    """

    def __init__(self, field: str, reason: str) -> None:
        self.field, self.reason = field, reason
        super().__init__(f"{field}: {reason}")


@dataclass(frozen=True, slots=True)
class Cast:
    """All agents and things that a fault can name, by id and in a fixed order.

    Attributes:
        vehicles, machines: agents with a body.
        others: agents of the factory whose body, if any, cannot fail: the strategist, the stations of storages, and the gate's agent.
        access_points: of the WLAN.
        lanes: by their ends, in either direction.
        doors: of the plant file.
    """

    vehicles: tuple[str, ...]
    machines: tuple[str, ...]
    others: tuple[str, ...] = (STRATEGIST,)
    access_points: tuple[str, ...] = ()
    lanes: frozenset[tuple[str, str]] = frozenset()
    doors: tuple[str, ...] = ()

    @classmethod
    def of_plant(cls, plant: Plant) -> Cast:
        """The agents and things of a plant file."""
        points = tuple(point.id for point in access_points_of(plant))
        others = (STRATEGIST, *plant.stores, GATE)
        return cls(
            tuple(plant.fleet),
            tuple(plant.machines),
            others,
            access_points=points,
            lanes=lanes_of(plant),
            doors=tuple(plant.doors),
        )

    @property
    def agents(self) -> tuple[str, ...]:
        """All agents with a process in the factory."""
        return (*self.machines, *self.vehicles, *self.others)

    def check(self, fault: Fault, where: str = "fault") -> None:
        """Check that a fault names an existing agent or thing.

        Args:
            fault: of any kind.
            where: prefix of the field in an error message.

        Raises:
            FaultError: it does not; names the field.
        """
        match fault:
            case WlanCut(agent):
                _find(agent, (*self.agents, *LISTENERS), f"{where}.agent", "agent")
            case RadioCut(agent):
                _find(agent, self.vehicles, f"{where}.agent", "vehicle")
            case PoweredOff(agent):
                _find(agent, (*self.machines, *self.vehicles), f"{where}.agent", "machine or vehicle")
            case Crashed(agent) | JournalLost(agent) | ClockSet(agent) | SentAway(agent):
                _find(agent, self.agents, f"{where}.agent", "agent of the factory")
            case MachineBroken(machine=machine):
                _find(machine, self.machines, f"{where}.machine", "machine")
            case VehicleBroken(atv=atv) | LoadShifted(atv=atv) | LoadDropped(atv=atv):
                _find(atv, self.vehicles, f"{where}.atv", "vehicle")
            case LaneBlocked(start, end):
                if (start, end) not in self.lanes:
                    reason = f"no lane leads from {start!r} to {end!r}; give two nodes that are joined by one"
                    raise FaultError(f"{where}.end", reason)
            case DoorFailed(door):
                _find(door, self.doors, f"{where}.door", "door")
            case AccessPointDown(access_point):
                _find(access_point, self.access_points, f"{where}.access_point", "access point")
            case LinkTrouble() | Partition() | CoverageHole():
                pass


def lanes_of(plant: Plant) -> frozenset[tuple[str, str]]:
    """All lanes as vehicles drive them, by their ends."""
    return frozenset((lane.start, lane.end) for lane in plant.roads.lanes)


def _find(name: str, known: Iterable[str], field: str, what: str) -> None:
    names = tuple(known)
    if name in names:
        return
    shown = ", ".join(names[:SHOWN]) + (f" and {len(names) - SHOWN} more" if len(names) > SHOWN else "")
    raise FaultError(field, f"there is no {what} {name!r}; give one of {shown or 'none: there is none'}")
