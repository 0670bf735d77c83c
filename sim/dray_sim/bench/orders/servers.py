"""Servers of the benchmark, each in a process of its own: the gateway, and the bare insert.

python -m dray_sim.bench.orders bare|ours URL PORT
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from socket import create_connection
from typing import Any

from dray.adapters.addresses import free_addresses
from dray.gateway.access.principal import Scope
from dray.gateway.access.tokens import new_id, new_key
from dray.plant import default_plant
from dray.store import open_store
from dray.store.access.api_keys import ApiKey
from dray.store.orders.orders import Item, Order
from dray.store.orders.progress import OrderStatus

STARTS_S = 180.0
"""Longest wait for a server: with 10,000 open orders and a slow machine."""

PRODUCT = default_plant().file.products[0].id


@dataclass(frozen=True, slots=True)
class Served:
    """A server that answers."""

    host: str
    port: int
    token: str
    pid: int


@contextmanager
def serving(kind: str, url: str, token: str) -> Iterator[Served]:
    """One server.

    Args:
        kind: `bare` or `ours`.
        url: of its database.
        token: the customers' API key.
    """
    host, _, port = free_addresses(1)[0].rpartition(":")
    command = [sys.executable, "-m", __package__, kind, url, port]
    process = subprocess.Popen(command, env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)})  # noqa: S603 - our own
    served = Served(host or "127.0.0.1", int(port), token, process.pid)
    try:
        wait_for(served.host, served.port, process)
        yield served
    finally:
        process.terminate()
        process.wait(STARTS_S)


def wait_for(host: str, port: int, process: subprocess.Popen[Any]) -> None:
    """Return when a server answers.

    Raises:
        RuntimeError: it has ended, or takes too long.
    """
    until_s = time.monotonic() + STARTS_S
    while True:
        try:
            with closing(create_connection((host, port), 1.0)):
                return
        except OSError:
            if process.poll() is not None or time.monotonic() > until_s:
                raise RuntimeError("a server of the benchmark does not start") from None
            time.sleep(0.05)


async def prepare(url: str, count: int) -> str:
    """Fill a database with so many open orders that the strategist has taken; returns a key to place others."""
    token = new_key()
    store = await open_store(url)
    try:
        async with store.write() as work:
            await work.products.replace(default_plant().file.products)
            now_s = time.time()
            await work.orders.add_all(
                [_open_order(number, now_s - count + number) for number in range(count)]
            )
            key = ApiKey(id=new_id(), name="ERP", scopes=Scope.ORDERS_WRITE.value, created_at_s=now_s)
            await work.api_keys.add(token, key)
    finally:
        await store.close()
    return token


def _open_order(number: int, at_s: float) -> Order:
    return Order(
        id=f"O-{number}",
        status=OrderStatus.RELEASED,
        customer="Hall 3",
        token=f"token-{number}",
        items=(Item(PRODUCT, 5),),
        created_at_s=at_s,
        released_at_s=at_s,
        releases=1,
        updated_at_s=at_s,
    )
