"""Invariant 24: a storage opens its dock for one carrier of a task at a time.

Its body tells for which vehicle the dock is open, and its station's messages to vehicles tell for which tasks.
"""

from __future__ import annotations

from dray.messages import Docked, DockOpened, Message
from dray_sim.checks.broken import InvariantBroken
from dray_sim.factory.sim_factory import SimFactory


class OneCarrierAtATime:
    """Checks one factory."""

    hears = (Docked, DockOpened)

    def __init__(self, factory: SimFactory) -> None:
        self._storages = factory.floor.storages
        self._tasks: dict[tuple[str, str], str] = {}
        """Last task whose load the vehicle may fetch there, by storage and vehicle."""
        self._returns: dict[tuple[str, str], None] = {}
        """Storages and vehicles that have asked last to put a load back there."""

    def on_message(self, at_s: float, sender: str, address: str, message: Message) -> None:
        """Note one utterance.

        Raises:
            InvariantBroken: two vehicles may fetch the load of one task.
        """
        if type(message) is Docked:
            if message.returns:
                self._returns[message.station, sender] = None
            else:
                self._returns.pop((message.station, sender), None)
        if type(message) is not DockOpened or message.station != sender or sender not in self._storages:
            return
        vehicle = address.removeprefix(">")
        if (sender, vehicle) in self._returns:
            self._tasks.pop((sender, vehicle), None)
            return
        self._tasks[sender, vehicle] = message.task
        for other in self._storages[sender].sense().opened:
            if other != vehicle and self._tasks.get((sender, other)) == message.task:
                seen = f"{sender} is open for {vehicle} and for {other} to fetch the load of {message.task}"
                raise InvariantBroken(24, at_s, seen)
