"""Conditional answers: who asks again for what has not changed is told so in a line (RFC 9110, 13).

Every answer 200 of a GET under `/api` that is made in one piece names its state in `ETag`. It is a digest of the body, so it
holds for any call and for any gateway, and costs what hashing costs; the answer itself is made all the same. Before the digest
stands the version of what can be changed (`http.versions`).
"""

from __future__ import annotations

import hashlib
from http import HTTPStatus

from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from dray.gateway.http.versions import tag_with_digest, tags_of

TAG_BYTES = 16
"""Of a digest that nobody has a reason to forge: whoever asks is shown the whole body."""

_OF_BODY = ("content-type", "content-length")
"""Headers that tell of a body, which an answer 304 has not."""


class Conditional:
    """Adds `ETag`, and answers 304 to who has this very state already."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http" or scope["method"] != "GET" or not scope["path"].startswith("/api/"):
            await self._app(scope, receive, send)
            return
        known = tags_of(",".join(Headers(scope=scope).getlist("if-none-match")))
        start: Message | None = None

        async def conditional(message: Message) -> None:
            nonlocal start
            if message["type"] == "http.response.start" and message["status"] == HTTPStatus.OK:
                start = message
                return
            if start is not None:
                begun, start = start, None
                # A table that streams comes in several pieces: it has no tag.
                if not message.get("more_body", False):
                    message = _tagged(begun, message, known)
                await send(begun)
            await send(message)

        await self._app(scope, receive, conditional)


def _tagged(start: Message, body: Message, known: frozenset[str]) -> Message:
    """Name the state in the beginning of an answer; returns what is sent after it."""
    headers = MutableHeaders(scope=start)
    digest = hashlib.blake2b(body.get("body", b""), digest_size=TAG_BYTES).hexdigest()
    headers["ETag"] = tag = tag_with_digest(headers.get("ETag", ""), digest)
    if tag not in known and "*" not in known:
        return body
    start["status"] = HTTPStatus.NOT_MODIFIED
    for name in _OF_BODY:
        del headers[name]
    return {**body, "body": b""}
