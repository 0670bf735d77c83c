"""What people decide and all agents are to know: in SQL, on the panels and on the bus.

A decision is on disk before it is told. From then on the gateway says all that holds again and again: agents remember it while no
gateway is there, and whoever was out of reach hears it soon. What was decided at other gateways, or at a console, is seen in SQL
and told in the same way.
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
        store: keeps them.
        wall_s: the wall clock.

    Attributes:
        EVERY_S: wall seconds between two times that they are said.
        WHAT: they are, in the log.
    """

    EVERY_S: ClassVar[float]
    WHAT: ClassVar[str]

    def __init__(self, store: Store, wall_s: Callable[[], float]) -> None:
        self._store, self._wall_s = store, wall_s
        self._looking = asyncio.Lock()
        """An older look must not end after a newer one."""

    async def restore(self) -> None:
        """Restore what was decided before the gateway was started.

        Raises:
            UnavailableError: the database cannot be read or written.
        """
        await self._read()

    async def look(self) -> None:
        """Read what is decided, end what is over, and tell the rest.

        Raises:
            UnavailableError: the database cannot be read or written.
        """
        async with self._looking:
            await self._read()
            self.say()

    async def run(self) -> None:
        """Look and say, until cancelled; while the database is away, what was read last."""
        await keep_looking(self.look, self.EVERY_S, self._on_away, at_once=True)

    @abstractmethod
    def say(self) -> None:
        """Say what was read last."""

    @abstractmethod
    async def _read(self) -> None:
        """Read what is decided, end what is over, and show the rest."""

    def _on_away(self, error: UnavailableError) -> None:
        _log.info("%s elsewhere is not seen this time: %s", self.WHAT, error)
        self.say()
