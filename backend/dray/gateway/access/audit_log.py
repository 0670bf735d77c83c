"""The audit log: actions and attempts, on disk before the answer is sent."""

from __future__ import annotations

import asyncio
import logging
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import islice
from typing import Annotated, Any, Literal

from fastapi import Depends
from starlette.requests import HTTPConnection

from dray.errors import UnavailableError
from dray.gateway.access.principal import Principal
from dray.store import Store
from dray.store.access.audit import AuditLines, AuditRow

NOTE = "dray.note"
"""Scope key of a request's note, set by the gate."""

TARGET_CHARS = 128
"""Maximum characters of a target: the longest id."""

LATER = 10_000
"""Maximum waiting lines of stops, some 10 MB: hours of repeated stops of all vehicles of a large plant."""

AGAIN_S = 1.0
"""Wall seconds before a failed write is retried."""

CAUGHT_UP = 500
"""Maximum waiting lines in one transaction: others who write wait for it, some milliseconds."""

Result = Literal["done", "refused", "failed"]


@dataclass(slots=True)
class Note:
    """A router's additions to the audit log line of its request.

    Attributes:
        target: the subject; else the one id in the path.
        detail: further facts; no secrets.
        result: the result, if the answer's status does not tell it.
        who: the caller, if nobody was recognised before.
    """

    target: str = ""
    detail: dict[str, Any] = field(default_factory=dict)
    result: Result | None = None
    who: Principal | None = None
    waits: bool = True
    """Whether the answer waits until the line is on disk; False for a stop."""
    elsewhere: bool = False
    """Whether the line is written elsewhere."""
    line: Callable[[str], AuditRow] | None = None
    """Makes the line for a given target, for code that writes it in the action's own transaction; set by the
    audit recorder."""
    written: bool = False
    """Whether that was done: then only results other than `done` are still written."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Line:
    """An entry for the audit log.

    Attributes:
        who: the caller; None if unknown.
        address: the caller's address.
        action: the action, as `vehicle.command`.
        target: its subject.
        result: its result.
        detail: further facts; no secrets.
        at_s: its time (wall clock); None for now.
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

    A line is on disk before its answer is sent, except for stops. Their lines wait in memory while the
    database is away, go to the program's log at once, and are lost only with the process.

    Args:
        store: the database.
        wall_s: the wall clock.
    """

    def __init__(self, store: Store, wall_s: Callable[[], float]) -> None:
        self._lines, self._wall_s = AuditLines(store.database), wall_s
        self._later: deque[AuditRow] = deque()
        self._written = 0
        """Number of lines written later than their answers."""
        self._more = asyncio.Event()
        self._writing = asyncio.Lock()

    async def write(self, line: Line) -> None:
        """Write a line; it is on disk when this returns."""
        await self._lines.add(self.row(line))

    def write_later(self, line: Line) -> None:
        """Queue a line until the database takes it."""
        row = self.row(line)
        _log.info("%s %s: %s, by %s, %s", row.action, row.target, row.result, row.who, row.detail)
        if len(self._later) >= LATER:
            _log.error("not in the audit log, for which %d lines wait already: %r", LATER, row)
            return
        self._later.append(row)
        self._more.set()

    @property
    def waiting(self) -> int:
        """Number of lines waiting for the database."""
        return len(self._later)

    async def run(self) -> None:
        """Write waiting lines until cancelled."""
        while True:
            await self._more.wait()
            try:
                await self.catch_up()
            except UnavailableError:
                await asyncio.sleep(AGAIN_S)

    async def catch_up(self) -> None:
        """Write all lines that wait now. Lines that come meanwhile are not waited for: they might come without end.

        Raises:
            UnavailableError: the database is away; the lines go on waiting.
        """
        upto = self._written + len(self._later)
        while self._written < upto:
            # A transaction that has begun ends even if its caller is cancelled: else its lines came twice.
            await asyncio.shield(self._write_some(upto))

    async def _write_some(self, upto: int) -> None:
        async with self._writing:
            if self._written >= upto:
                return  # Another one has written them.
            rows = list(islice(self._later, CAUGHT_UP))
            await self._lines.add_all(rows)
            for _ in rows:
                self._later.popleft()
            self._written += len(rows)
            if not self._later:
                self._more.clear()

    def row(self, line: Line) -> AuditRow:
        """A line as a row, for code that writes it in the action's own transaction."""
        return AuditRow(
            at_s=self._wall_s() if line.at_s is None else line.at_s,
            who="" if line.who is None else line.who.id,
            who_kind="nobody" if line.who is None else line.who.kind,
            from_ip=line.address,
            session="" if line.who is None else line.who.session,
            action=line.action,
            # A path may hold a NUL, which PostgreSQL text cannot.
            target=line.target.replace("\0", "")[:TARGET_CHARS],
            result=line.result,
            detail=line.detail,
        )


def result_of(status: int) -> Result:
    """The result that an HTTP status stands for."""
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
