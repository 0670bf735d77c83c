"""Compression of answers: for whoever takes gzip, what is more than a packet (RFC 9110, 8.4).

The panels' built files were compressed when they were built (`http.assets`); here it is done for all other answers. The stream is
compressed by its own protocol (RFC 7692).
"""

from __future__ import annotations

from starlette.datastructures import Headers, MutableHeaders
from starlette.middleware.gzip import GZipMiddleware
from starlette.types import ASGIApp, Message, Receive, Scope, Send

PACKET_BYTES = 1400
"""What fits into one packet is not sooner there when it is smaller."""

LEVEL = 5
"""Of zlib: nine tenths of what level 9 saves, in half of its time."""


def takes_gzip(scope: Scope) -> bool:
    """Whether who asks can read gzip (RFC 9110, 12.5.3)."""
    for coding in Headers(scope=scope).get("accept-encoding", "").lower().split(","):
        name, _, weight = coding.replace(" ", "").partition(";q=")
        if name == "gzip":
            return not weight or weight.strip("0.") != ""
    return False


class Compression:
    """Compresses answers, and calls the tag of a compressed one weak: its bytes are not those that the tag names."""

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
