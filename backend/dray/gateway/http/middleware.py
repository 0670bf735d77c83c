"""Middleware: what every request passes before it reaches a router.

Too large a body, a page of another site that lets its visitor's browser ask us, and what browsers may
do with our answers.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from http import HTTPStatus

from starlette.datastructures import Headers
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from dray.gateway.http.hosts import authority_in
from dray.gateway.http.problems import Problem

BODY_BYTES = 32 * 1024
"""The largest body where no file is expected. An order of 50 items has some 10 kB, the largest product 24 kB. The worst that can be
written with as much as this, thousands of unknown fields, takes the loop some ten milliseconds to refuse."""

CONTENT_POLICY = "; ".join(
    (
        "default-src 'self'",
        "object-src 'none'",
        "base-uri 'none'",
        "form-action 'self'",
        "frame-ancestors 'none'",
    )
)
"""No script, style, picture or stream but our own, and none written into a page."""

HEADERS = {
    "Content-Security-Policy": CONTENT_POLICY,
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Permissions-Policy": "camera=(), geolocation=(), microphone=()",
}

_RAW_HEADERS = [(name.lower().encode(), value.encode()) for name, value in HEADERS.items()]

_OURS = frozenset({"same-origin", "none"})
"""`none`: a person has asked, by the address bar say."""

_SAFE = frozenset({"GET", "HEAD", "OPTIONS"})


class _TooLarge(Exception):
    """The body has grown over the limit."""


class BodyLimit:
    """Stops reading a body that is too large, whatever its Content-Length says.

    Args:
        app: what it stands before.
        bulk_bytes: the largest body where it is a file; elsewhere it has `BODY_BYTES`, or this if that is less.
        takes_files: whether a request came to a route whose body may be a file.
    """

    def __init__(self, app: ASGIApp, bulk_bytes: int, takes_files: Callable[[Scope], bool]) -> None:
        self._app, self._bulk, self._takes_files = app, bulk_bytes, takes_files

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        limit = self._bulk if self._takes_files(scope) else min(BODY_BYTES, self._bulk)
        announced = Headers(scope=scope).get("content-length", "")
        if announced.isdecimal() and int(announced) > limit:
            await _too_large(limit)(scope, receive, send)
            return
        seen, answering = 0, False

        async def limited() -> Message:
            nonlocal seen
            message = await receive()
            seen += len(message.get("body", b""))
            if seen > limit:
                raise _TooLarge
            return message

        async def watched(message: Message) -> None:
            nonlocal answering
            # An answer that was made of the exception is not the one to give.
            if seen <= limit:
                answering = True
                await send(message)

        with suppress(_TooLarge):
            await self._app(scope, limited, watched)
        if seen > limit and not answering:
            await _too_large(limit)(scope, receive, send)


def _too_large(limit_bytes: int) -> ASGIApp:
    async def refuse(scope: Scope, receive: Receive, send: Send) -> None:
        problem = Problem(
            HTTPStatus.REQUEST_ENTITY_TOO_LARGE,
            "body-too-large",
            "The body is too large",
            f"it may have {limit_bytes} bytes; split it into several requests",
            # What is still on its way would be taken for the next request.
            headers={"Connection": "close"},
        )
        await problem.response(scope["path"])(scope, receive, send)

    return refuse


class SameOrigin:
    """Refuses what a page of another site lets its visitor's browser do.

    Browsers name the page that asks in `Origin`, and tell in `Sec-Fetch-Site` whether it is ours; programs
    send neither. Reading is left to the browser's own rules, except for the stream, to which these do not
    apply.
    """

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "lifespan" or _is_ours(scope):
            await self._app(scope, receive, send)
        elif scope["type"] == "websocket":
            await receive()
            await send({"type": "websocket.close", "code": 1008, "reason": "another site's page"})
        else:
            problem = Problem(
                HTTPStatus.FORBIDDEN,
                "other-origin",
                "Another site's page may not do this",
                "open the panel under the address that it is asked at",
            )
            await problem.response(scope["path"])(scope, receive, send)


def _is_ours(scope: Scope) -> bool:
    if scope["type"] == "http" and scope["method"] in _SAFE:
        return True
    headers = Headers(scope=scope)
    if headers.get("sec-fetch-site", "same-origin") not in _OURS:
        return False
    origin = headers.get("origin")
    return origin is None or authority_in(origin) == headers.get("host")


class SecurityHeaders:
    """Adds `HEADERS` to every answer, unless a router has set one itself."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        async def with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                own = {name for name, _ in message["headers"]}
                added = [header for header in _RAW_HEADERS if header[0] not in own]
                message["headers"] = [*message["headers"], *added]
            await send(message)

        await self._app(scope, receive, with_headers)
