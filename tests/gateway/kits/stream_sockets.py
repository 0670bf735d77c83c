"""A browser's end of the stream's websocket, for tests."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

from gateway_kit import BEARER, House


class Socket:
    """A browser's end of a websocket, spoken to the application as a server does (ASGI)."""

    def __init__(self, house: House, **headers: str) -> None:
        self.to_app: asyncio.Queue[dict[str, Any]] = asyncio.Queue()
        self.from_app: asyncio.Queue[dict[str, Any]] = asyncio.Queue()
        self.takes = asyncio.Event()
        """Cleared while this browser reads nothing."""
        self.takes.set()
        known = {} if "cookie" in headers else BEARER
        scope = {
            "type": "websocket",
            "asgi": {"version": "3.0"},
            "http_version": "1.1",
            "scheme": "ws",
            "path": "/api/stream",
            "raw_path": b"/api/stream",
            "query_string": b"",
            "root_path": "",
            "headers": [
                (name.lower().encode(), value.encode())
                for name, value in ({"host": "dray.test"} | known | headers).items()
            ],
            "client": ("127.0.0.1", 1234),
            "server": ("dray.test", 80),
            "subprotocols": [],
            "state": {},
        }
        self.to_app.put_nowait({"type": "websocket.connect"})
        self.served = asyncio.create_task(house.app(scope, self.to_app.get, self._send))

    async def _send(self, message: Any) -> None:
        await self.takes.wait()
        await self.from_app.put(message)

    async def read(self) -> dict[str, Any]:
        """The next frame."""
        message = await self.from_app.get()
        assert message["type"] == "websocket.send", message
        frame: dict[str, Any] = json.loads(message["text"])
        return frame

    def say(self, text: str) -> None:
        self.to_app.put_nowait({"type": "websocket.receive", "text": text})

    async def close(self) -> None:
        self.to_app.put_nowait({"type": "websocket.disconnect", "code": 1001})
        await self.served


@asynccontextmanager
async def opened(house: House, **headers: str) -> AsyncIterator[Socket]:
    socket = Socket(house, **headers)
    assert (await socket.from_app.get())["type"] == "websocket.accept"
    yield socket
    await socket.close()
