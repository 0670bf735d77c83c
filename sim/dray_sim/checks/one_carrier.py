"""Invariant 24: a storage opens its dock for one carrier of a task at a time.

Its body says for whom the dock is open, and what its station says to vehicles tells for which tasks.
"""

from __future__ import annotations

from dray.messages import DockOpened, Message
from dray_sim.checks.broken import InvariantBroken
from dray_sim.factory.sim_factory import SimFactory


class OneCarrierAtATime:
    """For one factory."""

    def __init__(self, factory: SimFactory) -> None:
        self._storages = factory.floor.storages
        self._tasks: dict[tuple[str, str], str] = {}
        """By storage and vehicle, the last task for which its dock was opened."""

    def on_message(self, at_s: float, sender: str, address: str, message: Message) -> None:
        """Note one utterance.

        Raises:
            InvariantBroken: two vehicles may fetch the load of one task.
        """
        if type(message) is not DockOpened or message.station != sender or sender not in self._storages:
            return
        vehicle = address.removeprefix(">")
        self._tasks[sender, vehicle] = message.task
        for other in self._storages[sender].sense().opened:
            if other != vehicle and self._tasks.get((sender, other)) == message.task:
                seen = f"{sender} is open for {vehicle} and for {other} to fetch the load of {message.task}"
                raise InvariantBroken(24, at_s, seen)
