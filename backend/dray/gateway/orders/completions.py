"""Orders ended by the strategist, fulfilled or given back: stored, and only then no longer asked for.

A crash in between loses nothing: the outbox asks until the answer is on disk, and the strategist repeats its
answer each time. By then, facts about the last pieces have marked most orders as delivered. The strategist's
answer ends orders whose facts are late or lost.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable

from dray.errors import UnavailableError
from dray.gateway.live.projection import Projection
from dray.gateway.orders.outbox import Outbox
from dray.messages import OrderTaken, RevocationTaken
from dray.store import Store
from dray.store.orders.progress import Goal, progress
from dray.store.work import Work

Ending = OrderTaken | RevocationTaken
"""The strategist's answer about an order that it has ended or changed."""

_log = logging.getLogger(__name__)


class Completions:
    """Stores the strategist's answers.

    Args:
        store: the database.
        outbox: asks the strategist.
        projection: shows the orders.
        wall_s: the wall clock.
    """

    def __init__(
        self, store: Store, outbox: Outbox, projection: Projection, wall_s: Callable[[], float]
    ) -> None:
        self._store, self._outbox, self._projection, self._wall_s = store, outbox, projection, wall_s
        self._heard: dict[str, Ending] = {}
        """Answers to write, by order: bounded by the orders asked for."""
        self._news, self._written = asyncio.Event(), asyncio.Event()
        self._written.set()

    async def written(self) -> None:
        """Wait until every answer is written, or has failed to be."""
        await self._written.wait()

    def on_answer(self, answer: Ending) -> bool:
        """Take an answer; returns whether the outbox still awaits it."""
        if not self._outbox.awaits(answer):
            return False
        self._heard[answer.order] = answer
        self._written.clear()
        self._news.set()
        return True

    async def run(self) -> None:
        """Write until cancelled."""
        while True:
            await self._news.wait()
            self._news.clear()
            while self._heard:
                _, answer = self._heard.popitem()
                try:
                    await self._write(answer)
                except UnavailableError as error:
                    # The outbox asks again in some seconds.
                    _log.warning("how order %s has ended cannot be written: %s", answer.order, error)
            self._written.set()

    async def _write(self, answer: Ending) -> None:
        now_s = self._wall_s()
        async with self._store.write() as work:
            goals: list[Goal] = []
            if isinstance(answer, RevocationTaken):
                await work.orders.store(answer.order, answer.release, answer.outstanding, now_s)
            else:
                goals = await self._settle(work, answer, now_s)
                if answer.fulfilled:
                    await work.orders.fulfil(answer.order, answer.release, now_s)
            order = await work.orders.get(answer.order)
        if order is not None:
            self._projection.orders.put(order, goals)
            if isinstance(answer, OrderTaken) and not answer.fulfilled and answer.change > order.change:
                # Nobody has made this change: a thief of a gateway's certificate has stated it. The strategist believes the order's own
                # change when it was repeated for long enough.
                return
        self._outbox.answered(answer)

    async def _settle(self, work: Work, answer: OrderTaken, now_s: float) -> list[Goal]:
        """Store the outcome of a change and the order's progress; returns its goals, if it was one."""
        about = (answer.order, answer.release, answer.change, answer.quantities)
        if not await work.order_changes.settle(*about, now_s):
            return []
        order = await work.orders.get(answer.order)
        if order is None:
            return []
        goals = (await work.goals.of_orders([order.id]))[order.id]
        reached = progress(order.quantities, goals, order.incarnation, order.delivered)
        await work.orders.advance(order, reached, now_s)
        return goals
