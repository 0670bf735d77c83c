"""Agents and things that faults may name: a fault with an unknown name is an error."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import product

from msgspec.structs import replace

from dray.errors import InputError
from dray.messages.keys import GATE, STRATEGIST
from dray.plant import Plant
from dray.plant.layout import name_after, name_before
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
        lanes: as vehicles drive them, by their ends, in either direction.
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

    @staticmethod
    def _ends(start: str, end: str) -> Iterator[tuple[str, str]]:
        """A lane of the plant file as it may be driven: its ends are stop points where a road has two lanes."""
        return product((start, name_after(start, end)), (end, name_before(start, end)))

    def as_driven(self, fault: LaneBlocked) -> LaneBlocked:
        """A blocked lane of the plant file as the lane that vehicles drive; as it is, where there is none."""
        driven = (ends for ends in self._ends(fault.start, fault.end) if ends in self.lanes)
        start, end = next(driven, (fault.start, fault.end))
        return replace(fault, start=start, end=end)

    def _lane_advice(self, fault: LaneBlocked) -> str:
        """What to name instead of a lane that nothing can lie on."""
        stop = name_after(fault.start, fault.end)
        over = sorted(f"{start} to {end}" for start, end in self.lanes if stop in (start, end))
        if not over:
            return (
                "give two nodes that a lane of the plant file joins, in the direction in which it is driven"
            )
        return (
            f"this road is so short that vehicles stop once on it, at {stop}, and drive from there over a crossing; "
            f"give one of the lanes that meet there: {', '.join(over)}"
        )

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
            case LaneBlocked():
                lane = self.as_driven(fault)
                if (lane.start, lane.end) not in self.lanes:
                    reason = (
                        f"no lane leads from {fault.start!r} to {fault.end!r}; {self._lane_advice(fault)}"
                    )
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
