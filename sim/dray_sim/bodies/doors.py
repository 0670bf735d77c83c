"""Doors on lanes: they open for a vehicle that stands before them, and shut behind the last one, never on anybody.

    shut --a vehicle asks--> opening --opening_s--> open --closes_after_s behind the last vehicle--> shut

A door that fails while it is open stays open; once it is shut it does not open any more. A vehicle that asks notices
the failure when the door should be open. After its repair the door opens for vehicles that stand before it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from enum import StrEnum
from functools import partial
from typing import Protocol

from dray.plant import Door, Plant
from dray.plant.floor.doors import leaf_of
from dray.plant.floor.rectangles import Rectangle
from dray.plant.restrictions import Ends
from dray.ports import Clock

LOOK_AGAIN_S = 1.0
"""Interval between two tries of a door that cannot shut yet, because a vehicle comes too fast to stop before it."""


class DoorState(StrEnum):
    """The state of one door."""

    SHUT = "shut"
    OPENING = "opening"
    OPEN = "open"
    FAILED = "failed"
    """Shut and defective: a vehicle has asked it in vain."""


class Passer(Protocol):
    """A vehicle, as far as doors need it."""

    @property
    def can_stop(self) -> bool:
        """Whether it can brake in time before any obstacle in its way."""

    def look(self) -> None:
        """Something about the lanes has changed."""


class Doors:
    """All doors of one floor.

    Invariant: no door shuts while a vehicle is on its lanes, or cannot stop before them.

    Args:
        plant: the lanes, and which doors stand on them.
        clock: the plant's clock.
        passers: the vehicles of the floor.

    Attributes:
        leaves: the area that each door covers unless it is open, by lane.
    """

    def __init__(self, plant: Plant, clock: Clock, passers: Mapping[str, Passer]) -> None:
        self._passers = passers
        self._clock = clock
        self._doors = {door.id: _Door(door) for door in plant.doors.values()}
        self._on: dict[Ends, _Door] = {lane: self._doors[door.id] for lane, door in plant.door_on.items()}
        self.leaves: dict[Ends, Rectangle] = {}
        for lane in plant.door_on:
            road = plant.roads.lane(*lane)
            if road is not None:
                self.leaves[lane] = leaf_of(road, plant.nodes, plant.vehicle_types)

    @property
    def states(self) -> dict[str, DoorState]:
        """The state of every door, by its id."""
        return {name: door.state for name, door in self._doors.items()}

    def is_shut(self, lane: Ends) -> bool:
        """Whether a lane cannot be entered because of its door, which may be opening."""
        door = self._on.get(lane)
        return door is not None and door.state is not DoorState.OPEN

    def has_failed(self, lane: Ends) -> bool:
        """Whether a vehicle has found that the door on a lane does not open."""
        door = self._on.get(lane)
        return door is not None and door.state is DoorState.FAILED

    def heed(self, vehicle: str, on: Ends | None, asks: Ends | None) -> None:
        """The motion of a vehicle has changed.

        Args:
            vehicle: its id.
            on: the lane that it is on, or enters now; None for none.
            asks: the lane before which it stands, since its door is not open; None for none.
        """
        within = None if on is None else self._on.get(on)
        for door in self._doors.values():
            door.asked.pop(vehicle, None)
            if door is within:
                door.within[vehicle] = None
            elif vehicle in door.within:
                del door.within[vehicle]
                self._shut_later(door, door.spec.closes_after_s)
        if asks is not None:
            self._on[asks].asked[vehicle] = None
            self._open(self._on[asks])

    def fail(self, door: str) -> None:
        """Let a door open no more, once it is shut; harmless when it does not.

        Raises:
            KeyError: there is no such door.
        """
        broken = self._doors[door]
        broken.fails = True
        if broken.state is DoorState.OPENING:
            broken.state = DoorState.SHUT

    def repair(self, door: str) -> None:
        """Repair a door: it opens for the vehicles that stand before it; harmless when it works.

        Raises:
            KeyError: there is no such door.
        """
        mended = self._doors[door]
        if not mended.fails:
            return
        mended.fails = mended.tries = False
        if mended.state is not DoorState.OPEN:
            mended.state = DoorState.SHUT
            if mended.asked:
                self._open(mended)
            self._tell()

    def _open(self, door: _Door) -> None:
        """Begin to open, or try to."""
        if door.tries or door.state is not DoorState.SHUT:
            return
        door.tries = True
        if not door.fails:
            door.state = DoorState.OPENING
        self._call(door, door.spec.opening_s, self._opened)

    def _opened(self, door: _Door) -> None:
        door.tries = False
        door.state = DoorState.FAILED if door.fails else DoorState.OPEN
        self._tell()
        if door.state is DoorState.OPEN:
            self._shut_later(door, door.spec.closes_after_s)

    def _shut_later(self, door: _Door, in_s: float) -> None:
        if door.state is DoorState.OPEN and not door.within:
            self._call(door, in_s, self._shut)

    def _shut(self, door: _Door) -> None:
        if door.within:
            return
        door.state = DoorState.SHUT
        if all(passer.can_stop for passer in self._passers.values()):
            self._tell()
        else:
            door.state = DoorState.OPEN
            self._shut_later(door, LOOK_AGAIN_S)

    def _tell(self) -> None:
        for passer in tuple(self._passers.values()):
            passer.look()

    def _call(self, door: _Door, in_s: float, step: Callable[[_Door], None]) -> None:
        """Do something to a door later, unless something else is done to it before."""
        door.plan += 1
        self._clock.call_at(self._clock.now_s() + in_s, partial(self._due, door, door.plan, step))

    def _due(self, door: _Door, plan: int, step: Callable[[_Door], None]) -> None:
        if plan == door.plan:
            step(door)


class _Door:
    """One door, and the vehicles at it."""

    def __init__(self, spec: Door) -> None:
        self.spec = spec
        self.state = DoorState.SHUT
        self.fails = False
        self.tries = False
        """Whether it is opening, or should be."""
        self.within: dict[str, None] = {}
        """Vehicles on its lanes."""
        self.asked: dict[str, None] = {}
        """Vehicles that stand before it."""
        self.plan = 0
        """Number of the current plan: a call of the clock with another number is stale."""
