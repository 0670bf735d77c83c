"""Invariant 1 in time: when all faults have ended, every announced task ends within a computed bound.

A vehicle's work for an ended task must end, too. Unneeded parts may stay at their machine while no storage has room
for them, however often it asks. The check hears everything and takes no part. Before the quiet phase it only keeps
books.
"""

from __future__ import annotations

import asyncio

from dray.messages import (
    TRANSPORT_ENDED,
    AtvHeartbeat,
    CancellationTaken,
    Event,
    Message,
    OrderReleased,
    Refusal,
    RevocationTaken,
    StationHeartbeat,
    Transport,
    TransportAnswered,
    TransportOrdered,
    TransportState,
    TransportWait,
)
from dray.messages.fact import (
    BidRefused,
    GoodsDelivered,
    MemoryLost,
    OrderDropped,
    OrderFulfilled,
    PieceMade,
    TaskClosed,
    TaskOpened,
    TransportProgressed,
)
from dray_sim.checks.bounds import Bounds
from dray_sim.checks.broken import InvariantBroken

LOOK_S = 5.0
"""Interval between two looks at the bounds, which are minutes."""

PROGRESS = (PieceMade, GoodsDelivered, TaskClosed, OrderFulfilled, OrderDropped)
"""Events that bring an order forward. Each can happen only a bounded number of times for a finite demand."""


