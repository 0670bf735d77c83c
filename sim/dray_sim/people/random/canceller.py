"""Customers who change their minds: some orders are cancelled, at any moment of their lives."""

from __future__ import annotations

import asyncio
from collections.abc import Iterable

from dray.messages import CancellationTaken, Message, OrderCancelled
from dray.messages.keys import STRATEGIST
from dray.ports import Bus
from dray_sim.clock.loop import VirtualClock

NAME = "regret"
"""Its name on the bus. The name is in the traces of runs, and so it stays."""

AGAIN_S = 5.0
"""Interval between two repetitions of an unanswered cancellation."""


class Canceller:
    """Cancels orders, each again and again until the strategist has heard it.

    Args:
        bus: joined at once.
        clock: the plant's clock.
        strategists: receive the cancellations.
    """

    def __init__(self, bus: Bus, clock: VirtualClock, strategists: tuple[str, ...] = (STRATEGIST,)) -> None:
        self._session = bus.join(NAME, self._on_message)
        self._clock, self._strategists = clock, strategists
        self._waiting: dict[str, asyncio.Event] = {}

    async def cancel(self, cancellations: Iterable[tuple[float, str]]) -> None:
        """Cancel orders at their times (plant clock); returns when all were heard."""
        async with asyncio.TaskGroup() as group:
            for at_s, order in cancellations:
                await asyncio.sleep(max(0.0, at_s - self._clock.now_s()))
                group.create_task(self._cancel(order))

    async def _cancel(self, order: str) -> None:
        heard = self._waiting[order] = asyncio.Event()
        while not heard.is_set():
            for strategist in self._strategists:
                self._session.send(strategist, OrderCancelled(order=order))
            try:
                await asyncio.wait_for(heard.wait(), AGAIN_S)
            except TimeoutError:
                continue
        del self._waiting[order]

    def _on_message(self, _sender: str, message: Message) -> None:
        if isinstance(message, CancellationTaken) and message.order in self._waiting:
            self._waiting[message.order].set()
