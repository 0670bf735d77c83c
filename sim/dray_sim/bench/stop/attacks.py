"""Attacks on a gateway, each with a bound on its connections and on its time. They use 127.0.0.1 alone.

An attacker has a process of its own, so that its cost is not charged to the tablet. Attacks that need an account use
the administrator's, which may do most.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import multiprocessing
import os
from collections.abc import Awaitable, Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from multiprocessing.sharedctypes import Synchronized
from typing import TypeVar

from dray.gateway.http.csv_rows import MAX_ROWS
from dray.gateway.orders.drafts import MAX_ITEMS
from dray.gateway.schedules.drafts import RUNS_MAX
from dray.plant import default_plant

T = TypeVar("T")

HOST = "127.0.0.1"

LONGEST_S = 60.0
"""Longest duration of an attack, even when the process that began it has gone."""

HALF_OPEN = 1_100
"""Connections that say nothing: more than file descriptors in a process, by most systems' default."""

DRIPPING = 300
"""Connections that say little, and slowly."""

WORKERS = 8
"""Connections that ask as fast as they are answered."""

CALLERS = 4
"""Systems with keys of their own, where one caller alone would be told to wait."""

STREAMS = 250
"""Streams to open: more than there are places."""

AGAIN_S = 0.2
"""An attacker whose connection was ended comes back after this."""

HOLD_S = 20.0
"""Duration of one connection: an attacker that does not read cannot notice that it was closed, and begins anew."""

ENDING_S = 10.0


@dataclass(frozen=True, slots=True)
class Target:
    """The target of an attack.

    Attributes:
        port: the gateway's.
        stop_port: that of the stop path.
        token: the administrator's.
        folder: of a fleet, whose bus can be attacked; empty for a plant in one process.
    """

    port: int
    stop_port: int
    token: str
    folder: str = ""

    def head(self, method: str, path: str, length: int, kind: str = "application/json") -> bytes:
        """The head of a request by the administrator."""
        return (
            f"{method} {path} HTTP/1.1\r\nHost: {HOST}:{self.port}\r\nAuthorization: Bearer {self.token}\r\n"
            f"Content-Type: {kind}\r\nContent-Length: {length}\r\n\r\n"
        ).encode()


_tries: Synchronized[int] | None = None
"""Connections that this process has opened, or messages that it has sent."""

Attack = Callable[[Target], Awaitable[None]]


def count(tries: int = 1) -> None:
    """Note that the attack has tried so often more."""
    if _tries is not None:
        _tries.value += tries


async def half_open(target: Target) -> None:
    """Connections that say nothing."""
    await _each(HALF_OPEN, lambda _: _hold(target.port))


async def half_open_stops(target: Target) -> None:
    """The same, on the stop path itself."""
    await _each(HALF_OPEN, lambda _: _hold(target.stop_port))


async def slow_heads(target: Target) -> None:
    """Heads that arrive byte by byte."""
    await _each(DRIPPING, lambda _: _drip(target.port, b"GET / HTTP/1.1\r\nX-Slow: ", b"x"))


async def slow_bodies(target: Target) -> None:
    """Bodies that arrive byte by byte."""
    head = target.head("POST", "/api/orders", 30_000)
    await _each(DRIPPING, lambda _: _drip(target.port, head, b" "))


async def hostile_files(target: Target) -> None:
    """Files of orders that were made to be slow to read."""
    wide = ",".join(["product"] * 8_000)
    columns = "customer,reference,product,quantity,due_at,release\n"
    files = [
        wide,
        ",".join(["product"] * 100_000),
        columns + "c,r,p,1,,\n" * 60_000,
        columns + "c,,gear-unit-g1,many,soon,perhaps\n" * 1_000,
        columns + "\n" * 900_000,
        columns + '"' * 900_000,
        "a" * 900_000,
        columns + "c,,gear-unit-g1,1,," + "," * 900_000,
    ]
    bodies = [json.dumps({"csv": file, "dry_run": True}).encode() for file in files]
    await _each(
        WORKERS,
        lambda worker: _ask_all(
            target, [("POST", "/api/orders/import", body) for body in _turned(bodies, worker)]
        ),
    )


async def big_bodies(target: Target) -> None:
    """Large and deep JSON to everything that takes a body."""
    deep, wide = b"[" * 30_000, json.dumps({"items": [{"product": "x", "quantity": 1}] * 900}).encode()
    huge = json.dumps({"customer": "x" * 1_000_000}).encode()
    paths = (
        "/api/orders",
        "/api/orders/import",
        "/api/orders/preview",
        "/api/atvs/ATV1/commands",
        "/api/faults",
        "/login",
    )
    asked = [("POST", path, body) for path in paths for body in (deep, wide, huge)]
    await _each(WORKERS, lambda worker: _ask_all(target, _turned(asked, worker)))


async def large_drafts(target: Target) -> None:
    """Drafts of plants as large as a file may be: kept, judged, made plant files and played, by several callers."""
    path, changed, nodes = await _large_draft(target)
    asked = [
        ("GET", f"{path}/file", b""),
        ("GET", path, b""),
        ("PUT", path, changed),
        ("POST", f"{path}/play", b"{}"),
        ("POST", "/api/plant-drafts", json.dumps({"name": "x", "file": f"nodes: {nodes}"}).encode()),
    ]
    await _by_callers(target, asked)