class LivenessCheck:
    """Watches that everything ends.

    Args:
        bounds: the bounds.
        liar: whose word on its own work counts for nothing; empty when everybody is honest.

    Attributes:
        over: set when nothing is open and no vehicle is bound any more, after the quiet phase has begun.
    """

    def __init__(self, bounds: Bounds, liar: str = "") -> None:
        self.over = asyncio.Event()
        self._liar = liar
        self._bounds = bounds
        self._since_s = float("inf")
        self._open: dict[str, tuple[float, int, str]] = {}
        """First announcement, number of transports done before, and item, by transport."""
        self._coordinator: dict[str, str] = {}
        """Coordinator of every announced transport."""
        self._orders: dict[str, str] = {}
        """Undelivered orders, and plain transports; with the agent that asked for each."""
        self._told: dict[str, TransportProgressed] = {}
        """By plain transport: what its destination has told last."""
        self._room: dict[tuple[str, str], int] = {}
        """Pieces that would find room, by item and station."""
        self._ended_orders: dict[str, None] = {}
        self._returned: dict[str, int] = {}
        """Newest known release of each withdrawn order."""
        self._ended: dict[str, None] = {}
        """Transports that are not open any more."""
        self._busy: dict[str, tuple[str, float]] = {}
        """Ended task that a vehicle still names as its own, and since when, by vehicle."""
        self._done = 0
        self._done_before = 0
        """Transports that were done when the quiet phase began."""
        self._moved_s = 0.0
        """When something came forward last."""
        self._look_s = float("inf")
        self._charging_s = float("-inf")
        """When a vehicle has said last that it must charge before it works."""

    def start(self, at_s: float) -> None:
        """The last fault has ended, and the last order was placed."""
        self._since_s = self._moved_s = self._look_s = at_s
        self._done_before = self._done

    def on_message(self, at_s: float, sender: str, _address: str, message: Message) -> None:
        """Note beginnings and ends.

        Raises:
            InvariantBroken: something is open for too long.
        """
        if type(message) is Event:
            self._note(message, at_s)
        elif type(message) is OrderReleased:
            # The message is repeated until it is answered, which may be after the order's end.
            again = message.release > self._returned.get(message.order, 0)
            if message.order not in self._ended_orders and again:
                self._orders[message.order] = sender
        elif type(message) is TransportOrdered:
            if message.transport not in self._ended_orders:
                self._orders[message.transport] = sender
        elif type(message) is TransportAnswered and message.state in TRANSPORT_ENDED:
            self._end_order(message.transport)
        elif type(message) is CancellationTaken:
            self._end_order(message.order)
        elif type(message) is RevocationTaken:
            self._return_order(message)
        elif type(message) is AtvHeartbeat and message.atv != self._liar:
            self._note_work(message, at_s)
        elif type(message) is StationHeartbeat:
            self._room.update({(each.item, sender): each.capacity - each.level for each in message.stocks})
        if at_s >= self._look_s:
            self._look_s = at_s + LOOK_S
            self._look(at_s)

    def _note(self, event: Event, at_s: float) -> None:
        fact = event.fact
        if type(fact) is TaskOpened:
            if type(fact.work) is Transport:
                self._open.setdefault(fact.task, (at_s, self._done, fact.work.item))
                self._coordinator[fact.task] = event.agent
        elif type(fact) is MemoryLost:
            self._forget_those_of(event.agent)
        elif type(fact) is TransportProgressed:
            self._told[fact.transport] = fact
            if fact.state in TRANSPORT_ENDED:
                self._end_order(fact.transport)
            if fact.state is TransportState.DELIVERED:
                # Machines ask for the same again and again: a withdrawn task is no progress.
                self._moved_s = at_s
        elif type(fact) is BidRefused and fact.reason is Refusal.BATTERY and event.agent != self._liar:
            self._charging_s = at_s
        elif isinstance(fact, PROGRESS):
            self._moved_s = at_s
            if type(fact) is TaskClosed and self._open.pop(fact.task, None) is not None:
                self._done += 1
                self._ended[fact.task] = None
            elif isinstance(fact, OrderFulfilled | OrderDropped):
                self._end_order(fact.order)

    def _forget_those_of(self, agent: str) -> None:
        # The agent does not know its transports; it announces the remaining work under other names.
        for task in [task for task in self._open if self._coordinator[task] == agent]:
            del self._open[task]
        # It does not know either what it has asked others to fetch: when they lose their memory too, no agent does.
        for order in [order for order, asker in self._orders.items() if asker == agent]:
            del self._orders[order]

    def _return_order(self, message: RevocationTaken) -> None:
        """Stop watching a withdrawn order, unless it was released again meanwhile."""
        if message.release > self._returned.get(message.order, 0):
            self._returned[message.order] = message.release
            self._orders.pop(message.order, None)

    def _end_order(self, order: str) -> None:
        self._orders.pop(order, None)
        self._ended_orders[order] = None

    def _note_work(self, heartbeat: AtvHeartbeat, at_s: float) -> None:
        task = heartbeat.task.task if heartbeat.task is not None else ""
        if task not in self._ended:
            self._busy.pop(heartbeat.atv, None)
        elif self._busy.get(heartbeat.atv, ("", 0.0))[0] != task:
            self._busy[heartbeat.atv] = (task, at_s)

    def _look(self, at_s: float) -> None:
        for atv, (task, since_s) in self._busy.items():
            bound_s = self._bounds.settle_s + self._bounds.transport_s
            if at_s - max(since_s, self._since_s) > bound_s:
                seen = f"{atv} still works for {task}, which ended {at_s - since_s:.0f} s ago"
                raise InvariantBroken(1, at_s, seen)
        if not self._open and not self._busy and all(map(self._is_in_vain, self._orders)):
            self.over.set()
            return
        self.over.clear()
        for task, (opened_s, done_before, item) in self._open.items():
            waited_s = at_s - max(opened_s, self._since_s)
            bound_s = self._bounds.task_s(item, self._done - max(done_before, self._done_before))
            bound_s += self._charging_bound_s(opened_s)
            if waited_s > bound_s:
                seen = f"{task} did not end in {waited_s:.0f} s of quiet; its bound is {bound_s:.0f} s"
                raise InvariantBroken(1, at_s, seen)
        stood_s = at_s - self._moved_s
        if stood_s > self._bounds.stall_s + self._charging_bound_s(self._moved_s):
            waiting = ", ".join((*self._orders, *self._open))
            seen = f"nothing came forward in {stood_s:.0f} s of quiet while these were open: {waiting}"
            raise InvariantBroken(1, at_s, seen)

    def _is_in_vain(self, order: str) -> bool:
        """Whether a machine asks to have parts fetched for which no storage has room, whatever is on order."""
        told = self._told.get(order)
        if told is None or told.wait is not TransportWait.NO_ROOM or told.source != self._orders[order]:
            return False
        return all(room < told.quantity for (item, _), room in self._room.items() if item == told.item)

    def _charging_bound_s(self, since_s: float) -> float:
        """Additional time for a bound that counts from that moment."""
        return self._bounds.must_charge_s if self._charging_s >= since_s else 0.0
