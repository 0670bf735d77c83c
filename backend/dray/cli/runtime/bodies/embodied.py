"""Bodies of agents: what a life of an agent is given."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager, closing
from dataclasses import dataclass
from pathlib import Path

from dray.adapters.documents import DocumentReader, FetchedDocuments
from dray.adapters.journal.sqlite_journal import SqliteJournal
from dray.adapters.zenoh.bus import ZenohBus
from dray.ports import Body
from dray.supervision import Failures

REMIND_EVERY_S = 30.0
"""How often it is said why an agent does not begin."""


@dataclass(frozen=True, slots=True)
class Embodied:
    """A body, and who tells when it is lost.

    Attributes:
        body: the agent's; None for one that only talks.
        lost: returns when it is there no more; never, for one whose absence is a problem and no end.
        failures: of those who hear what it says.
    """

    body: Body | None
    lost: Callable[[], Awaitable[object]]
    failures: tuple[Failures, ...] = ()


Embody = Callable[[ZenohBus, SqliteJournal], AbstractAsyncContextManager[Embodied]]
"""Makes the body of one life of an agent."""


@asynccontextmanager
async def bodiless(_bus: ZenohBus, _journal: SqliteJournal) -> AsyncIterator[Embodied]:
    """The body of an agent that has none."""
    yield Embodied(None, asyncio.Event().wait)


def reading(embody: Embody, folder: Path) -> Embody:
    """A body that fetches documents and lays them ready in a folder."""

    @asynccontextmanager
    async def with_documents(bus: ZenohBus, journal: SqliteJournal) -> AsyncIterator[Embodied]:
        with closing(FetchedDocuments(folder)) as documents:
            async with embody(bus, journal) as inner:
                assert inner.body is not None  # noqa: S101 - a machine has one
                yield Embodied(DocumentReader(inner.body, documents), inner.lost, inner.failures)

    return with_documents