async def readers_questions(target: Target) -> None:
    """The costliest requests of read-only keys: the largest draft as a file, tables, history, rare days, long polls."""
    path, _, _ = await _large_draft(target)
    rare = {"calendar": "0 0 29 2 MON", "time_zone": "Europe/Berlin", "count": RUNS_MAX}
    asked = [
        ("GET", f"{path}/file", b""),
        ("POST", "/api/schedules/preview", json.dumps(rare).encode()),
        ("GET", "/api/tasks/history?format=csv", b""),
        ("GET", "/api/tasks?format=csv", b""),
        ("GET", "/api/tasks/unknown", b""),
        ("GET", "/api/changes?since=0&wait=30", b""),
        ("GET", "/api/spells", b""),
        ("GET", "/api/replay/film", b""),
        ("GET", path, b""),
    ]
    await _by_callers(target, asked, ("factory:read", "orders:read"))


async def longest_files(target: Target) -> None:
    """The longest files of orders and products that can be taken, only looked at, by several callers."""
    plant = default_plant()
    product = next(iter(plant.products.values()))
    line, machine = product.bill[0], plant.machines_for(product.id)[0]
    orders = "customer,reference,product,quantity\n" + "".join(
        f"{'c' * 190},{'r' * 150}{row},{product.id},1\n" for row in range(MAX_ROWS)
    )
    products = "product,name,lot,material,pieces,machine,cycle_s\n" + "".join(
        f"X{row},Bracket,{product.lot},{line.material},{line.quantity},{machine},12.5\n"
        for row in range(MAX_ROWS)
    )
    files = (("orders", orders), ("products", products))
    asked = [
        ("POST", f"/api/{of}/import", json.dumps({"csv": file, "dry_run": True}).encode())
        for of, file in files
    ]
    await _by_callers(target, asked)


async def stream_flood(target: Target) -> None:
    """Streams that are opened and never read."""
    head = (
        f"GET /api/stream HTTP/1.1\r\nHost: {HOST}:{target.port}\r\nAuthorization: Bearer {target.token}\r\n"
        "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
        "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n"
    ).encode()
    await _each(STREAMS, lambda _: _hold(target.port, head))


async def login_flood(target: Target) -> None:
    """Guesses at the login."""

    def guess(worker: int) -> Awaitable[None]:
        body = f"name=guess-{worker}&secret={os.urandom(8).hex()}".encode()
        return _ask_all(target, [("POST", "/login", body)], "application/x-www-form-urlencoded")

    await _each(4 * WORKERS, guess)


async def tracking_flood(target: Target) -> None:
    """Customers' pages: one of a large order, and guessed links."""
    products = list(default_plant().products)
    items = [{"product": products[at % len(products)], "quantity": 1} for at in range(MAX_ITEMS)]
    order = json.dumps({"customer": "a customer", "items": items}).encode()
    page = ""
    while not page:
        with contextlib.suppress(OSError, ValueError):  # Others attack meanwhile: it may be turned away.
            placed = json.loads(await _ask(target, "POST", "/api/orders", order))
            page = placed.get("tracking_url", "").partition("/track/")[2]
        await _pause()
    paths = [("GET", path + token, b"") for token in ("x" * 32, page) for path in ("/api/track/", "/track/")]
    await _each(2 * WORKERS, lambda worker: _ask_all(target, _turned(paths, worker)))


async def _pause() -> None:
    """Between two tries."""
    await asyncio.sleep(1.0)


async def lists_flood(target: Target) -> None:
    """The longest lists, and the tables of everything."""
    paths = (
        "/api/events?limit=500",
        "/api/tasks?limit=500",
        "/api/orders?limit=500",
        "/api/orders?format=csv",
        "/api/audit?format=csv",
        "/api/kpis/history?step=60",
        "/api/openapi.json",
    )
    await _each(
        WORKERS, lambda worker: _ask_all(target, [("GET", path, b"") for path in _turned(paths, worker)])
    )


async def strange_stops(target: Target) -> None:
    """Stops of strangers, on the stop path itself."""
    body = b'{"kind": "stop"}'
    stranger = Target(target.stop_port, target.stop_port, "dray_guess")
    await _each(WORKERS, lambda _: _ask_all(stranger, [("POST", "/api/atvs/ATV1/commands", body)]))


async def all_at_once(target: Target) -> None:
    """Some of everything."""
    await asyncio.gather(
        half_open(target),
        hostile_files(target),
        big_bodies(target),
        login_flood(target),
        tracking_flood(target),
    )


