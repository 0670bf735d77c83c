"""The customers' side in a simulated run: places the demand and notes its results."""

from __future__ import annotations

import asyncio
from collections.abc import Iterable

from dray.messages import Message, OrderReleased, OrderTaken
from dray.messages.keys import STRATEGIST
from dray.ports import Bus, Clock
from dray_sim.people.demand import Order

ORDER_CLIENT = "desk"
"""Its name on the bus. Random generators are seeded with it: another name would be another run of every seed."""

REPEAT_S = 5.0
"""Interval between two repetitions of an unanswered order."""


class OrderClient:
    """Sends every order at its time, and again until the strategist has it.

    Args:
        bus: joined as `ORDER_CLIENT`.
        clock: the plant's clock.
        strategists: receive the orders.
    """

    def __init__(self, bus: Bus, clock: Clock, strategists: tuple[str, ...] = (STRATEGIST,)) -> None:
        self._session = bus.join(ORDER_CLIENT, self._on_message)
        self._clock, self._strategists = clock, strategists
        self._waiting: dict[str, asyncio.Event] = {}

    async def place(self, demand: Iterable[Order]) -> None:
        """Place the whole demand; returns when the last order was taken."""
        async with asyncio.TaskGroup() as group:
            for order in demand:
                await asyncio.sleep(max(0.0, order.at_s - self._clock.now_s()))
                group.create_task(self.order(order))

    async def order(self, order: Order) -> None:
        """Place one order now; returns when it was taken."""
        taken = self._waiting[order.id] = asyncio.Event()
        release = OrderReleased(order=order.id, items=order.items, due_s=order.wanted_s)
        while not taken.is_set():
            for strategist in self._strategists:
                self._session.send(strategist, release)
            try:
                await asyncio.wait_for(taken.wait(), REPEAT_S)
            except TimeoutError:
                continue
        del self._waiting[order.id]

    def _on_message(self, _sender: str, message: Message) -> None:
        if isinstance(message, OrderTaken) and message.order in self._waiting:
            self._waiting[message.order].set()
