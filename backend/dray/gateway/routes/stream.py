"""The websocket on which panels watch the factory."""

from __future__ import annotations

import asyncio
from contextlib import suppress
from http import HTTPStatus
from typing import Literal

from fastapi import APIRouter, WebSocket, WebSocketDisconnect

from dray.gateway.access.access import Access
from dray.gateway.access.caller import Caller
from dray.gateway.access.gate import CLOSE_CODES, TRY_LATER
from dray.gateway.access.watch import End
from dray.gateway.http.provided import Provided
from dray.gateway.live.stream import Client, Hub, Pace

router = APIRouter()

END_CODES = {End.OVER: CLOSE_CODES[HTTPStatus.UNAUTHORIZED], End.MOVED: 4409}
"""Private codes, after HTTP statuses: not logged in, and a conflict with the present state."""

POLICY = 1008
"""RFC 6455: policy violation by the client."""

INCOMING_MESSAGES = 16
"""Maximum messages of a client: panels send none, and other clients are not wanted."""


@router.websocket("/stream")
async def stream(
    socket: WebSocket,
    hub: Provided[Hub],
    access: Provided[Access],
    caller: Caller,
    pace: Literal["live", "calm"] = "live",
) -> None:
    """Send a snapshot, then numbered deltas, as text, while the caller may see them.

    A calm stream has one frame a second.
    """
    client = hub.join(caller, Pace(pace))
    if client is None:
        # Browsers hide the status of a refused handshake; only an open socket can be closed with a code (RFC
        # 6455, 7.4).
        await socket.accept()
        await socket.close(TRY_LATER, "too many panels are open")
        return
    try:
        await socket.accept()
        with access.watch.over(caller) as ended:
            await _serve(socket, client, ended)
    finally:
        hub.leave(client)


async def _serve(socket: WebSocket, client: Client, ended: asyncio.Future[End]) -> None:
    """Send frames until the client leaves, sends too much, or loses its right."""
    sending = asyncio.create_task(_send_all(socket, client))
    listening = asyncio.create_task(_listen(socket))
    tasks = (sending, listening, ended)
    try:
        await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
    finally:
        for task in tasks:
            task.cancel()
        _, talked, end = await asyncio.gather(*tasks, return_exceptions=True)
    with suppress(RuntimeError, WebSocketDisconnect):
        if isinstance(end, End):
            await socket.close(END_CODES[end], end.value)
        elif talked is True:
            await socket.close(POLICY, "this socket only speaks")


async def _send_all(socket: WebSocket, client: Client) -> None:
    while True:
        await socket.send_text(await client.next_frame())


async def _listen(socket: WebSocket) -> bool:
    """Ignore incoming messages; returns True when there were too many, False when the client has left."""
    for _ in range(INCOMING_MESSAGES):
        if (await socket.receive())["type"] == "websocket.disconnect":
            return False
    return True
