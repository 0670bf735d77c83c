"""Invariant 23: every plain transport is delivered once and completely, or called off and not delivered.

If only one vehicle may carry it, no other one does, and no vehicle carries it without the wanted ability. Like those
of `dray_sim.checks.invariants`, this check takes no part; it hears the messages of the destinations. It compares
their counts with the requests; invariant 2 says that no piece appears or vanishes.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping

from dray.messages import Event, Message, TransportOrdered, TransportState
from dray.messages.contract import Transport
from dray.messages.fact import MemoryLost, TaskClosed, TaskOpened, TransportProgressed
from dray_sim.checks.broken import InvariantBroken


class BroughtOnce:
    """Every plain transport ends once, with as much as was asked for.

    A place that has lost its notes may know less than it has told: its transports are no longer checked.

    Args:
        abilities: of each vehicle of the plant, by its id; a vehicle that joined later, and may lie, only claims its
            own.
    """

    def __init__(self, abilities: Mapping[str, Collection[str]]) -> None:
        self._abilities = abilities
        self._wanted: dict[str, str] = {}
        """Wanted ability of the vehicle, by transport."""
        self._asked: dict[str, int] = {}
        """Ordered pieces, by transport."""
        self._only: dict[str, str] = {}
        """The only vehicle that may ever carry it, by transport."""
        self._ended: dict[str, TransportState] = {}
        self._places: dict[str, str] = {}
        """Destination, by transport, as that place has told."""
        self._tasks: dict[str, str] = {}
        """Transport of each task, which is an attempt at it."""
        self._done: dict[str, int] = {}
        """Number of tasks that were closed as delivered, by transport."""
        self._forgotten: set[str] = set()
        """Transports of places that have lost their notes: their carriers may be heard of after they were called off
        anew. It is only asked for membership."""

    def on_message(self, at_s: float, sender: str, _address: str, message: Message) -> None:
        """Note one utterance.

        Raises:
            InvariantBroken: a transport has ended twice or with another quantity, went on after its end, was called
                off and still brought, or has a forbidden carrier.
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
