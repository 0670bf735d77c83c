"""Plain transports that people and programs order to one place: each is done once, even if messages are lost.

    ordered --room--> set aside, given out --carried, counted--> DELIVERED
       |       ^             |
       |       +-------------+ its task was withdrawn, or only a part was counted: given out again under another name
       +--- cancelled before it is on board, or refused --> CANCELLED

A gateway repeats an order until it is answered. The order is recognised by its name, also for a while after it has
ended. Its state is stored before it is answered.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, Protocol

from dray.memory import Memory, TransportMemory
from dray.messages import (
    THING,
    TRANSPORT_ENDED,
    Phase,
    Transport,
    TransportAnswered,
    TransportCancelled,
    TransportOrdered,
    TransportRefusal,
    TransportState,
    TransportWait,
)
from dray.messages.fact import TransportProgressed
from dray.plant import Plant
from dray.protocol.contract_net.task import OpenTask
from dray.protocol.runtime.events import Commit
from dray.protocol.runtime.life import Life
from dray.protocol.transports.sourcing import Sourcing
from dray.protocol.transports.transports import Stock, Transports

OPEN_MAX = 200
"""Maximum open transports of one place: hours of its dock's work. Further orders are ignored, and repeated."""

WISH_ENDS = "wish_ends"
"""Alarm of a transport: any vehicle may carry it from now on."""

LOOK_AGAIN_S = 10.0
"""Interval for checking whether the wanted vehicle, which has a contract, has given it back (s)."""

ENDED_KEPT = 4096
"""Ended transports whose repeated order is recognised: a gateway asks every ten minutes for those it believes open."""

NOTE = "transport "
"""Prefix of a transport's note, before its name."""

_ON_BOARD = frozenset({Phase.CARRYING, Phase.UNLOADING, Phase.HANDING_OVER})


class CalledTransport:
    """One ordered transport."""

    __slots__ = (
        "ability",
        "attempt",
        "done",
        "due_s",
        "id",
        "item",
        "quantity",
        "source",
        "state",
        "task",
        "told",
        "vehicle",
        "vehicle_until_s",
    )

    def __init__(self, order: TransportOrdered) -> None:
        self.id, self.source, self.item = order.transport, order.source, order.item
        self.quantity, self.due_s = order.quantity, order.due_s
        self.vehicle, self.vehicle_until_s = order.vehicle, order.vehicle_until_s
        self.ability = order.ability
        self.state = TransportState.WAITING
        self.done = 0
        """Pieces counted."""
        self.attempt = 0
        self.task = ""
        """Id of its task; empty while it waits for room."""
        self.told: TransportProgressed | None = None

    def memory(self) -> TransportMemory:
        """The record for the next life."""
        return TransportMemory(
            transport=self.id,
            source=self.source,
            item=self.item,
            quantity=self.quantity,
            due_s=self.due_s,
            vehicle=self.vehicle,
            state=self.state,
            done=self.done,
            attempt=self.attempt,
            vehicle_until_s=self.vehicle_until_s,
            ability=self.ability,
        )


class Flow(Protocol):
    """What this class needs of a place's material flow."""

    tasks: Transports
    sourcing: Sourcing

    def seek(self, task: str, work: Transport, deadline_s: float, now_s: float) -> None:
        """Have a load set aside, and then fetched."""

    def cancel(self, task: OpenTask) -> None:
        """End a transport that is not needed any more."""

    def drop(self, task: str) -> None:
        """Cancel the request for a load that no vehicle was hired for."""

    def inbound(self, item: str) -> int:
        """Pieces that are to find room here: on order, or put down without an order."""


