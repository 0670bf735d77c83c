"""People's decisions that all agents need: in SQL, on the panels and on the bus.

A decision is on disk before it is published. The gateway then repeats all valid decisions: agents remember
them without a gateway, and an agent out of reach hears them later. Decisions made at other gateways or a
console are read from SQL and published alike.
"""

from __future__ import annotations

import asyncio
import logging
from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import ClassVar

from dray.errors import UnavailableError
from dray.store import Store
from dray.supervision import keep_looking

_log = logging.getLogger(__name__)


class Announced(ABC):
    """Decisions of one kind.

    Args:
        store: the database.
        wall_s: the wall clock.

    Attributes:
        EVERY_S: wall seconds between two publications.
        WHAT: a name for these decisions in the log.
    """

    EVERY_S: ClassVar[float]
    WHAT: ClassVar[str]

    def __init__(self, store: Store, wall_s: Callable[[], float]) -> None:
        self._store, self._wall_s = store, wall_s
        self._looking = asyncio.Lock()
        """Keeps an older look from ending after a newer one."""

    async def restore(self) -> None:
        """Restore decisions from before the gateway's start.

        Raises:
            UnavailableError: the database cannot be read or written.
        """
        await self._read()

    async def look(self) -> None:
        """Read the decisions, end expired ones, and publish the rest.

        Raises:
            UnavailableError: the database cannot be read or written.
        """
        async with self._looking:
            await self._read()
            self.say()

    async def run(self) -> None:
        """Look and publish until cancelled; without a database, publish what was read last."""
        await keep_looking(self.look, self.EVERY_S, self._on_away, at_once=True)

    @abstractmethod
    def say(self) -> None:
        """Publish what was read last."""

    @abstractmethod
    async def _read(self) -> None:
        """Read the decisions, end expired ones, and show the rest."""

    def _on_away(self, error: UnavailableError) -> None:
        _log.info("%s elsewhere is not seen this time: %s", self.WHAT, error)
        self.say()
