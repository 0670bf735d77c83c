"""The websocket on which panels watch the factory."""

from __future__ import annotations

import asyncio
from contextlib import suppress

from fastapi import APIRouter, WebSocket, WebSocketDisconnect

from dray.gateway.parts import Gateway
from dray.gateway.stream import Client

router = APIRouter()

TRY_LATER = 1013
"""RFC 6455's registry: the server is full."""

POLICY = 1008
"""RFC 6455: the client does what it should not."""

INCOMING_MESSAGES = 16
"""A client has nothing to say; one that says more than some greetings is no panel of ours."""


@router.websocket("/stream")
async def stream(socket: WebSocket, gateway: Gateway) -> None:
    """First a snapshot, then numbered deltas, as text."""
    client = gateway.hub.join()
    if client is None:
        await socket.close(TRY_LATER, "too many panels are open")
        return
    try:
        await socket.accept()
        await _serve(socket, client)
    finally:
        gateway.hub.leave(client)


async def _serve(socket: WebSocket, client: Client) -> None:
    """Send frames until the client goes, or talks too much."""
    sending = asyncio.create_task(_send_all(socket, client))
    listening = asyncio.create_task(_listen(socket))
    try:
        await asyncio.wait({sending, listening}, return_when=asyncio.FIRST_COMPLETED)
    finally:
        for task in (sending, listening):
            task.cancel()
        talked = (await asyncio.gather(sending, listening, return_exceptions=True))[1]
    if talked is True:
        with suppress(RuntimeError, WebSocketDisconnect):
            await socket.close(POLICY, "this socket only speaks")


async def _send_all(socket: WebSocket, client: Client) -> None:
    while True:
        await socket.send_text(await client.next_frame())


async def _listen(socket: WebSocket) -> bool:
    """Ignore what comes; returns True when it was too much, False when the client has gone."""
    for _ in range(INCOMING_MESSAGES):
        if (await socket.receive())["type"] == "websocket.disconnect":
            return False
    return True
