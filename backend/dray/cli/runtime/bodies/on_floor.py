"""Bodies on the simulated floor."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from dray.adapters.journal.sqlite_journal import SqliteJournal
from dray.adapters.remote_body import BodySpec, CountedBody, RemoteBody, put_down, tell_moved
from dray.adapters.zenoh.bus import ZenohBus
from dray.body import Drop, Pick
from dray.cli.runtime.bodies.embodied import Embodied, Embody
from dray.cli.runtime.surroundings import Surroundings
from dray.errors import UnavailableError


def on_floor(surroundings: Surroundings, name: str, added: BodySpec | None = None) -> Embody:
    """A body on the floor of the plant.

    Args:
        surroundings: the process's surroundings.
        name: the agent's id.
        added: its body, if the floor's plant file lacks it.
    """

    @asynccontextmanager
    async def embody(bus: ZenohBus, journal: SqliteJournal) -> AsyncIterator[Embodied]:
        plant = surroundings.plant
        if added is not None:
            await put_down(bus.inner, plant.id, added)
        body = RemoteBody(bus.inner, plant.id, name, journal.incarnation)
        await body.connect()
        if body.is_new and journal.memory:
            file = surroundings.settings.journal_folder / f"{name}.db"
            remedy = "move away the journals of all agents whose bodies are on that floor"
            raise UnavailableError(
                f"the body that {file} is about", "is gone, for the floor has begun anew", remedy
            )
        yield Embodied(body, body.lost)

    return embody


def counted_on_floor(surroundings: Surroundings, name: str, embody: Embody) -> Embody:
    """The body of a real vehicle at simulated places: the floor counts its picks and drops.

    Args:
        surroundings: the process's surroundings.
        name: the agent's id.
        embody: creates the vehicle's own body.
    """

    @asynccontextmanager
    async def with_floor(bus: ZenohBus, journal: SqliteJournal) -> AsyncIterator[Embodied]:
        session, plant, life = bus.inner, surroundings.plant.id, journal.incarnation
        await tell_moved(session, plant, name, life)

        async def tell(done: Pick | Drop) -> str:
            return await tell_moved(session, plant, name, life, done)

        async with embody(bus, journal) as inner:
            assert inner.body is not None  # noqa: S101 - a vehicle has one
            body = CountedBody(name, inner.body, tell)
            telling = asyncio.ensure_future(body.run())
            gone = asyncio.ensure_future(inner.lost())

            async def lost() -> None:
                ended, _ = await asyncio.wait((telling, gone), return_when=asyncio.FIRST_COMPLETED)
                for each in ended:
                    each.result()

            try:
                yield Embodied(body, lost, inner.failures)
            finally:
                for each in (telling, gone):
                    each.cancel()
                await asyncio.gather(telling, gone, return_exceptions=True)

    return with_floor
