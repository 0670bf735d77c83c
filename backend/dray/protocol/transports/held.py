"""Transports and doubtful loads of which only a person can tell whether the load is there, or what is wrong at a dock.

    disputed        a handover was disputed twice: a third load might be lost like the first two
    perhaps down    the body does not count. An earlier life let the carrier in, and the carrier has forgotten the
                    task and has no such load on board (`Transports.reopen`)
    fails at        two carriers in a row stood at one dock in vain, or one alone time after time (`dock_failures`)

No vehicle carries the transport before a person who is responsible for the destination, or for the place where
carriers fail, has looked:

    ASSIGNED, IN_TRANSIT --nothing was counted, again--> HELD --LOAD_THERE--> DELIVERED
                         --perhaps down---------------->  |
    ASSIGNED             --fails at-------------------->  |
                                                          +--LOAD_MISSING--> announced anew, with disputes reset to 0;
                                                                             goods that had left their machine are made again

LOAD_THERE books a load in that was perhaps put down, and its transport is delivered when the body has answered. The
same follows from the carrier's own report, if it tells after all, before and after LOAD_MISSING. Where carriers fail,
LOAD_MISSING says that a person has looked and that the dock is in order again; LOAD_THERE that people have brought the
load by hand.
It waits without a limit, over restarts too. A transport that is not needed any more ends as usual.

A doubtful load (`doubts`) holds no transport. LOAD_THERE books it in, LOAD_MISSING leaves the books as they are.
"""

from __future__ import annotations

from typing import cast

from msgspec.structs import replace

from dray.memory import DepartureMemory
from dray.messages import CommandRefusal, MachineCommand, MachineCommandKind, Problem, ProblemKind, Transport
from dray.plant import Plant
from dray.protocol.calls.help_calls import HelpCalls
from dray.protocol.contract_net.task import OpenTask
from dray.protocol.transports.bookings import Bookings
from dray.protocol.transports.transports import Transports
from dray.protocol.transports.visits import Visits

LOOK_FOR_LOAD = Problem(kind=ProblemKind.LOAD, needs_person=True)
"""The reason of the call."""

LOOK_AT_DOCK = Problem(kind=ProblemKind.DOCK, needs_person=True)
"""The reason of the call to a place where carriers fail."""


class HeldTransports:
    """The held transports of one place.

    Args:
        plant: the plant, for destinations' positions.
        tasks: its transports.
        visits: the vehicles at its dock.
        bookings: reports to its body.
    """

    def __init__(self, plant: Plant, tasks: Transports, visits: Visits, bookings: Bookings) -> None:
        self._plant, self._tasks = plant, tasks
        self._visits, self._bookings = visits, bookings

    def obey(self, command: MachineCommand, now_s: float) -> CommandRefusal | None:
        """A person has looked. Returns the refusal; None when the transport ends or goes on, or the doubt is settled."""
        task = self._held(command.task)
        if task is None:
            return self._settle(command)
        if task.perhaps_down is not None:
            self._visits.doubts.on_told(task.perhaps_down)
        if command.kind is MachineCommandKind.LOAD_THERE and task.perhaps_down is not None:
            return self._book(task.perhaps_down)
        if command.kind is MachineCommandKind.LOAD_THERE:
            # The place has not counted what lies there.
            for carrier in () if task.fails_at else task.disputed_by:
                self._tasks.reliability.take_back(carrier, task.id, now_s)
            self._tasks.conclude(task, now_s)
        else:
            self._tasks.resume(task, now_s)
        return None

    def place_m(self, task: str) -> tuple[float, float] | None:
        """Where a person looks (x, y) in m; None for what is not asked for.

        That is the destination of a held transport, or where its carriers fail; this place for a doubtful load.
        """
        held = self._held(task)
        if self._visits.doubts.get(task) is not None:
            return self._plant.position_of(self._visits.doubts.place)
        if held is None:
            return None
        return self._plant.position_of(held.fails_at or cast(Transport, held.work).destination)

    def names(self) -> tuple[str, ...]:
        """The held transports' ids, and the names of doubtful loads."""
        held = (task.id for task in self._tasks if task.is_held)
        return (*held, *(doubt.name for doubt in self._visits.doubts))

    def update(self, now_s: float) -> None:
        """Ask for doubtful loads whose time has come, and that no held transport asks for."""
        for task in self._tasks:
            if task.is_held and task.perhaps_down is not None:
                self._visits.doubts.on_told(task.perhaps_down)
        self._visits.doubts.update(now_s)

    def on_word(self, command: MachineCommand) -> None:
        """A body of people has taken a person's report: what they have counted is in doubt no more."""
        if command.kind is MachineCommandKind.STOCK_IS:
            self._visits.doubts.on_counted(command.item)
        elif command.kind in (MachineCommandKind.ARRIVED, MachineCommandKind.TAKEN) and command.vehicle:
            self._visits.doubts.on_counted(command.item, command.vehicle)

    def call(self, calls: HelpCalls, now_s: float) -> None:
        """Call a person for each of them. Repeating this is harmless."""
        for doubt in self._visits.doubts:
            load = doubt.load
            done = "put down" if load.brings else "not taken"
            reason = f"{load.quantity} {load.item} perhaps {done} by {load.vehicle}: count, they are not in the books"
            calls.open(LOOK_FOR_LOAD, reason, now_s, goods=doubt.name, place_m=self.place_m(doubt.name))
        for task in self._tasks:
            if task.is_held:
                about = LOOK_AT_DOCK if task.fails_at else LOOK_FOR_LOAD
                calls.open(about, _reason(task), now_s, goods=task.id, place_m=self.place_m(task.id))

    def _book(self, load: DepartureMemory) -> CommandRefusal | None:
        """Book a load in; the body's answer ends its transport. A body that books shuts the dock for the load's vehicle."""
        if self._visits.is_here(load.vehicle):
            return CommandRefusal.DOCK_OPEN
        self._visits.forget_owed(load.vehicle, load.task, load.epoch)
        self._bookings.say(load)
        return None

    def _settle(self, command: MachineCommand) -> CommandRefusal | None:
        """A person has counted, and so knows whether a doubtful load lies here."""
        doubts = self._visits.doubts
        load = doubts.get(command.task)
        if load is None:
            return CommandRefusal.NOT_HELD
        if self._visits.may_move(load.item) or self._visits.is_here(load.vehicle):
            return CommandRefusal.DOCK_OPEN
        if command.kind is MachineCommandKind.LOAD_THERE:
            self._visits.forget_owed(load.vehicle, load.task, load.epoch)
            if not (load.brings and load.task):
                # A body books each load of one name once, and may have booked this one out.
                load = replace(load, task=command.task, epoch=1, change=load.quantity)
            self._bookings.say(load)
        doubts.settle(command.task)
        return None

    def _held(self, name: str) -> OpenTask | None:
        task = self._tasks.get(name)
        return task if task is not None and task.is_held else None


def _reason(task: OpenTask) -> str:
    """Why a person is called for a held transport."""
    work = cast(Transport, task.work)
    what = f"{work.quantity} {work.item} for {work.destination}"
    if task.fails_at:
        does = "unload" if task.fails_at == work.destination else "load"
        who = " and ".join(task.disputed_by) or "vehicles"  # An earlier life knew them.
        return f"{who} could not {does} {what} at {task.fails_at}"
    if task.perhaps_down is not None:
        return f"{what} perhaps put down by {task.perhaps_down.vehicle}, which has forgotten it"
    return f"{what} said to be there twice, and not counted"
