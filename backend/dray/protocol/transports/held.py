"""Transports whose handover was disputed twice: a person is asked to look, and says whether the load is there.

A third load might be lost as the two before it. So nobody carries the transport until a person who answers for the place where the
load was to go has said what is there:

    ASSIGNED, IN_TRANSIT --nothing was counted, again--> HELD --LOAD_THERE--> DELIVERED
                                                          |
                                                          +--LOAD_MISSING--> announced anew, and disputes are counted from 0;
                                                                             goods that had left their machine are made again

It waits for that as long as it takes, over restarts too. What is not needed any more ends as ever.
"""

from __future__ import annotations

from typing import cast

from dray.messages import CommandRefusal, MachineCommand, MachineCommandKind, Problem, ProblemKind, Transport
from dray.plant import Plant
from dray.protocol.calls.help_calls import HelpCalls
from dray.protocol.contract_net.task import OpenTask
from dray.protocol.transports.transports import Transports

LOOK_FOR_LOAD = Problem(kind=ProblemKind.LOAD, needs_person=True)
"""Why a person is asked to come."""


class HeldTransports:
    """Those of one place.

    Args:
        plant: where loads go.
        tasks: its transports.
    """

    def __init__(self, plant: Plant, tasks: Transports) -> None:
        self._plant, self._tasks = plant, tasks

    def obey(self, command: MachineCommand, now_s: float) -> CommandRefusal | None:
        """A person has looked; why that changes nothing, None when the transport has ended or goes on."""
        task = self._held(command.task)
        if task is None:
            return CommandRefusal.NOT_HELD
        if command.kind is MachineCommandKind.LOAD_THERE:
            self._tasks.conclude(task, now_s)
        else:
            self._tasks.resume(task, now_s)
        return None

    def place_m(self, task: str) -> tuple[float, float] | None:
        """Where a load was to go (x, y); None where its transport is not held."""
        held = self._held(task)
        return None if held is None else self._plant.position_of(cast(Transport, held.work).destination)

    def names(self) -> tuple[str, ...]:
        """The transports that are held."""
        return tuple(task.id for task in self._tasks if task.is_held)

    def call(self, calls: HelpCalls, now_s: float) -> None:
        """Call somebody for each of them; harmless where that was done."""
        for task in self._tasks:
            if task.is_held:
                work = cast(Transport, task.work)
                reason = f"{work.quantity} {work.item} for {work.destination} said to be there twice, and not counted"
                calls.open(LOOK_FOR_LOAD, reason, now_s, goods=task.id, place_m=self.place_m(task.id))

    def _held(self, name: str) -> OpenTask | None:
        task = self._tasks.get(name)
        return task if task is not None and task.is_held else None
