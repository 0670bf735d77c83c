"""Exclusions: agents that people have shut out, in SQL, on the panels and on the bus.

`announced.py` publishes them; `dray shut-out` writes the same table.
"""

from __future__ import annotations

from collections.abc import Callable
from http import HTTPStatus

from dray.gateway.factory.announced import Announced
from dray.gateway.factory.commands import Commands
from dray.gateway.http.problems import Problem, not_found
from dray.gateway.live.projection import Projection
from dray.messages import ShutOut
from dray.messages.shutout import MAX_SHUT_OUT
from dray.store import Store
from dray.store.factory.exclusions import Exclusion


class Exclusions(Announced):
    """Stores and publishes exclusions.

    Args:
        store: the database.
        projection: shows exclusions.
        commands: stops vehicles that are shut out, and stops waiting for their answers.
        say: publishes to all agents.
        wall_s: the wall clock.
        own: this gateway's name on the bus, which it cannot shut out.
    """

    EVERY_S = 2.0
    """Maximum wall seconds in which an agent that joins may hear an excluded one. Costs one small message to
    all agents."""

    WHAT = "who was shut out"

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
        super().__init__(store, wall_s)
        self._projection, self._commands = projection, commands
        self._say, self.own = say, own
        self._list = ShutOut(number=0)

    async def shut_out(self, agent: str, reason: str, by: str) -> Exclusion:
        """Shut an agent out; if it is shut out already, the first decision stays.

        Args:
            agent: its id.
            reason: the person's words.
            by: the person's name.

        Raises:
            Problem: 409, the agent is this gateway, or too many are shut out.
            UnavailableError: it could not be stored, and nothing was done.
        """
        if agent == self.own:
            raise Problem(
                HTTPStatus.CONFLICT,
                "own-gateway",
                "A gateway cannot shut itself out",
                f"{agent} is the gateway that you speak to: its word is needed to shut somebody out; call its "
                "certificate back with `dray certs revoke`",
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
        """Readmit an agent; returns its exclusion.

        Raises:
            Problem: 404, it is not shut out.
            UnavailableError: it could not be stored, and nothing was done.
        """
        async with self._store.write() as work:
            exclusion = await work.exclusions.get(agent)
            if exclusion is None:
                raise not_found("exclusion", agent, "GET /api/agents/shut-out")
            await work.exclusions.end(agent, self._wall_s())
        await self.look()
        return exclusion

    def say(self) -> None:
        """Publish the list, unless nothing was ever decided."""
        if self._list.number:
            self._say(self._list)

    async def restore(self) -> None:
        """See `Announced`. An earlier life has stopped these vehicles: they are not stopped again."""
        self._projection.shut_out(await self._decided())

    async def _read(self) -> None:
        exclusions = await self._decided()
        for each in exclusions:
            if each.agent in self._projection.atvs and each.agent not in self._projection.outsiders:
                self._commands.part_with(each.agent, each.by)
        self._projection.shut_out(exclusions)

    async def _decided(self) -> list[Exclusion]:
        """All decisions, which are said from now on."""
        async with self._store.read() as work:
            exclusions, number = await work.exclusions.all(), await work.exclusions.number()
        self._list = ShutOut(number=number, agents=tuple(each.agent for each in exclusions))
        return exclusions
