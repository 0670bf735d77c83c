"""Invariant 15: no vehicle enters a lane that it knows to be closed, and closures are known soon.

A vehicle's body tells the lane when it sets off on it; the vehicle tells its closures when it hears of them. Whether
that is closed is asked of the list as it was said, by the vehicle's own clock.
"""

from __future__ import annotations

from dray.messages import Closures, Event, Message
from dray.messages.fact import ClosuresKnown, MemoryLost
from dray.protocol.closures.known_floor import KnownFloor
from dray_sim.bodies.vehicle.course import Course
from dray_sim.checks.broken import InvariantBroken
from dray_sim.factory.sim_factory import SimFactory

NUMBER = 15


class ClosedLanes:
    """Watches all bodies of a factory.

    Args:
        factory: whose vehicles are watched; one that is added later from the next message on.

    Attributes:
        known: by vehicle, how many lists it has gone by.
        held: how many times a vehicle set off on a lane while it knew of a closure somewhere.
    """

    def __init__(self, factory: SimFactory) -> None:
        self.known: dict[str, int] = {}
        self.held = 0
        self._factory = factory
        self._said: dict[int, Closures] = {}
        self._floors: dict[str, KnownFloor] = {}
        """The known closures, by vehicle."""
        self._lanes: dict[str, tuple[str, str]] = {}
        """The present or last lane, by vehicle."""
        self._broken: InvariantBroken | None = None
        self._watched: dict[str, None] = {}
        self._watch_new()

    def on_message(self, _at_s: float, sender: str, _address: str, message: Message) -> None:
        """See `Listener`.

        Raises:
            InvariantBroken: a vehicle has entered a lane that it knew to be closed.
        """
        if len(self._watched) != len(self._factory.vehicles):
            self._watch_new()
        if type(message) is Closures:
            self._said[message.number] = message
        elif (
            type(message) is Event and type(message.fact) is ClosuresKnown and sender in self._factory.workers
        ):
            # An insider without a body knows of them, too, and drives nowhere.
            floor = self._floors.setdefault(sender, KnownFloor(self._factory.plant))
            floor.take(self._said[message.fact.number], self._factory.clock_of(sender).now_s())
            self.known[sender] = self.known.get(sender, 0) + 1
        elif type(message) is Event and type(message.fact) is MemoryLost:
            # A new life does not know what earlier lives had heard, until it is told again.
            self._floors.pop(sender, None)
        if self._broken is not None:
            raise self._broken

    def _watch_new(self) -> None:
        for name, vehicle in self._factory.vehicles.items():
            if name not in self._watched:
                self._watched[name] = None
                vehicle.watch_course(self._on_course)

    def _on_course(self, vehicle: str, course: Course) -> None:
        if course.lane is None or course.lane == self._lanes.get(vehicle):
            return
        self._lanes[vehicle] = course.lane
        floor = self._floors.get(vehicle)
        if floor is None:
            return
        floor.look(self._factory.clock_of(vehicle).now_s())
        self.held += bool(floor.restrictions.nodes or floor.restrictions.lanes)
        if not floor.restrictions.admits(*course.lane):
            seen = f"{vehicle} drives from {course.lane[0]} to {course.lane[1]}, which it knows to be closed"
            self._broken = self._broken or InvariantBroken(NUMBER, course.begin_s, seen)
