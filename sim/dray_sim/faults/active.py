"""Faults in a running factory: begun, ended, and counted so that overlapping ones do not end each other.

Several faults may hold one thing at once: an agent without power may crash as well. A thing is restored with the end
of the last fault that took it, and repairs by a person before that are kept.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import partial
from types import MappingProxyType
from typing import Protocol

from dray.messages import Problem
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
    Thing,
    VehicleBroken,
)
from dray_sim.faults.names import Cast, FaultError
from dray_sim.faults.schedule import Timed
from dray_sim.network.faults import NetworkFault

_ENDED = (Crashed, JournalLost, SentAway)
"""Faults during which an agent's process is not there."""

PERSON_STAYS_S = 60.0
"""Longest time for which a person stands on a lane."""

MAX_ACTIVE = 1000
"""Most faults at one time: more than a plant has agents help nobody to find anything."""


class Clock(Protocol):
    """The part of a clock that `play` needs."""

    def now_s(self) -> float: ...

    def call_at(self, when_s: float, callback: Callable[[], object], /) -> None: ...


class Network(Protocol):
    """A network that can fail."""

    @property
    def access_points(self) -> tuple[str, ...]: ...

    def begin(self, fault: NetworkFault) -> None: ...

    def end(self, fault: NetworkFault) -> None: ...


class Breakable(Protocol):
    """A body that can break."""

    def break_down(self, reason: str, problem: Problem = ..., /) -> None: ...

    def repair(self) -> None: ...


class Loadable(Breakable, Protocol):
    """A vehicle's body."""

    def break_down(self, reason: str, problem: Problem = ..., /) -> None: ...

    def shift_load(self) -> bool: ...


class Openable(Protocol):
    """The doors of a floor."""

    @property
    def states(self) -> Mapping[str, object]: ...

    def fail(self, door: str, /) -> None: ...

    def repair(self, door: str, /) -> None: ...


class Drops(Protocol):
    """A floor on which vehicles lose loads, and doors fail."""

    @property
    def doors(self) -> Openable: ...

    def drop_load(self, atv: str, /) -> bool: ...


class World(Protocol):
    """A factory in which things go wrong: `dray_sim.factory.sim_factory.SimFactory` is one."""

    @property
    def clock(self) -> Clock: ...
    @property
    def bus(self) -> Network: ...
    @property
    def vehicles(self) -> Mapping[str, Loadable]: ...
    @property
    def workcells(self) -> Mapping[str, Breakable]: ...
    @property
    def workers(self) -> Mapping[str, object]: ...

    @property
    def floor(self) -> Drops: ...

    @property
    def lanes(self) -> frozenset[tuple[str, str]]: ...

    def obstruct(self, lane: tuple[str, str], thing: str) -> bool: ...
    def clear(self, lane: tuple[str, str]) -> None: ...
    def running(self, agent: str) -> bool: ...
    def power_off(self, agent: str) -> None: ...
    def power_on(self, agent: str) -> None: ...
    def crash(self, agent: str) -> None: ...
    def lose_journal(self, agent: str) -> None: ...
    def set_clock(self, agent: str, by_s: float) -> None: ...
    def ask_to_leave(self, agent: str) -> None: ...
    def restart(self, agent: str, *, probation: int = 0) -> None: ...


