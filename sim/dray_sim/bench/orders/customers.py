"""Customers of the benchmark: they place one order after the other over a kept connection, and wait for each answer.

The client is minimal, because it uses the same processors as the servers that are measured.
"""

from __future__ import annotations

import asyncio
import json
import time
from uuid import uuid4

from dray_sim.bench.orders.servers import PRODUCT, Served

PLACED = b"HTTP/1.1 201 "


class Customers:
    """Some customers of one server.

    Args:
        served: where they order.
        count: how many at a time.
    """

    def __init__(self, served: Served, count: int) -> None:
        self._served, self._count = served, count
        self._left = 0

    async def place(self, orders: int) -> float:
        """Place so many; returns how many were answered per second.

        Raises:
            RuntimeError: one was refused.
        """
        lines = [
            await asyncio.open_connection(self._served.host, self._served.port) for _ in range(self._count)
        ]
        try:
            for reader, writer in lines:
                await self._order(reader, writer)
            self._left = orders
            begun_s = time.perf_counter()
            await asyncio.gather(*(self._order_on(*line) for line in lines))
            return orders / (time.perf_counter() - begun_s)
        finally:
            for _, writer in lines:
                writer.close()

    async def _order_on(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        while self._left > 0:
            self._left -= 1
            await self._order(reader, writer)

    @staticmethod
    def _body(key: str) -> bytes:
        """An order under a number of its own: a probable duplicate gets a hint, which is not measured."""
        items = [{"product": PRODUCT, "quantity": 5}]
        return json.dumps({"customer": "Hall 3", "reference": f"PO-{key}", "items": items}).encode()

    async def _order(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        key = str(uuid4())
        body = self._body(key)
        writer.write(
            b"POST /api/orders HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Type: application/json\r\n"
            + f"Authorization: Bearer {self._served.token}\r\n".encode()
            + f"Idempotency-Key: {key}\r\n".encode()
            + f"Content-Length: {len(body)}\r\n\r\n".encode()
            + body
        )
        head = await reader.readuntil(b"\r\n\r\n")
        [length] = [line for line in head.lower().split(b"\r\n") if line.startswith(b"content-length:")]
        answer = await reader.readexactly(int(length.partition(b":")[2]))
        if not head.startswith(PLACED):
            raise RuntimeError(f"an order was refused: {answer.decode()}")