ATTACKS: dict[str, Attack] = {
    f"{HALF_OPEN:,} half-open connections": half_open,
    "slow heads": slow_heads,
    "slow bodies": slow_bodies,
    "hostile CSV files": hostile_files,
    "drafts of a megabyte by four callers": large_drafts,
    "the longest files by four callers": longest_files,
    "four keys that only read": readers_questions,
    "big JSON bodies to every route": big_bodies,
    "a flood of streams": stream_flood,
    "a flood of logins": login_flood,
    "a flood of tracking pages": tracking_flood,
    "a flood of long lists": lists_flood,
    f"{HALF_OPEN:,} half-open connections on its own way": half_open_stops,
    "strangers' stops on its own way": strange_stops,
    "five of these at once": all_at_once,
}


@contextmanager
def under_attack(attack: Attack, target: Target) -> Iterator[Callable[[], int]]:
    """Attack as long as the context lasts, and not for longer than `LONGEST_S`.

    Returns:
        Tells how often the attackers have tried, once they have begun.
    """
    spawned = multiprocessing.get_context("spawn")
    tries = spawned.Value("Q", 0)
    process = spawned.Process(target=_attack, args=(attack, target, tries), daemon=True)
    process.start()
    try:
        yield lambda: int(tries.value)
    finally:
        process.terminate()
        process.join(ENDING_S)
        if process.is_alive():
            process.kill()
            process.join()


def _attack(attack: Attack, target: Target, tries: Synchronized[int]) -> None:
    global _tries  # noqa: PLW0603 - this process is for the attack alone
    _tries = tries

    async def bounded() -> None:
        with suppress(TimeoutError):
            async with asyncio.timeout(LONGEST_S):
                await attack(target)

    asyncio.run(bounded())


async def _connect(
    port: int, limit: int = 65_536, counted: bool = True
) -> tuple[asyncio.StreamReader, asyncio.StreamWriter]:
    """Open a connection; one that only prepares an attack is not counted as an attempt."""
    connected = await asyncio.open_connection(HOST, port, limit=limit)
    if counted:
        count()
    return connected


async def _each(count: int, work: Callable[[int], Awaitable[None]]) -> None:
    """Repeat the work in so many concurrent loops."""

    async def go_on(number: int) -> None:
        while True:
            with suppress(OSError, EOFError):
                await work(number)
            await asyncio.sleep(AGAIN_S)

    await asyncio.gather(*(go_on(number) for number in range(count)))


async def _hold(port: int, said: bytes = b"") -> None:
    """Say something, if anything, and hold the connection for a while; of an answer next to nothing is read."""
    reader, writer = await _connect(port, limit=1024)
    try:
        writer.write(said)
        if said:
            await asyncio.sleep(HOLD_S)
        else:
            await reader.read(1)
    finally:
        writer.close()


async def _drip(port: int, begun: bytes, drop: bytes) -> None:
    """Begin to say something, and go on with a byte a second."""
    _, writer = await _connect(port)
    try:
        writer.write(begun)
        while not writer.transport.is_closing():
            writer.write(drop)
            await writer.drain()
            await asyncio.sleep(1.0)
    finally:
        writer.close()


async def _large_draft(target: Target) -> tuple[str, bytes, str]:
    """Make a draft as large as a file may be; returns its path, the body that made it so, and its nodes."""
    draft = json.loads(await _ask(target, "POST", "/api/plant-drafts", b'{"name": "attacked"}'))["id"]
    nodes = f"[{','.join(['[]'] * 300_000)}]"
    changed = f'{{"name": "x", "data": {{"nodes": {nodes}}}}}'.encode()
    path = f"/api/plant-drafts/{draft}"
    await _ask(target, "PUT", path, changed)
    return path, changed, nodes


async def _by_callers(
    target: Target,
    asked: list[tuple[str, str, bytes]],
    scopes: Sequence[str] = ("orders:write", "factory:read", "floor:write"),
) -> None:
    """Ask these on `WORKERS` connections, by keys of `CALLERS` systems."""
    callers = []
    for number in range(CALLERS):
        request = {"name": f"{scopes[0]} {number}", "scopes": list(scopes)}
        made = json.loads(await _ask(target, "POST", "/api/keys", json.dumps(request).encode()))
        callers.append(replace(target, token=made["token"]))
    await _each(WORKERS, lambda worker: _ask_all(callers[worker % CALLERS], _turned(asked, worker)))


async def _ask_all(
    target: Target, asked: list[tuple[str, str, bytes]], kind: str = "application/json"
) -> None:
    """Ask these, one after the other, on a connection each."""
    for method, path, body in asked:
        await _ask(target, method, path, body, kind, counted=True)


async def _ask(
    target: Target,
    method: str,
    path: str,
    body: bytes,
    kind: str = "application/json",
    counted: bool = False,
) -> bytes:
    """The body of an answer, on a connection of its own. A change overwrites any version."""
    reader, writer = await _connect(target.port, counted=counted)
    try:
        head = target.head(method, path, len(body), kind)
        writer.write(head.replace(b"\r\n\r\n", b"\r\nIf-Match: *\r\nConnection: close\r\n\r\n") + body)
        return (await reader.read()).partition(b"\r\n\r\n")[2]
    finally:
        writer.close()


def _turned(things: Sequence[T], by: int) -> list[T]:
    """The same, beginning with another one."""
    return [*things[by % len(things) :], *things[: by % len(things)]]
