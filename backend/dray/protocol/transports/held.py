"""Transports whose handover was disputed twice: a person is asked whether the load is there.

A third load might be lost like the first two. So no vehicle carries the transport before a person who is
responsible for the destination has looked:

    ASSIGNED, IN_TRANSIT --nothing was counted, again--> HELD --LOAD_THERE--> DELIVERED
                                                          |
                                                          +--LOAD_MISSING--> announced anew, with disputes reset to 0;
                                                                             goods that had left their machine are made again

It waits without a limit, over restarts too. A transport that is not needed any more ends as usual.
"""

from __future__ import annotations

from typing import cast

from dray.messages import CommandRefusal, MachineCommand, MachineCommandKind, Problem, ProblemKind, Transport
from dray.plant import Plant
from dray.protocol.calls.help_calls import HelpCalls
from dray.protocol.contract_net.task import OpenTask
from dray.protocol.transports.transports import Transports

LOOK_FOR_LOAD = Problem(kind=ProblemKind.LOAD, needs_person=True)
"""The reason of the call."""


class HeldTransports:
    """The held transports of one place.

    Args:
        plant: the plant, for destinations' positions.
        tasks: its transports.
    """

    def __init__(self, plant: Plant, tasks: Transports) -> None:
        self._plant, self._tasks = plant, tasks

    def obey(self, command: MachineCommand, now_s: float) -> CommandRefusal | None:
        """A person has looked. Returns the refusal; None when the transport has ended or goes on."""
        task = self._held(command.task)
        if task is None:
            return CommandRefusal.NOT_HELD
        if command.kind is MachineCommandKind.LOAD_THERE:
            self._tasks.conclude(task, now_s)
        else:
            self._tasks.resume(task, now_s)
        return None

    def place_m(self, task: str) -> tuple[float, float] | None:
        """The destination of a held transport's load (x, y) in m; None if it is not held."""
        held = self._held(task)
        return None if held is None else self._plant.position_of(cast(Transport, held.work).destination)

    def names(self) -> tuple[str, ...]:
        """The held transports' ids."""
        return tuple(task.id for task in self._tasks if task.is_held)

    def call(self, calls: HelpCalls, now_s: float) -> None:
        """Call a person for each of them. Repeating this is harmless."""
        for task in self._tasks:
            if task.is_held:
                work = cast(Transport, task.work)
                reason = f"{work.quantity} {work.item} for {work.destination} said to be there twice, and not counted"
                calls.open(LOOK_FOR_LOAD, reason, now_s, goods=task.id, place_m=self.place_m(task.id))

    def _held(self, name: str) -> OpenTask | None:
        task = self._tasks.get(name)
        return task if task is not None and task.is_held else None
