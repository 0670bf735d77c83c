"""Exclusions: whom people have shut out, in SQL, on the panels and on the bus.

A decision is on disk before it is told. From then on the gateway says the whole list again and again: agents
remember it while no gateway is there, and whoever joins later hears it soon. What was decided at other gateways,
or with `dray shut-out`, is seen in SQL and told in the same way.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable
from http import HTTPStatus

from dray.errors import UnavailableError
from dray.gateway.factory.commands import Commands
from dray.gateway.http.problems import Problem, not_found
from dray.gateway.live.projection import Projection
from dray.messages import ShutOut
from dray.messages.shutout import MAX_SHUT_OUT
from dray.store import Store
from dray.store.factory.exclusions import Exclusion
from dray.supervision import keep_looking

SAY_EVERY_S = 2.0
"""Wall seconds between two times that the list is said: so long an agent that has just joined for the first time may
hear somebody who is shut out. It costs one small message to everybody."""

_log = logging.getLogger(__name__)


class Exclusions:
    """Takes decisions, and tells them.

    Args:
        store: keeps them.
        projection: shows them.
        commands: stops vehicles that are shut out, and expects nothing of them any more.
        say: says something to everybody.
        wall_s: the wall clock.
        own: the name of this gateway on the bus, which it cannot shut out.
    """

    def __init__(
        self,
        store: Store,
        projection: Projection,
        commands: Commands,
        say: Callable[[ShutOut], None],
        *,
        wall_s: Callable[[], float],
        own: str,
    ) -> None:
        self._store, self._projection, self._commands = store, projection, commands
        self._say, self._wall_s, self.own = say, wall_s, own
        self._list = ShutOut(number=0)
        self._looking = asyncio.Lock()
        """An older look must not end after a newer one."""

    async def restore(self) -> None:
        """Restore what was decided before the gateway was started.

        Raises:
            UnavailableError: the database cannot be read.
        """
        exclusions = await self._read()
        self._projection.shut_out(exclusions)

    async def shut_out(self, agent: str, reason: str, by: str) -> Exclusion:
        """Let nobody hear an agent any more; of one that is shut out already the first decision stays.

        Args:
            agent: its id.
            reason: in the words of who decides it.
            by: that person's name.

        Raises:
            Problem: 409, it is this gateway, or too many are shut out.
            UnavailableError: it could not be written down, and nothing was done.
        """
        if agent == self.own:
            raise Problem(
                HTTPStatus.CONFLICT,
                "own-gateway",
                "A gateway cannot shut itself out",
                f"{agent} is the gateway that you speak to: its word is needed to shut somebody out; ask another "
                "gateway, or call its certificate back with `dray certs revoke`",
            )
        async with self._store.write() as work:
            exclusion = await work.exclusions.get(agent)
            if exclusion is None:
                if len(await work.exclusions.all()) >= MAX_SHUT_OUT:
                    raise Problem(
                        HTTPStatus.CONFLICT,
                        "too-many-shut-out",
                        "Too many agents are shut out",
                        f"{MAX_SHUT_OUT} are, and a list holds no more; readmit some, or call certificates back",
                    )
                exclusion = Exclusion(agent, reason, by, self._wall_s())
                await work.exclusions.put(exclusion)
        await self.look()
        return exclusion

    async def readmit(self, agent: str) -> Exclusion:
        """Hear an agent again; returns why it was shut out.

        Raises:
            Problem: 404, it is not shut out.
            UnavailableError: it could not be written down, and nothing was done.
        """
        async with self._store.write() as work:
            exclusion = await work.exclusions.get(agent)
            if exclusion is None:
                raise not_found("exclusion", agent, "GET /api/agents/shut-out")
            await work.exclusions.end(agent, self._wall_s())
        await self.look()
        return exclusion

    async def look(self) -> None:
        """Read what is decided, and tell it.

        Raises:
            UnavailableError: the database cannot be read.
        """
        async with self._looking:
            exclusions = await self._read()
            for each in exclusions:
                if each.agent in self._projection.atvs and each.agent not in self._projection.outsiders:
                    self._commands.part_with(each.agent, each.by)
            self.say()
            self._projection.shut_out(exclusions)

    def say(self) -> None:
        """Say the list, unless nothing was ever decided."""
        if self._list.number:
            self._say(self._list)

    async def run(self) -> None:
        """Look and say, until cancelled; while the database is away, what was read last."""
        await keep_looking(self.look, SAY_EVERY_S, self._on_away, at_once=True)

    def _on_away(self, error: UnavailableError) -> None:
        _log.info("who was shut out elsewhere is not seen this time: %s", error)
        self.say()

    async def _read(self) -> list[Exclusion]:
        async with self._store.read() as work:
            exclusions, number = await work.exclusions.all(), await work.exclusions.number()
        self._list = ShutOut(number=number, agents=tuple(each.agent for each in exclusions))
        return exclusions
