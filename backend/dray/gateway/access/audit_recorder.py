"""The audit recorder: writes a line for every request that changes something, before its answer is sent.

If the line cannot be written, the answer says so, although the action may have been done. The answer to a
stop does not wait for a disk: its line is written as soon as possible (`AuditLog.write_later`).
"""

from __future__ import annotations

import logging
from http import HTTPStatus
from typing import Any

from starlette.types import Message, Receive, Scope, Send

from dray.errors import UnavailableError
from dray.gateway.access.access import Access
from dray.gateway.access.audit_log import AuditLog, Line, Note, Result, result_of
from dray.gateway.http.problems import Problem
from dray.gateway.http.provided import provided
from dray.store.access.audit import AuditRow

_log = logging.getLogger(__name__)


class AuditRecorder:
    """Stands between a request and its answer.

    Args:
        scope: the request's scope.
        receive: the request's receiver.
        send: takes the answer.
        action: its name in the audit log.
        note: the router's note; nothing is written while it has neither a caller nor a result.
    """

    def __init__(self, scope: Scope, receive: Receive, send: Send, action: str, note: Note) -> None:
        self._scope, self._receive, self._send = scope, receive, send
        self._action, self._note = action, note
        note.line = self._done
        self._lost = False
        """Whether the line could not be written, so that the caller got that answer instead."""

    async def send(self, message: Message) -> None:
        """Pass an answer on once its line is on disk."""
        if message["type"] == "http.response.start":
            await self._record(message["status"])
        if not self._lost:
            await self._send(message)

    async def failed(self) -> None:
        """Record a request without an answer: a bug of ours."""
        try:
            await self._write("failed", HTTPStatus.INTERNAL_SERVER_ERROR)
        except UnavailableError as error:
            self._tell_the_log(error)

    async def _record(self, status: int) -> None:
        try:
            await self._write(self._note.result or result_of(status), status)
        except UnavailableError as error:
            if status >= HTTPStatus.INTERNAL_SERVER_ERROR:
                return  # Nothing was done; the answer says so, and the outage is logged already.
            self._tell_the_log(error)
            self._lost = True
            problem = Problem(
                HTTPStatus.SERVICE_UNAVAILABLE,
                "not-recorded",
                "It could not be written down",
                "it may have been done, but the database does not take the line that says so; look, and try again",
                headers={"Retry-After": "5"},
            )
            await problem.response(self._scope["path"])(self._scope, self._receive, self._send)

    async def _write(self, result: Result, status: int) -> None:
        note = self._note
        if (
            note.elsewhere
            or (note.who is None and note.result is None)
            or (note.written and result == "done")
        ):
            return
        detail = note.detail if status < HTTPStatus.BAD_REQUEST else note.detail | {"status": status}
        line = self._line(note.target, result, detail)
        if note.waits:
            await self._audit_log.write(line)
        else:
            self._audit_log.write_later(line)

    def _done(self, target: str) -> AuditRow:
        return self._audit_log.row(self._line(target, "done", self._note.detail))

    def _line(self, target: str, result: Result, detail: dict[str, Any]) -> Line:
        return Line(
            who=self._note.who,
            address=address_of(self._scope),
            action=self._action,
            target=target,
            result=result,
            detail=detail,
        )

    @property
    def _audit_log(self) -> AuditLog:
        return provided(self._scope["app"], Access).audit_log

    def _tell_the_log(self, error: UnavailableError) -> None:
        who = "nobody" if self._note.who is None else self._note.who.id
        _log.error(
            "not in the audit log: %s by %s, about %s: %s",
            self._action,
            who,
            self._note.target or "nothing",
            error.reason,
        )


def address_of(scope: Scope) -> str:
    """The client's address; empty if unknown."""
    client = scope.get("client")
    return str(client[0]) if client else ""