class CalledTransports:
    """The ordered transports of one place.

    Args:
        place: their destination.
        plant: the plant with its storages.
        stock: the place's stock.
        flow: has loads set aside and fetched.
        life: the agent's life; alarms are named ``(WISH_ENDS, transport)``.

    Attributes:
        alarms: handlers of these alarms.
    """

    def __init__(self, place: str, plant: Plant, stock: Stock, flow: Flow, life: Life) -> None:
        self._place, self._plant, self._stock, self._flow = place, plant, stock, flow
        self._life, self._mark = life, life.mark
        self.alarms: Mapping[str, Callable[[Any, float], None]] = {WISH_ENDS: self._end_wish}
        self._open: dict[str, CalledTransport] = {}
        self._ended: dict[str, TransportState] = {}
        """Outcomes of ended transports that are still recognised, the oldest first."""
        self._unwritten: dict[str, TransportMemory | None] = {}

    def __iter__(self) -> Iterator[CalledTransport]:
        return iter(self._open.values())

    def __len__(self) -> int:
        return len(self._open)

    def has(self, task: str) -> bool:
        """Whether a task belongs to an ordered transport."""
        return any(called.task == task for called in self)

    # --- orders ---

    def on_ordered(self, sender: str, order: TransportOrdered, now_s: float) -> None:
        """Handle an order, new or repeated."""
        if not self._may_ask(sender, order.transport, order.source):
            self._life.ignore("an order of a machine to fetch what is not its own")
            return
        state = self._state_of(order.transport)
        if state is not None:
            self._answer(sender, order.transport, state)
        elif refused := self._refusal(sender, order):
            self._refuse(order, refused)
            self._answer(sender, order.transport, TransportState.CANCELLED, refused)
        elif len(self._open) >= OPEN_MAX:
            self._life.ignore("an order above the limit of open transports")
        else:
            called = self._open[order.transport] = CalledTransport(order)
            self._take_up(called)
            self._write(called)
            self.pursue(now_s)
            self.review(now_s)
            self._answer(sender, called.id, self._state_of(called.id) or called.state)

    def on_cancelled(self, sender: str, message: TransportCancelled) -> bool:
        """Handle a cancellation; returns whether it has ended the transport."""
        if not self._may_ask(sender, message.transport, sender):
            self._life.ignore("a cancellation of a transport that the machine has not ordered")
            return False
        called = self._open.get(message.transport)
        ends = called is not None and not self._is_on_board(called)
        if called is not None and ends:
            task = self._flow.tasks.get(called.task)
            if task is not None:
                self._flow.cancel(task)
            elif called.task:
                self._flow.drop(called.task)
            self._end(called, TransportState.CANCELLED)
        elif called is None and message.transport not in self._ended:
            # Its own order may come after it, and must not start it.
            self._note_ended(message.transport, TransportState.CANCELLED, None)
        state = self._state_of(message.transport) or TransportState.CANCELLED
        self._answer(sender, message.transport, state)
        return ends

    # --- progress ---

    def pursue(self, now_s: float) -> None:
        """Have loads fetched for which there is room."""
        for called in list(self):
            missing = called.quantity - called.done
            if called.task or self._stock.room(called.item) - self._flow.inbound(called.item) < missing:
                continue
            called.attempt += 1
            called.task = f"{called.id}{self._mark}-{called.attempt}"
            self._write(called)
            work = Transport(
                item=called.item,
                quantity=missing,
                sources=(called.source,),
                destination=self._place,
                ability=called.ability
                if called.item == THING
                else self._plant.materials[called.item].ability,
                vehicle=called.vehicle,
                vehicle_until_s=called.vehicle_until_s,
                also="" if called.item == THING else called.ability,
            )
            self._flow.seek(called.task, work, called.due_s, now_s)

    def _end_wish(self, transport: str, now_s: float) -> None:
        """The time for one vehicle is over: unless it has the transport, any vehicle may carry it."""
        called = self._open.get(transport)
        if called is None:
            return
        task = self._flow.tasks.get(called.task)
        if task is not None and (task.primary or task.is_held or not task.lies_at_source):
            self._life.alarm((WISH_ENDS, transport), now_s + LOOK_AGAIN_S)
            return
        if task is not None:
            self._flow.cancel(task)
        elif called.task:
            self._flow.drop(called.task)
        called.task, called.vehicle, called.vehicle_until_s = "", "", None
        self._write(called)
        self.pursue(now_s)
        self.review(now_s)

    def on_lost(self, task: OpenTask) -> bool:
        """A task was withdrawn; returns whether it was one of these, which is ordered again."""
        called = next((each for each in self if each.task == task.id), None)
        if called is None:
            return False
        called.task = ""
        return True

    def on_settled(self, task: OpenTask, counted: int) -> bool:
        """A load was counted; returns whether it was one of these."""
        called = next((each for each in self if each.task == task.id), None)
        if called is None:
            if task.recovered and (name := _transport_of(task.id)) not in self._ended:
                # The life that ordered it left no notes: its order may be repeated, and must not be done
                # again.
                self._note_ended(name, TransportState.DELIVERED, None)
            return False
        called.done += min(counted, called.quantity - called.done)
        called.task = ""
        if called.done >= called.quantity:
            self._end(called, TransportState.DELIVERED)
        else:
            self._write(called)
        return True

    def review(self, _now_s: float) -> None:
        """Report changes."""
        for called in self:
            self._tell(called)

    # --- over a restart ---

    def restore(self, memory: Memory) -> None:
        """Continue the transports of an earlier life, whose tasks are restored already."""
        for note in memory.values():
            if not isinstance(note, TransportMemory):
                continue
            if note.state in TRANSPORT_ENDED:
                self._ended[note.transport] = note.state
                continue
            order = TransportOrdered(
                note.transport,
                note.source,
                note.item,
                note.quantity,
                note.due_s,
                note.vehicle,
                note.vehicle_until_s,
                note.ability,
            )
            called = self._open[note.transport] = CalledTransport(order)
            called.done, called.attempt = note.done, note.attempt
            self._take_up(called)

    def commits(self) -> Sequence[Commit]:
        """The changes to store."""
        if not self._unwritten:
            return ()
        commits = [Commit(note, NOTE + name) for name, note in self._unwritten.items()]
        self._unwritten.clear()
        return commits

    # --- internals ---

    def _may_ask(self, sender: str, transport: str, source: str) -> bool:
        """Whether the sender may order: a machine may only have its own things fetched."""
        of_machine = sender in self._plant.machines
        return not of_machine or (source == sender and transport.startswith((f"{sender}-", f"{sender}.")))

    def _take_up(self, called: CalledTransport) -> None:
        """Resume a transport, whose load may be on its way for an earlier life."""
        if called.vehicle and called.vehicle_until_s is not None:
            self._life.alarm((WISH_ENDS, called.id), called.vehicle_until_s)
        for task in self._flow.tasks:
            if _transport_of(task.id) == called.id:
                called.task = task.id

    def _refusal(self, sender: str, order: TransportOrdered) -> TransportRefusal | None:
        plant, item = self._plant, order.item
        if item == THING:
            return self._refusal_of_thing(order)
        room = self._stock.level(item) + self._stock.room(item)
        if item not in plant.materials or not 0 < order.quantity <= room:
            return TransportRefusal.NOT_KEPT_HERE
        keepers = (*plant.keepers_of(item), sender)  # A machine has its products fetched, too.
        if order.source == self._place or order.source not in keepers:
            return TransportRefusal.NOT_KEPT_THERE
        return TransportRefusal.TOO_LARGE if order.quantity > plant.materials[item].lot else None

    def _refusal_of_thing(self, order: TransportOrdered) -> TransportRefusal | None:
        """Check a thing: it is fetched once, from any place with a dock, by a vehicle with the named ability."""
        plant = self._plant
        if order.quantity != 1:
            return TransportRefusal.TOO_LARGE
        if not order.ability:
            return TransportRefusal.NOT_KEPT_HERE
        has_dock = order.source in plant.machines or order.source in plant.stores
        return None if has_dock and order.source != self._place else TransportRefusal.NOT_KEPT_THERE

    def _refuse(self, order: TransportOrdered, refused: TransportRefusal) -> None:
        called = CalledTransport(order)
        called.state = TransportState.CANCELLED
        self._record(called, None, None, refused)
        self._note_ended(order.transport, called.state, called)

    def _state_of(self, transport: str) -> TransportState | None:
        called = self._open.get(transport)
        return self._ended.get(transport) if called is None else called.state

    def _is_on_board(self, called: CalledTransport) -> bool:
        task = self._flow.tasks.get(called.task)
        if task is None:
            return False
        return task.contract.phase in _ON_BOARD or task.is_counted or task.is_loaded

    def _tell(self, called: CalledTransport) -> None:
        task = self._flow.tasks.get(called.task)
        if task is None or not task.primary:
            called.state = TransportState.WAITING
            self._record(called, None, self._wait(called, task))
        else:
            called.state = TransportState.ON_BOARD if self._is_on_board(called) else TransportState.ASSIGNED
            self._record(called, task, None)

    def _wait(self, called: CalledTransport, task: OpenTask | None) -> TransportWait:
        if task is not None:
            # The state remains while it is offered again: the wait begins with the first failed round.
            return TransportWait.NO_BID if task.auction.found_nobody else TransportWait.UNDECIDED
        if not called.task:
            return TransportWait.NO_ROOM
        waits = any(need.task == called.task and need.waits for need in self._flow.sourcing)
        return TransportWait.SHORT if waits else TransportWait.UNDECIDED

    def _record(
        self,
        called: CalledTransport,
        task: OpenTask | None,
        wait: TransportWait | None,
        refused: TransportRefusal | None = None,
    ) -> None:
        ended = called.state in TRANSPORT_ENDED
        fact = TransportProgressed(
            transport=called.id,
            state=called.state,
            item=called.item,
            quantity=called.done if ended else called.quantity - called.done,
            source=called.source,
            destination=self._place,
            task=called.task,
            carrier=task.primary if task is not None else "",
            expected_s=task.contract.promised_s if task is not None else None,
            wait=wait,
            refused=refused,
        )
        if fact != called.told:
            called.told = fact
            self._life.record(fact)

    def _end(self, called: CalledTransport, state: TransportState) -> None:
        del self._open[called.id]
        self._life.cancel((WISH_ENDS, called.id))
        called.state, called.task = state, ""
        self._record(called, None, None)
        self._note_ended(called.id, state, called)

    def _note_ended(self, name: str, state: TransportState, called: CalledTransport | None) -> None:
        self._ended[name] = state
        self._unwritten[name] = (
            TransportMemory(name, "", "", 0, 0.0, "", state) if called is None else called.memory()
        )
        if len(self._ended) > ENDED_KEPT:
            oldest = next(iter(self._ended))
            del self._ended[oldest]
            self._unwritten[oldest] = None

    def _write(self, called: CalledTransport) -> None:
        self._unwritten[called.id] = called.memory()

    def _answer(
        self, to: str, transport: str, state: TransportState, refused: TransportRefusal | None = None
    ) -> None:
        self._life.send(to, TransportAnswered(transport, state, refused))


def _transport_of(task: str) -> str:
    """The transport that a task is an attempt at, by its id; an unknown name for other tasks."""
    name, _, _ = task.rpartition("-")
    before, _, life = name.rpartition(".")
    return before if before and life.isdigit() else name
