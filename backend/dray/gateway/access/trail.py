"""The trail: what somebody has done, or tried to do, on disk before the answer leaves."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Annotated, Any, Literal

from fastapi import Depends
from starlette.requests import HTTPConnection

from dray.gateway.access.principal import Principal
from dray.store import Store
from dray.store.audit import AuditRow

NOTE = "dray.note"
"""Under this name the gate leaves the note of a request."""

PRUNED_EVERY = 1000
"""Lines between two looks at how many there are."""

TARGET_CHARS = 128
"""As long as the longest id."""

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


class Trail:
    """Writes the audit log.

    Args:
        store: where it is kept.
        wall_s: the wall clock.
        keep: how many lines are kept.
    """

    def __init__(self, store: Store, wall_s: Callable[[], float], keep: int) -> None:
        self._store, self._wall_s, self._keep = store, wall_s, keep

    async def write(
        self,
        *,
        who: Principal | None,
        address: str,
        action: str,
        target: str,
        result: Result,
        detail: dict[str, Any],
    ) -> None:
        """Add a line; it is on disk when this returns."""
        row = AuditRow(
            at_s=self._wall_s(),
            who="" if who is None else who.id,
            who_kind="nobody" if who is None else who.kind,
            from_ip=address,
            session="" if who is None else who.session,
            action=action,
            # A path may hold a NUL, which PostgreSQL has in no text.
            target=target.replace("\0", "")[:TARGET_CHARS],
            result=result,
            detail=detail,
        )
        async with self._store.write() as work:
            position = await work.audit.add(row)
            if position % PRUNED_EVERY == 0:
                await work.audit.prune(self._keep)


def result_of(status: int) -> Result:
    """What an HTTP status tells of what was asked."""
    if status < 400:
        return "done"
    return "refused" if status < 500 else "failed"


def _note(connection: HTTPConnection) -> Note:
    note = connection.scope[NOTE]
    assert isinstance(note, Note)  # noqa: S101 - the gate has left it
    return note


Noted = Annotated[Note, Depends(_note)]
"""A router's parameter: the note of its request. Only for routes whose rule has an action."""
