"""The gate: every request passes it before its router runs or its body is read.

It looks up the rule, recognises the caller, and refuses what is not allowed.
"""

from __future__ import annotations

from http import HTTPStatus
from urllib.parse import quote

from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import HTTPConnection
from starlette.responses import RedirectResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from dray.errors import UnavailableError
from dray.gateway.access.access import Access
from dray.gateway.access.audit_log import NOTE, Note
from dray.gateway.access.audit_recorder import AuditRecorder, address_of
from dray.gateway.access.caller import admit
from dray.gateway.access.principal import Over, Principal
from dray.gateway.access.principal import Scope as Right
from dray.gateway.access.rules import Found, find
from dray.gateway.http.problems import CHALLENGE, Problem
from dray.gateway.http.provided import provided

COOKIE = "dray_session"

LOGIN = "/login"

CLOSE_CODES = {
    HTTPStatus.UNAUTHORIZED: 4401,
    HTTPStatus.FORBIDDEN: 4403,
    HTTPStatus.UNPROCESSABLE_ENTITY: 4422,
}
"""Close codes of a refused stream: browsers hide a handshake's status, but show a close code."""

LOGIN_TELLS = {HTTPStatus.UNAUTHORIZED, HTTPStatus.SERVICE_UNAVAILABLE}
"""Refusals that the login page shows a person, before it leads on to the wanted page."""

TRY_LATER = 1013
"""RFC 6455's registry: the server is unable at the moment."""


class Gate:
    """Recognises callers, and refuses what the rules do not allow."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        found = None if scope["type"] == "lifespan" else _row(scope)
        if found is None:
            # The route does not exist, or `caller.admitted` refuses it.
            await self._app(scope, receive, send)
            return
        note = scope[NOTE] = Note(target=next(iter(found.parameters.values()), ""))
        if not found.rule.public:
            send = _kept_private(send)
        if not found.rule.action:
            await self._pass(scope, receive, send, found, note)
            return
        recorder = AuditRecorder(scope, receive, send, found.rule.action, note)
        try:
            await self._pass(scope, receive, recorder.send, found, note)
        except Exception:
            await recorder.failed()
            raise

    async def _pass(self, scope: Scope, receive: Receive, send: Send, found: Found, note: Note) -> None:
        try:
            if not found.rule.public:
                note.who = await recognise(HTTPConnection(scope), found)
                if note.who.over:
                    note.detail["session_over"] = note.who.over.value
                allow(note.who, found)
        except Problem as problem:
            await refuse(problem, scope, receive, send)
            return
        admit(scope, found, note.who)
        await self._app(scope, receive, send)


async def recognise(connection: HTTPConnection, found: Found) -> Principal:
    """The caller. A token in the address does not count: addresses end up in logs and histories.

    A stop does not wait for a database: while it is away, a caller known before may still stop vehicles.

    Raises:
        Problem: 401, unknown caller; 429, too many unknown tokens; 503, the database is away.
    """
    access = provided(connection.app, Access)
    credentials = connection.headers.get("authorization", "")
    cookie = "" if credentials else connection.cookies.get(COOKIE, "")
    try:
        if credentials:
            kind, _, token = credentials.partition(" ")
            if kind.lower() != "bearer":
                raise unknown("the credentials are not called Bearer")
            principal = await access.by_bearer(token.strip(), address_of(connection.scope))
        elif cookie:
            principal = await access.sessions.recognise(cookie)
        else:
            raise unknown("nobody is logged in")
    except UnavailableError as error:
        stops = found.rule.scope is Right.VEHICLES_STOP and not credentials
        principal = access.sessions.remembered(cookie, access.wall_s()) if stops else None
        if principal is None:
            raise Problem(
                HTTPStatus.SERVICE_UNAVAILABLE,
                "not-ready",
                "Not ready",
                "the database does not answer, so nobody can be recognised; try again",
                headers={"Retry-After": "5"},
            ) from error
    if principal is None:
        raise unknown("these credentials are not valid, or not any more")
    return principal


def allow(principal: Principal, found: Found) -> None:
    """Admit a caller whom the rule allows.

    Raises:
        Problem: as in `missing`; 403 when the route concerns more than the caller's areas.
    """
    rule = found.rule
    if rule.scope is None:
        if principal.over:
            raise session_over(principal.over)
    elif not principal.may(rule.scope):
        raise missing(principal, rule.scope)
    if principal.areas is not None and not rule.by_area:
        raise forbidden("it is about the whole plant, and you are limited to areas")


def missing(principal: Principal, scope: Right) -> Problem:
    """The problem of a missing scope: 403, or 401 if a login would restore it."""
    if principal.over:
        return session_over(principal.over)
    return forbidden(f"{principal.name} lacks the scope {scope.value}")


def unknown(detail: str) -> Problem:
    """The problem of an unknown caller."""
    return Problem(
        HTTPStatus.UNAUTHORIZED,
        "not-logged-in",
        "Who are you?",
        f"{detail}; log in at /login, or send Authorization: Bearer TOKEN",
        headers=CHALLENGE,
    )


OVER = {
    Over.RUN_OUT: ("session-run-out", "Your session has run out of time"),
    Over.REPLACED: ("session-replaced", "You have logged in elsewhere"),
}
"""Kind and title of the problem, by why a session is over."""


def session_over(why: Over) -> Problem:
    """The problem of a session that is over but not revoked: a panel still offers a stop."""
    kind, title = OVER[why]
    detail = "a stop still passes; for everything else log in at /login"
    return Problem(HTTPStatus.UNAUTHORIZED, kind, title, detail, headers=CHALLENGE)


def forbidden(detail: str) -> Problem:
    """The problem of a caller who may not do this."""
    return Problem(HTTPStatus.FORBIDDEN, "not-allowed", "You may not do this", detail)


def _row(scope: Scope) -> Found | None:
    return find(scope.get("method", "GET"), scope["path"])


def _kept_private(send: Send) -> Send:
    """Keep caches from storing answers to recognised callers."""

    async def private(message: Message) -> None:
        if message["type"] == "http.response.start":
            MutableHeaders(scope=message).setdefault("Cache-Control", "no-store")
        await send(message)

    return private


async def refuse(problem: Problem, scope: Scope, receive: Receive, send: Send) -> None:
    """Answer with a problem, to a program, a browser, or a starting stream."""
    if scope["type"] == "websocket":
        await receive()
        await send({"type": "websocket.accept"})
        code = CLOSE_CODES.get(HTTPStatus(problem.status), TRY_LATER)
        await send({"type": "websocket.close", "code": code, "reason": problem.title})
    elif problem.status in LOGIN_TELLS and wants_page(scope):
        await RedirectResponse(_login_for(scope), HTTPStatus.SEE_OTHER)(scope, receive, send)
    elif problem.status == HTTPStatus.FORBIDDEN and scope["method"] == "GET" and wants_page(scope):
        # Probably a link from somebody with more rights: the reader's own panel helps more than an error.
        await RedirectResponse("/", HTTPStatus.SEE_OTHER)(scope, receive, send)
    else:
        await problem.response(scope["path"])(scope, receive, send)


def wants_page(scope: Scope) -> bool:
    """Whether the client is a person's browser."""
    return not scope["path"].startswith("/api/") and "text/html" in Headers(scope=scope).get("accept", "")


def _login_for(scope: Scope) -> str:
    """The login page's address, which leads back to this request."""
    if scope["method"] != "GET":
        return LOGIN
    query = scope["query_string"].decode("latin-1")
    return f"{LOGIN}?next={quote(scope['path'] + ('?' + query if query else ''), safe='')}"