class Faults:
    """The faults of one factory.

    Args:
        world: where they happen.

    Attributes:
        world: the same.
        skipped: faults of a schedule that could not begin, since there was nothing to go wrong.
    """

    def __init__(self, world: World) -> None:
        self.world = world
        self.skipped = 0
        self._active: dict[str, Fault] = {}
        self._begun = 0

    @property
    def active(self) -> Mapping[str, Fault]:
        """The active faults by id, in the order of their beginnings."""
        return MappingProxyType(self._active)

    @property
    def cast(self) -> Cast:
        """The agents and things that a fault may name at this moment."""
        vehicles, machines = tuple(self.world.vehicles), tuple(self.world.workcells)
        bodies = {*vehicles, *machines}
        others = tuple(agent for agent in self.world.workers if agent not in bodies)
        doors = tuple(self.world.floor.doors.states)
        return Cast(vehicles, machines, others, self.world.bus.access_points, self.world.lanes, doors)

    def begin(self, fault: Fault) -> str:
        """Begin a fault now.

        Returns:
            The id with which it is ended.

        Raises:
            FaultError: its agent does not exist, or there is nothing that could fail.
        """
        self.cast.check(fault)
        if isinstance(fault, LaneBlocked):
            fault = self.cast.as_driven(fault)
        if len(self._active) >= MAX_ACTIVE:
            raise FaultError("fault", f"{MAX_ACTIVE} faults are active; end some first")
        self._do(fault)
        self._begun += 1
        name = f"F{self._begun}"
        self._active[name] = fault
        if isinstance(fault, LaneBlocked) and fault.thing is Thing.PERSON:
            clock = self.world.clock
            clock.call_at(clock.now_s() + PERSON_STAYS_S, partial(_end, name, self))
        return name

    def end(self, name: str) -> None:
        """End a fault, as far as no other fault holds the same thing.

        Raises:
            FaultError: no fault of this id is active.
        """
        fault = self._active.pop(name, None)
        if fault is None:
            active = ", ".join(self._active) or "none"
            raise FaultError("id", f"no fault {name!r} is active; active are {active}")
        self._undo(fault)

    def end_all(self) -> None:
        """Put everything right, in the order of beginning."""
        for name in tuple(self._active):
            self.end(name)

    def switch_on(self, agent: str) -> None:
        """Switch a vehicle or a machine on again, as far as no fault holds it off. Harmless when it is on."""
        if self._holds(agent, PoweredOff):
            return
        self.world.power_on(agent)
        if self._holds(agent, *_ENDED):
            self.world.crash(agent)

    # --- how it is done --------------------------------------------------------------------------

    def _do(self, fault: Fault) -> None:
        world = self.world
        match fault:
            case PoweredOff(agent):
                world.power_off(agent)
            case Crashed(agent):
                world.crash(agent)
            case JournalLost(agent):
                world.lose_journal(agent)
            case ClockSet(agent, by_s):
                world.set_clock(agent, by_s)
            case SentAway(agent):
                world.ask_to_leave(agent)
            case MachineBroken(machine, reason, problem):
                world.workcells[machine].break_down(reason, problem)
            case VehicleBroken(atv, reason, problem):
                world.vehicles[atv].break_down(reason, problem)
            case LaneBlocked() | DoorFailed() | LoadDropped() | LoadShifted():
                self._try(fault)
            case _:
                world.bus.begin(fault)

    def _try(self, fault: LaneBlocked | DoorFailed | LoadDropped | LoadShifted) -> None:
        """Apply a fault of the floor; most are possible at some moments only.

        Raises:
            FaultError: it is not possible now.
        """
        world = self.world
        match fault:
            case LaneBlocked(start, end, thing):
                if not world.obstruct((start, end), thing):
                    reason = (
                        f"a vehicle is too near to the middle of the lane from {start} to {end}, or something lies there "
                        "already; try again in a moment, or choose another lane"
                    )
                    raise FaultError("fault", reason)
            case DoorFailed(door):
                world.floor.doors.fail(door)
            case LoadDropped(atv):
                if not world.floor.drop_load(atv):
                    reason = (
                        f"{atv} has no load on board, is on no lane, or another vehicle is too near behind it; "
                        "begin it while it carries something"
                    )
                    raise FaultError("fault.atv", reason)
            case LoadShifted(atv):
                if not world.vehicles[atv].shift_load():
                    reason = f"{atv} has no load that could shift; begin it while a load is on board"
                    raise FaultError("fault.atv", reason)

    def _undo(self, fault: Fault) -> None:
        world = self.world
        match fault:
            case PoweredOff(agent):
                self.switch_on(agent)
            case Crashed(agent) | JournalLost(agent):
                # Without power it comes with the power, which somebody may have given by hand meanwhile.
                if not self._holds(agent, *_ENDED) and not world.running(agent):
                    world.restart(agent)
            case ClockSet(agent, by_s):
                world.set_clock(agent, -by_s)
            case SentAway(agent, probation):
                if not self._holds(agent, *_ENDED):
                    world.restart(agent, probation=probation)
            case MachineBroken(machine):
                if not self._holds(machine, MachineBroken):
                    world.workcells[machine].repair()
            case LaneBlocked() | DoorFailed():
                self._open(fault)
            case VehicleBroken(atv) | LoadShifted(atv) | LoadDropped(atv):
                if not self._holds(atv, VehicleBroken, LoadShifted, LoadDropped):
                    world.vehicles[atv].repair()
            case _:
                world.bus.end(fault)

    def _open(self, fault: LaneBlocked | DoorFailed) -> None:
        """Let vehicles drive there again."""
        match fault:
            case LaneBlocked(start, end):
                self.world.clear((start, end))
            case DoorFailed(door):
                if not self._holds(door, DoorFailed):
                    self.world.floor.doors.repair(door)

    def _holds(self, name: str, *kinds: type[Fault]) -> bool:
        """Whether an active fault of these kinds is about `name`."""
        return any(isinstance(fault, kinds) and _subject(fault) == name for fault in self._active.values())


def _subject(fault: Fault) -> str:
    """The subject of a fault in one body or process."""
    match fault:
        case PoweredOff(name) | Crashed(name) | JournalLost(name) | SentAway(name):
            return name
        case MachineBroken(name) | VehicleBroken(name) | LoadShifted(name) | LoadDropped(name):
            return name
        case DoorFailed(name):
            return name
        case _:
            return ""


def play(schedule: Iterable[Timed], faults: Faults) -> None:
    """Schedule faults; those with a past time begin now.

    A fault without an object, as a load to shift, is skipped and counted.

    Args:
        schedule: in any order; within one instant the order is that of the schedule.
        faults: of the factory in which it happens.

    Raises:
        FaultError: the agent of a fault does not exist; then nothing of the schedule happens.
    """
    planned = tuple(schedule)
    for place, timed in enumerate(planned):
        faults.cast.check(timed.fault, f"schedule[{place}].fault")
    for timed in planned:
        faults.world.clock.call_at(timed.at_s, partial(_begin, timed, faults))


def _begin(timed: Timed, faults: Faults) -> None:
    try:
        name = faults.begin(timed.fault)
    except FaultError:
        faults.skipped += 1
        return
    if timed.until_s is not None:
        faults.world.clock.call_at(timed.until_s, partial(_end, name, faults))


def _end(name: str, faults: Faults) -> None:
    # Somebody may have ended it by hand.
    if name in faults.active:
        faults.end(name)
