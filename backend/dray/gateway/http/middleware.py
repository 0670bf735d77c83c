"""Middleware: the layers that every request passes before its router.

They handle oversized bodies, requests by other sites' pages, and browsers' rules for our answers.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from contextlib import suppress
from http import HTTPStatus

from starlette.datastructures import Headers
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from dray.gateway.http.hosts import authority_in
from dray.gateway.http.problems import Problem

BODY_BYTES = 32 * 1024
"""Maximum body where no file is expected. An order of 50 items has some 10 kB, the largest product 24 kB. The
worst body of this size, thousands of unknown fields, takes the loop some ten milliseconds to refuse."""

CONTENT_POLICY = "; ".join(
    (
        "default-src 'self'",
        "object-src 'none'",
        "base-uri 'none'",
        "form-action 'self'",
        "frame-ancestors 'none'",
    )
)
"""Allows only our own scripts, styles, pictures and streams, and none inside a page."""

HEADERS = {
    "Content-Security-Policy": CONTENT_POLICY,
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Permissions-Policy": "camera=(), geolocation=(), microphone=()",
}

_HALF = re.compile(
    r"\\u[dD][89abAB][0-9a-fA-F]{2}\\u[dD][c-fC-F][0-9a-fA-F]{2}|(\\u[dD][89a-fA-F][0-9a-fA-F]{2}|[\ud800-\udfff])|\\."
)
"""In JSON: a character as a surrogate pair, a lone surrogate (in the group), or any other escape."""

_RAW_HEADERS = [(name.lower().encode(), value.encode()) for name, value in HEADERS.items()]

_OURS = frozenset({"same-origin", "none"})
"""`none`: a person's own action, such as using the address bar."""

_SAFE = frozenset({"GET", "HEAD", "OPTIONS"})


class _TooLarge(Exception):
    """The body has exceeded the limit."""


class BodyLimit:
    """Stops reading a body that is too large, even if its Content-Length claims less.

    Args:
        app: the next application.
        bulk_bytes: maximum body if it is a file; other bodies have `BODY_BYTES`, or this if less.
        takes_files: whether a request's route takes a file as its body.
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
            # Do not send an answer made from the exception.
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
            # The rest of the body would be read as the next request.
            headers={"Connection": "close"},
        )
        await problem.response(scope["path"])(scope, receive, send)

    return refuse


class WholeCharacters:
    """Replaces lone surrogates in a JSON body, which JSON can express.

    They cannot be encoded, not even in the answer that refuses them. NUL replaces them: it can be encoded,
    and none of our fields accepts it in a name.

    Args:
        app: the next application; it gets the whole body at once.
        takes_files: whether a request's route takes a file as its body: those bodies are read beside the
            gateway.
    """

    def __init__(self, app: ASGIApp, takes_files: Callable[[Scope], bool]) -> None:
        self._app, self._takes_files = app, takes_files

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http" or self._takes_files(scope):
            await self._app(scope, receive, send)
            return
        parts, is_whole = list[bytes](), False

        async def whole() -> Message:
            nonlocal is_whole
            while not is_whole:
                message = await receive()
                if message["type"] != "http.request":
                    return message
                parts.append(message.get("body", b""))
                is_whole = not message.get("more_body", False)
                if is_whole:
                    return {**message, "body": whole_characters(b"".join(parts))}
            return await receive()

        await self._app(scope, whole, send)


def whole_characters(body: bytes) -> bytes:
    """JSON with lone surrogates replaced."""
    if body.isascii() and b"\\u" not in body:
        return body
    try:
        text = body.decode(json.detect_encoding(body), "surrogatepass")
    except UnicodeDecodeError:
        return body  # It is refused later.
    return _HALF.sub(_whole, text).encode("utf-8", "replace")


def _whole(found: re.Match[str]) -> str:
    return found[0] if found[1] is None else r"\u0000"


class Readable:
    """Makes a request's path safe for database queries.

    NUL, which PostgreSQL text cannot hold, becomes U+FFFD, like bytes that are not UTF-8: nothing has such a
    name, and no query fails.
    """

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if "\0" in scope.get("path", ""):
            scope = {**scope, "path": scope["path"].replace("\0", "\ufffd")}
        await self._app(scope, receive, send)


class SameOrigin:
    """Refuses requests that another site's page makes through its visitor's browser.

    Browsers name the page in `Origin`, and tell in `Sec-Fetch-Site` whether it is ours; programs send
    neither. Browsers' own rules protect reading, except for the stream, which they do not cover.
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
    """Adds `HEADERS` to every answer, except those set by a router."""

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
