"""The gate: every request passes it before a router, or its body, is looked at."""

from __future__ import annotations

import hmac
from http import HTTPStatus

from starlette.requests import HTTPConnection
from starlette.types import ASGIApp, Receive, Scope, Send

from dray.gateway.access.caller import admit
from dray.gateway.access.principal import ADMIN, Principal
from dray.gateway.access.rules import Found, find
from dray.gateway.parts import parts_of
from dray.gateway.problems import Problem


class Gate:
    """Recognises who asks, and refuses what the rules do not allow."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "lifespan":
            try:
                self._judge(scope)
            except Problem as problem:
                await problem.response(scope["path"])(scope, receive, send)
                return
        await self._app(scope, receive, send)

    def _judge(self, scope: Scope) -> None:
        found = find(scope.get("method", "GET"), scope["path"])
        if found is None:
            return
        principal = None if found.rule.public else recognise(HTTPConnection(scope))
        if principal is not None:
            allow(principal, found)
        admit(scope, found, principal)


def recognise(connection: HTTPConnection) -> Principal:
    """Who asks.

    Raises:
        Problem: 401, it cannot be said.
    """
    kind, _, token = connection.headers.get("authorization", "").partition(" ")
    if not kind:
        return ADMIN
    wanted = parts_of(connection).settings.admin_token
    if kind.lower() == "bearer" and wanted is not None:
        if hmac.compare_digest(token.strip().encode(), wanted.get_secret_value().encode()):
            return ADMIN
    raise unknown("the bearer token is not valid")


def allow(principal: Principal, found: Found) -> None:
    """Let pass whom the rule allows.

    Raises:
        Problem: 403, says what is missing.
    """
    rule = found.rule
    if rule.scope is not None and not principal.may(rule.scope):
        detail = f"{principal.name} lacks the scope {rule.scope.value}"
    elif principal.areas is not None and not rule.by_area:
        detail = "this is about the whole plant, and you are limited to areas"
    else:
        return
    raise forbidden(detail)


def unknown(detail: str) -> Problem:
    """Nobody can say who asks."""
    return Problem(
        HTTPStatus.UNAUTHORIZED,
        "not-logged-in",
        "Who are you?",
        f"{detail}; log in at /login, or send Authorization: Bearer TOKEN",
        headers={"WWW-Authenticate": 'Bearer realm="Dray"'},
    )


def forbidden(detail: str) -> Problem:
    """Whoever asks may not do this."""
    return Problem(HTTPStatus.FORBIDDEN, "not-allowed", "You may not do this", detail)
