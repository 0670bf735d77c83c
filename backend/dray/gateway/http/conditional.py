"""Conditional answers: a repeated request for an unchanged answer gets a 304 (RFC 9110, 13).

Every answer 200 to a GET under `/api` in one piece has an `ETag`. It is a digest of the body, so it works for
any call and gateway at the cost of hashing; the answer is still made. A version, for resources that can be
changed, precedes the digest (`http.versions`).
"""

from __future__ import annotations

import hashlib
from http import HTTPStatus

from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from dray.gateway.http.versions import tag_with_digest, tags_of

TAG_BYTES = 16
"""Bytes of the digest: nobody gains by forging it, as clients get the whole body."""

_OF_BODY = ("content-type", "content-length")
"""Headers about the body, which a 304 does not have."""


class Conditional:
    """Adds `ETag`, and answers 304 to clients that have this state."""

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
                # A streamed table comes in several pieces and has no tag.
                if not message.get("more_body", False):
                    message = _tagged(begun, message, known)
                await send(begun)
            await send(message)

        await self._app(scope, receive, conditional)


def _tagged(start: Message, body: Message, known: frozenset[str]) -> Message:
    """Set the tag in an answer's start; returns the message to send after it."""
    headers = MutableHeaders(scope=start)
    digest = hashlib.blake2b(body.get("body", b""), digest_size=TAG_BYTES).hexdigest()
    headers["ETag"] = tag = tag_with_digest(headers.get("ETag", ""), digest)
    if tag not in known and "*" not in known:
        return body
    start["status"] = HTTPStatus.NOT_MODIFIED
    for name in _OF_BODY:
        del headers[name]
    return {**body, "body": b""}
