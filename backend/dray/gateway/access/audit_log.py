"""The audit log: what somebody has done, or tried to do, on disk before the answer leaves."""

from __future__ import annotations

import asyncio
import logging
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Annotated, Any, Literal

from fastapi import Depends
from starlette.requests import HTTPConnection

from dray.errors import UnavailableError
from dray.gateway.access.principal import Principal
from dray.store import Store
from dray.store.access.audit import AuditRow

NOTE = "dray.note"
"""Under this name the gate leaves the note of a request."""

TARGET_CHARS = 128
"""As long as the longest id."""

LATER = 10_000
"""Lines of stops that wait for the database, some 10 MB: whoever stops all vehicles of a large plant again and again
has hours until it is full."""

AGAIN_S = 1.0
"""Wall seconds until what could not be written is tried again."""

Result = Literal["done", "refused", "failed"]


@dataclass(slots=True)
class Note:
    """What a router may add to the line that the audit log will have of its request.

    Attributes:
        target: what it was about; else the one id in the path.
        detail: what else is worth knowing; no secret.
        result: when the answer's status does not tell it.
        who: whom it was, where nobody was recognised before.
    """

    target: str = ""
    detail: dict[str, Any] = field(default_factory=dict)
    result: Result | None = None
    who: Principal | None = None
    waits: bool = True
    """Whether the answer waits until the line is on disk; that of a stop does not."""
    elsewhere: bool = False
    """Whether somebody else writes the line."""
    line: Callable[[str], AuditRow] | None = None
    """Makes the line of what is done, given its target, for who writes it in the transaction of what it tells of;
    left by the audit recorder."""
    written: bool = False
    """Whether that has been done: then only something else than `done` is still to be told."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Line:
    """What the audit log is to keep.

    Attributes:
        who: did it, or tried to; None for nobody whom we know.
        address: from where.
        action: what it was, as `vehicle.command`.
        target: what it was about.
        result: what came of it.
        detail: what else is worth knowing; no secret.
        at_s: when it happened (wall clock); None for now.
    """

    who: Principal | None
    address: str
    action: str
    target: str
    result: Result
    detail: dict[str, Any]
    at_s: float | None = None


_log = logging.getLogger(__name__)


class AuditLog:
    """Writes the audit log.

    A line is on disk before its answer leaves, except for stops: their lines wait in memory for as long as the
    database is away, are told to the log at once, and are lost only with the process.

    Args:
        store: where it is kept.
        wall_s: the wall clock.
    """

    def __init__(self, store: Store, wall_s: Callable[[], float]) -> None:
        self._store, self._wall_s = store, wall_s
        self._later: deque[AuditRow] = deque()
        self._more = asyncio.Event()
        self._writing = asyncio.Lock()

    async def write(self, line: Line) -> None:
        """Add a line; it is on disk when this returns."""
        await self._write([self.row(line)])

    def write_later(self, line: Line) -> None:
        """Add a line as soon as the database takes it."""
        row = self.row(line)
        _log.info("%s %s: %s, by %s, %s", row.action, row.target, row.result, row.who, row.detail)
        if len(self._later) >= LATER:
            _log.error("not in the audit log, for which %d lines wait already: %r", LATER, row)
            return
        self._later.append(row)
        self._more.set()

    @property
    def waiting(self) -> int:
        """Lines that wait for the database."""
        return len(self._later)

    async def run(self) -> None:
        """Write what waits, until cancelled."""
        while True:
            await self._more.wait()
            try:
                await self.catch_up()
            except UnavailableError:
                await asyncio.sleep(AGAIN_S)

    async def catch_up(self) -> None:
        """Write what waits.

        Raises:
            UnavailableError: the database does not take it; it goes on waiting.
        """
        async with self._writing:
            while self._later:
                rows = list(self._later)
                await self._write(rows)
                for _ in rows:
                    self._later.popleft()
            self._more.clear()

    def row(self, line: Line) -> AuditRow:
        """A line as it is kept, for who writes it together with what it tells of."""
        return AuditRow(
            at_s=self._wall_s() if line.at_s is None else line.at_s,
            who="" if line.who is None else line.who.id,
            who_kind="nobody" if line.who is None else line.who.kind,
            from_ip=line.address,
            session="" if line.who is None else line.who.session,
            action=line.action,
            # A path may hold a NUL, which PostgreSQL has in no text.
            target=line.target.replace("\0", "")[:TARGET_CHARS],
            result=line.result,
            detail=line.detail,
        )

    async def _write(self, rows: list[AuditRow]) -> None:
        async with self._store.write() as work:
            for row in rows:
                await work.audit.add(row)


def result_of(status: int) -> Result:
    """What an HTTP status tells of what was asked."""
    if status < 400:
        return "done"
    return "refused" if status < 500 else "failed"


def note_of(connection: HTTPConnection) -> Note:
    """The note of a request. Only for routes whose rule has an action."""
    note = connection.scope[NOTE]
    assert isinstance(note, Note)  # noqa: S101 - the gate has left it
    return note


async def _note(connection: HTTPConnection) -> Note:
    return note_of(connection)


Noted = Annotated[Note, Depends(_note)]
"""A router's parameter: see `note_of`."""
