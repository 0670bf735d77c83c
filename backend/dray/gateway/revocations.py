"""Orders that the strategist has given back: written down, and only then not asked for any more.

Whatever dies in between, nothing is lost: the desk asks until the answer is on disk, and the strategist gives
the same answer as often as it is asked.
"""

from __future__ import annotations

import asyncio
import logging

from dray.errors import UnavailableError
from dray.gateway.desk import Desk
from dray.gateway.projection import Projection
from dray.messages import RevocationTaken
from dray.store import Store

_log = logging.getLogger(__name__)


class Revocations:
    """Writes down what the strategist answers.

    Args:
        store: where to.
        desk: who has asked.
        projection: who shows it.
    """

    def __init__(self, store: Store, desk: Desk, projection: Projection) -> None:
        self._store, self._desk, self._projection = store, desk, projection
        self._heard: dict[str, RevocationTaken] = {}
        """By order, what is to be written: bounded by the orders that are being taken back."""
        self._news, self._written = asyncio.Event(), asyncio.Event()
        self._written.set()

    async def written(self) -> None:
        """Wait until everything that has been heard is written, or has failed to be."""
        await self._written.wait()

    def hear(self, answer: RevocationTaken) -> bool:
        """Take an answer; returns whether the desk has asked for it and it is not written yet."""
        if not self._desk.revokes(answer.order, answer.release):
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
                    # The desk asks again in some seconds.
                    _log.warning("order %s is taken back, which cannot be written: %s", answer.order, error)
            self._written.set()

    async def _write(self, answer: RevocationTaken) -> None:
        async with self._store.write() as work:
            await work.orders.store(answer.order, answer.release, answer.outstanding)
            order = await work.orders.get(answer.order)
        if order is not None:
            self._projection.orders.put(order)
        self._desk.returned(answer.order, answer.release)
