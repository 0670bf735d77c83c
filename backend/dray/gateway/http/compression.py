"""Compression of answers larger than a packet, for clients that accept gzip (RFC 9110, 8.4).

The panels' built files are compressed at build time (`http.assets`); this is for all other answers. The
stream is compressed by its own protocol (RFC 7692).
"""

from __future__ import annotations

from starlette.datastructures import Headers, MutableHeaders
from starlette.middleware.gzip import GZipMiddleware
from starlette.types import ASGIApp, Message, Receive, Scope, Send

PACKET_BYTES = 1400
"""Minimum size: an answer that fits into one packet gains nothing."""

LEVEL = 5
"""Level of zlib: nine tenths of level 9's saving in half the time."""


def takes_gzip(scope: Scope) -> bool:
    """Whether the client accepts gzip (RFC 9110, 12.5.3)."""
    for coding in Headers(scope=scope).get("accept-encoding", "").lower().split(","):
        name, _, weight = coding.replace(" ", "").partition(";q=")
        if name == "gzip":
            return not weight or weight.strip("0.") != ""
    return False


class Compression:
    """Compresses answers and makes their tags weak, since a tag names the uncompressed bytes."""

    def __init__(self, app: ASGIApp) -> None:
        self._plain = app
        self._compressing = GZipMiddleware(app, minimum_size=PACKET_BYTES, compresslevel=LEVEL)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self._plain(scope, receive, send)
            return

        async def told(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                if "accept-encoding" not in headers.get("vary", "").lower():
                    headers.add_vary_header("Accept-Encoding")
                tag = headers.get("etag", "")
                if "content-encoding" in headers and tag.startswith('"'):
                    headers["ETag"] = f"W/{tag}"
            await send(message)

        app = self._compressing if takes_gzip(scope) else self._plain
        await app(scope, receive, told)
