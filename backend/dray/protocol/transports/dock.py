"""A coordinator's dock: which vehicle may load or unload now, and whose handover counts.

The epoch fences here. A carrier asks before every transfer (`Docked`). Its `Handover`, the report that the load is
down, is accepted once per task, from the carrier of the present epoch. Any other vehicle hears `Superseded` with
the right epoch, and brings its load back.
"""

from __future__ import annotations

from typing import cast

from dray.messages import Docked, Handover, HandoverAccepted, Transport
from dray.protocol.contract_net.task import OpenTask
from dray.protocol.runtime.events import NEVER_S
from dray.protocol.runtime.life import Life
from dray.protocol.transports.dock_door import Door
from dray.protocol.transports.transports import Stock, Transports


class Dock:
    """The dock of one coordinator.

    Args:
        place: the dock's place.
        tasks: its open transports.
        stock: its stock.
        door: its door.
    """

    def __init__(self, place: str, tasks: Transports, stock: Stock, door: Door, life: Life) -> None:
        self._place = place
        self._tasks = tasks
        self._stock = stock
        self._life = life
        self._door = door

    def on_docked(self, sender: str, message: Docked, now_s: float) -> None:
        """A vehicle asks to load or to unload."""
        task = self._tasks.get(message.task)
        if task is None or message.epoch != task.epoch or sender != task.primary:
            self._life.send(sender, self._tasks.superseded(message.task, message.epoch))
            return
        work = cast(Transport, task.work)
        here = message.station == self._place
        if here:
            self._door.visits.on_docked(sender, message, now_s, unloads=work.destination == self._place)
        held = self._why_held(work) if here else ""
        was_held_s = task.contract.held_s
        task.contract.held_s = min(was_held_s, now_s) if held else NEVER_S
        if held:
            self._door.hold(sender, message, held)
        elif here:
            self._door.open(
                sender, message, work.item, work.quantity, now_s, comes=work.destination == self._place
            )
            if self._door.visits.answers:
                task.contract.held_s = min(was_held_s, now_s)
        else:
            self._door.agree(sender, message)

    def may_have_brought(self, task: OpenTask) -> bool:
        """Whether the carrier of a task was let in, so that it may have put its load down here."""
        return self._door.visits.may_have_brought(task.primary, task.work_item)

    def is_opening(self, vehicle: str) -> bool:
        """Whether a vehicle waits for the body to open the dock, and not for room."""
        return self._door.is_opening(vehicle)

    def on_ready(self, vehicle: str, now_s: float) -> None:
        """The body has opened the dock for a vehicle."""
        if self._door.on_ready(vehicle, now_s):
            for task in self._tasks:
                if task.primary == vehicle:
                    task.contract.held_s = NEVER_S

    def on_handover(self, sender: str, message: Handover) -> OpenTask | None:
        """A vehicle reports its load as down.

        Returns:
            The sender's task; None for any other vehicle, which is answered here.
        """
        task = self._tasks.get(message.task)
        if task is not None and message.epoch == task.epoch and sender == task.primary:
            return task
        closed = self._tasks.closed(message.task)
        known, visits = self._tasks.knows(message.task, message.epoch), self._door.visits
        if visits.on_put_down(sender, message.task, message.epoch, message.quantity, known=known):
            self._life.ignore("a handover of a vehicle that is here for another load")
            return None
        if closed is not None and closed.carrier == sender and closed.outcome == "delivered":
            self._accept(sender, message.task, message.epoch)
        else:
            self._life.send(sender, self._tasks.superseded(message.task, message.epoch))
        return None

    def _why_held(self, work: Transport) -> str:
        if work.destination != self._place:
            return "" if self._stock.level(work.item) >= work.quantity else "the goods are not ready"
        return "" if self._stock.room(work.item) >= work.quantity else "the buffer is full"

    def accept(self, task: OpenTask) -> None:
        """The load is there: release its carrier."""
        self._accept(task.primary, task.id, task.epoch)
        self._tasks.close(task, "delivered")

    def _accept(self, carrier: str, task: str, epoch: int) -> None:
        self._life.send(carrier, HandoverAccepted(task=task, epoch=epoch))
