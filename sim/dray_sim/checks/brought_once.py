"""Invariant 23: every plain transport is delivered once and completely, or called off and not delivered.

If only one vehicle may carry a transport, no other vehicle carries it. No vehicle without the required ability
carries it. The check listens to the destinations and sends nothing, like those of `dray_sim.checks.invariants`. It
compares the reported quantities with the orders; invariant 2 covers pieces that appear or vanish.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping

from dray.messages import Event, Message, TransportOrdered, TransportState
from dray.messages.contract import Transport
from dray.messages.fact import MemoryLost, TaskClosed, TaskOpened, TransportProgressed
from dray_sim.checks.broken import InvariantBroken


class BroughtOnce:
    """Checks that every plain transport ends once, with the ordered quantity.

    A place that has lost its memory may report less than before, so its transports are not checked any more.

    Args:
        abilities: abilities of each vehicle of the plant file, by its id. Vehicles that joined later are not checked:
            their abilities are only their own claim.
    """

    hears = (TransportOrdered, Event)

    def __init__(self, abilities: Mapping[str, Collection[str]]) -> None:
        self._abilities = abilities
        self._wanted: dict[str, str] = {}
        """By transport: the ability that its vehicle must have."""
        self._asked: dict[str, int] = {}
        """By transport: the ordered pieces."""
        self._only: dict[str, str] = {}
        """By transport: the only vehicle that may carry it, without a time limit."""
        self._ended: dict[str, TransportState] = {}
        self._places: dict[str, str] = {}
        """By transport: the place that reports on it, which is its destination."""
        self._tasks: dict[str, str] = {}
        """By task: its transport. A transport may need several tasks."""
        self._done: dict[str, int] = {}
        """By transport: number of its tasks that were closed as delivered."""
        self._forgotten: set[str] = set()
        """Transports of places that have lost their memory. A carrier may still deliver one after its place has
        cancelled it again."""

    def on_message(self, at_s: float, sender: str, _address: str, message: Message) -> None:
        """Check one message.

        Raises:
            InvariantBroken: a transport has ended twice or with another quantity, went on after its end, was
                delivered although it was cancelled, or has a carrier that may not carry it.
        """
        if type(message) is TransportOrdered:
            self._asked.setdefault(message.transport, message.quantity)
            if message.vehicle and message.vehicle_until_s is None:
                self._only[message.transport] = message.vehicle
            if message.ability:
                self._wanted[message.transport] = message.ability
        elif type(message) is Event:
            fact = message.fact
            if type(fact) is TransportProgressed:
                self._check(fact, sender, at_s)
            elif type(fact) is TaskOpened and type(fact.work) is Transport:
                self._check_task(fact, at_s)
            elif type(fact) is TaskClosed and fact.outcome == "delivered" and fact.task in self._tasks:
                self._close(fact.task, at_s)
            elif type(fact) is MemoryLost:
                for name in [name for name, place in self._places.items() if place == sender]:
                    del self._places[name]
                    self._ended.pop(name, None)
                    self._asked.pop(name, None)
                    self._forgotten.add(name)

    def _close(self, task: str, at_s: float) -> None:
        name = self._tasks[task]
        if self._ended.get(name) is TransportState.CANCELLED and name not in self._forgotten:
            raise InvariantBroken(23, at_s, f"{name} was called off, and {task} of it is delivered")
        self._done[name] = self._done.get(name, 0) + 1

    def _check(self, fact: TransportProgressed, sender: str, at_s: float) -> None:
        name = fact.transport
        if name not in self._asked:
            return
        self._places[name] = sender
        if fact.task:
            self._tasks[fact.task] = name
        if fact.carrier and self._only.get(name, fact.carrier) != fact.carrier:
            raise InvariantBroken(
                23, at_s, f"{name} is for {self._only[name]} alone, and {fact.carrier} has it"
            )
        wanted = self._wanted.get(name)
        known = self._abilities.get(fact.carrier)
        if wanted is not None and known is not None and wanted not in known:
            raise InvariantBroken(
                23, at_s, f"{name} wants {wanted} of its vehicle, and {fact.carrier} has it"
            )
        if name in self._ended:
            raise InvariantBroken(23, at_s, f"{name} was {self._ended[name]}, and is {fact.state} now")
        if fact.state is TransportState.DELIVERED:
            if fact.quantity != self._asked[name]:
                seen = f"{name} was delivered with {fact.quantity} of {self._asked[name]} pieces"
                raise InvariantBroken(23, at_s, seen)
            if not self._done.get(name):
                raise InvariantBroken(23, at_s, f"{name} was delivered, and no task of it was")
        if fact.state in (TransportState.DELIVERED, TransportState.CANCELLED):
            self._ended[name] = fact.state

    def _check_task(self, fact: TaskOpened, at_s: float) -> None:
        transport = self._tasks.get(fact.task, fact.task.rpartition("-")[0].partition(".")[0])
        if transport in self._ended:
            seen = f"{fact.task} is given out, and {transport} was {self._ended[transport]} before"
            raise InvariantBroken(23, at_s, seen)
