"""The bodies of agents for one life."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager, closing
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from msgspec import Struct
from msgspec.structs import replace

from dray.adapters.documents import DocumentReader, FetchedDocuments
from dray.adapters.journal.sqlite_journal import SqliteJournal
from dray.adapters.memory_file import MemoryFile
from dray.adapters.zenoh.bus import ZenohBus
from dray.ports import Body
from dray.supervision import Failures

_log = logging.getLogger(__name__)

_Kept = TypeVar("_Kept", bound=Struct)

REMIND_EVERY_S = 30.0
"""Seconds between log messages about why an agent does not begin."""

BY_SIGNALS, BY_PEOPLE, BY_CONTROLLER = "a controller with signals", "people", "a controller with a program"
"""Kinds of bodies, each with its own memory (`LastBody`)."""


@dataclass(frozen=True, slots=True)
class Embodied:
    """A body, with its end.

    Attributes:
        body: the agent's; None for one that only talks.
        lost: returns when the body is lost; never, for a body whose absence is only a problem.
        failures: errors in handling its messages.
    """

    body: Body | None
    lost: Callable[[], Awaitable[object]]
    failures: tuple[Failures, ...] = ()


Embody = Callable[[ZenohBus, SqliteJournal], AbstractAsyncContextManager[Embodied]]
"""Creates the body for one life of an agent."""


def remembered(file: MemoryFile[_Kept], name: str) -> _Kept | None:
    """What a body's file has kept; a damaged one is logged. None at its first start.

    Args:
        file: the file.
        name: the agent's id.

    Raises:
        UnavailableError: the file cannot be read.
    """
    kept = file.read()
    if file.lost:
        _log.error("%s: %s", name, file.lost)
    return kept


class LastBody(Struct, frozen=True):
    """The kind of body that an agent had last."""

    kind: str = ""
    """In words, for a sentence; empty for an unknown one."""


def lived(
    folder: Path,
    name: str,
    kind: str,
    file: MemoryFile[_Kept] | None = None,
    *,
    always: bool = False,
) -> _Kept | None:
    """What a body's file has kept, unless the agent has had another kind of body since: then nobody knows what that has counted.

    Args:
        folder: the journal folder.
        name: the agent's id.
        kind: of its present body, in words.
        file: that body's file; None for a body that keeps nothing.
        always: whether what another kind of body has counted is unknown even if there is no file yet.

    Raises:
        UnavailableError: a file cannot be read or written.
    """
    note = MemoryFile(folder / f"{name}.body.json", LastBody, LastBody())
    last = remembered(note, name) or LastBody()
    kept = None
    if file is not None:
        if last.kind not in ("", kind) and (always or file.exists):
            file.outdate(with_doubt(file.damaged, last.kind), f"{last.kind} counted since")
        kept = remembered(file, name)
    if last.kind != kind:
        note.write(LastBody(kind))
    return kept


def with_doubt(damaged: _Kept, kind: str) -> _Kept:
    """The memory after another kind of body.

    Args:
        damaged: the memory after unreadable data.
        kind: of the other body, in words.
    """
    if "doubt" not in damaged.__struct_fields__:
        return damaged
    return replace(damaged, doubt=f"{kind} counted before it; see what is there")


@asynccontextmanager
async def bodiless(_bus: ZenohBus, _journal: SqliteJournal) -> AsyncIterator[Embodied]:
    """The body of an agent that has none."""
    yield Embodied(None, asyncio.Event().wait)


def reading(embody: Embody, folder: Path) -> Embody:
    """A body that also fetches documents and stores them in a folder."""

    @asynccontextmanager
    async def with_documents(bus: ZenohBus, journal: SqliteJournal) -> AsyncIterator[Embodied]:
        with closing(FetchedDocuments(folder)) as documents:
            async with embody(bus, journal) as inner:
                assert inner.body is not None  # noqa: S101 - a machine has one
                yield Embodied(DocumentReader(inner.body, documents), inner.lost, inner.failures)

    return with_documents
