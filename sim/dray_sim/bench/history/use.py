"""How long people wait for pages over REST, and whether forgetting history makes anybody wait.

The gateway runs in a process of its own on the existing database. First pages are asked for one after the other. Then
orders are placed at the usual rate while somebody opens a page each second. After some time the gateway begins to
forget; the slowest request before that is the baseline. A request's time runs from the moment at which it was due, so
it includes the wait for an earlier request.
"""

from __future__ import annotations

import asyncio
import json
import os
import subprocess
import sys
import time
from collections.abc import AsyncIterator, Iterator, Mapping, Sequence
from contextlib import AsyncExitStack, asynccontextmanager, contextmanager
from dataclasses import replace
from random import Random
from uuid import uuid4

from sqlalchemy import func, select

from dray.adapters.addresses import free_addresses
from dray.gateway.access.principal import Scope
from dray.gateway.access.tokens import new_id, new_key
from dray.store import Store
from dray.store.access.api_keys import ApiKey
from dray.store.tables import events
from dray_sim.bench.history.data import EVERY_S, NOW_S, SEED, order_of
from dray_sim.bench.orders.servers import PRODUCT, wait_for
from dray_sim.bench.row import Row

AIM_MS = 200.0
"""Aim for a page (ms): for a later one people wait noticeably."""

MOST_MS = 300.0
"""Longest time of a request while history is forgotten."""

SEARCHES, PAGES = 20, 100
"""Number of pages that are asked for, enough for a p95."""

PLACED_EVERY_S = 0.2
"""Between two orders: five a second are 18,000 an hour, more than 50 vehicles bring."""

LOOK_EVERY = 5
"""Orders between two looks at a page: one a second."""

BEFORE = 300
"""Orders that are placed before anything is forgotten: for a minute."""

FORGOTTEN_PART = 100
"""Forgotten fraction of the events, 1 in this number: of ten weeks 17 hours."""

STOPS_S = 60.0


def beside(row: Row, bare_ms: float) -> Row:
    """A row of a search, beside the bare query of an index in the same run.

    Args:
        row: the search.
        bare_ms: how long that query takes.
    """
    return replace(row, baseline=bare_ms, baseline_name=f"a bare query of an index ({bare_ms:.2g} ms)")


async def used(
    name: str, url: str, store: Store, many: int, bare_ms: float, before: int = BEFORE
) -> list[Row]:
    """Look at pages and place orders, without and with something that is forgotten.

    Args:
        name: begins the names of the rows.
        url: of the database.
        store: open on it.
        many: orders there are.
        bare_ms: how long the bare query of an index takes.
        before: orders that are placed before anything is forgotten.
    """
    token = await _key(store)
    oldest = many - many // FORGOTTEN_PART
    before_s = NOW_S - oldest * EVERY_S
    with _serving(url, before_s) as (process, port):
        async with _line(port, token) as line:
            rows = [
                await _pages(f"{name}, {what}, over REST", line, paths)
                for what, paths in _looks(many).items()
            ]
        rows[0] = beside(rows[0], bare_ms)
        kept = await _count(store)
        rows += await _forgotten(name, process, port, token, many, before)
        gone = kept - await _count(store)
    forgot = rows[-1]
    took_s = forgot.figure
    note = f"{gone:,} events of {kept:,} forgotten in {took_s:,.0f} s, {gone / took_s:,.0f} a second; {forgot.note}"
    rows[-1] = Row(
        f"{name}, {1 / FORGOTTEN_PART:.0%} of all events forgotten", took_s, "s", took_s, "itself", note=note
    )
    return rows


def _looks(many: int) -> dict[str, list[tuple[str, ...]]]:
    """Pages that people open; each takes one request or two."""
    chance = Random(SEED)
    some = [chance.randrange(many) for _ in range(PAGES)]
    return {
        f"D5 in {many:,} orders": [("/api/orders?q=D5&sort=work&limit=50",)] * SEARCHES,
        "D5 in the audit log": [("/api/audit?q=D5&limit=50",)] * SEARCHES,
        "an order's page": [(f"/api/orders/O-{n}", f"/api/orders/O-{n}/timeline") for n in some],
        "a customer's page": [(f"/track/{order_of(n).token}",) for n in some],
    }


class _Line:
    """A kept connection to the gateway, on which one request at a time is asked."""

    def __init__(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, token: str) -> None:
        self._reader, self._writer, self._token = reader, writer, token

    async def ask(self, path: str, body: object = None) -> bytes:
        """Get a path, or post a body to it; returns the answer.

        Raises:
            RuntimeError: the status is neither 200 nor 201.
        """
        sent = b"" if body is None else json.dumps(body).encode()
        head = [
            f"{'GET' if body is None else 'POST'} {path} HTTP/1.1",
            "Host: 127.0.0.1",
            f"Authorization: Bearer {self._token}",
            "Content-Type: application/json",
            f"Content-Length: {len(sent)}",
            f"Idempotency-Key: {uuid4()}",
        ]
        self._writer.write("\r\n".join((*head, "", "")).encode() + sent)
        told = (await self._reader.readuntil(b"\r\n\r\n")).decode()
        [length] = [line for line in told.lower().split("\r\n") if line.startswith("content-length:")]
        answer = await self._reader.readexactly(int(length.partition(":")[2]))
        if told.split(" ", 2)[1] not in ("200", "201"):
            raise RuntimeError(f"{path}: {told.splitlines()[0]} {answer[:300]!r}")
        return answer


@asynccontextmanager
async def _line(port: int, token: str) -> AsyncIterator[_Line]:
    reader, writer = await asyncio.open_connection("127.0.0.1", port)
    try:
        yield _Line(reader, writer, token)
    finally:
        writer.close()


async def _pages(name: str, line: _Line, pages: Sequence[tuple[str, ...]]) -> Row:
    took_ms: list[float] = []
    # The first page is asked for twice: a gateway reads some tables only once.
    for place, paths in enumerate([pages[0], *pages]):
        begun_s = time.perf_counter()
        for path in paths:
            await line.ask(path)
        if place:
            took_ms.append(1000 * (time.perf_counter() - begun_s))
    note = f"p95 of {len(took_ms)}; p50 {_quantile(took_ms, 0.5):.3g} ms, slowest {max(took_ms):.0f} ms"
    figure = _quantile(took_ms, 0.95)
    return Row(name, figure, "ms", AIM_MS, "what is waited for", AIM_MS, note, less=True)


async def _forgotten(
    name: str, process: subprocess.Popen[str], port: int, token: str, many: int, first: int
) -> list[Row]:
    """Place orders and look at pages, the first before anything is forgotten, and then as long as it is."""
    before: dict[str, list[float]] = {"order": [], "page": []}
    during: dict[str, list[float]] = {"order": [], "page": []}
    phase = before

    async with AsyncExitStack() as stack:
        placing = await stack.enter_async_context(_line(port, token))
        looking = await stack.enter_async_context(_line(port, token))
        pages = [page for pages in zip(*_looks(many).values(), strict=False) for page in pages]

        async def place() -> None:
            due_s = time.perf_counter()
            while True:
                due_s = await _until(due_s + PLACED_EVERY_S)
                items = [{"product": PRODUCT, "quantity": 5}]
                body = {"customer": "Hall 3", "reference": f"PO-{uuid4()}", "items": items}
                await placing.ask("/api/orders", body)
                phase["order"].append(1000 * (time.perf_counter() - due_s))

        async def look() -> None:
            due_s, number = time.perf_counter(), 0
            while True:
                due_s, number = await _until(due_s + PLACED_EVERY_S * LOOK_EVERY), number + 1
                # Each request is timed by itself: none may be held up.
                for path in pages[number % len(pages)]:
                    begun_s = time.perf_counter()
                    await looking.ask(path)
                    phase["page"].append(1000 * (time.perf_counter() - begun_s))

        async with asyncio.TaskGroup() as tasks:
            running = [tasks.create_task(place()), tasks.create_task(look())]
            await _until_told(before, first)
            phase = during
            assert process.stdin is not None and process.stdout is not None  # noqa: S101, PT018 - pipes of ours
            print("forget", file=process.stdin, flush=True)
            told = json.loads(await asyncio.to_thread(process.stdout.readline))
            await _until_told(during, 1)
            for task in running:
                task.cancel()
    rows = []
    for what, said in (("order", "an order is placed"), ("page", "a page is asked for")):
        usual, many_ms = max(before[what]), during[what]
        note = (
            f"slowest of {len(many_ms)}, p95 {_quantile(many_ms, 0.95):.0f} ms; "
            f"before it slowest of {len(before[what])}, p95 {_quantile(before[what], 0.95):.0f} ms"
        )
        slow = Row(
            f"{name}, {said} while it forgets",
            max(many_ms),
            "ms",
            usual,
            "before it",
            MOST_MS,
            note,
            less=True,
        )
        rows.append(slow)
    each_ms = told["transactions_ms"]
    note = (
        f"{len(each_ms):,} transactions, p95 {_quantile(each_ms, 0.95):.0f} ms, slowest {max(each_ms):.0f} ms"
    )
    return [*rows, Row(name, told["took_s"], "s", told["took_s"], "itself", note=note)]


async def _until_told(phase: Mapping[str, Sequence[float]], orders: int) -> None:
    """Return when so many orders were placed in a phase, and a page was looked at."""
    while len(phase["order"]) < orders or not phase["page"]:  # noqa: ASYNC110 - both are lists that others fill
        await asyncio.sleep(PLACED_EVERY_S)


async def _until(due_s: float) -> float:
    await asyncio.sleep(max(0.0, due_s - time.perf_counter()))
    return due_s


def _quantile(values: Sequence[float], part: float) -> float:
    return sorted(values)[min(len(values) - 1, int(part * len(values)))]


async def _count(store: Store) -> int:
    async with store.database.read() as connection:
        count: int = (await connection.execute(select(func.count()).select_from(events))).scalar_one()
    return count


async def _key(store: Store) -> str:
    token = new_key()
    scopes = " ".join((Scope.ORDERS_READ, Scope.ORDERS_WRITE, Scope.FACTORY_READ, Scope.AUDIT_READ))
    async with store.write() as work:
        await work.api_keys.add(token, ApiKey(id=new_id(), name="ERP", scopes=scopes, created_at_s=NOW_S))
    return token


@contextmanager
def _serving(url: str, before_s: float) -> Iterator[tuple[subprocess.Popen[str], int]]:
    """A gateway that forgets all events before a moment when a line comes on its input."""
    port = int(free_addresses(1)[0].rpartition(":")[2])
    command = [sys.executable, "-m", __package__, url, str(port), str(before_s)]
    process = subprocess.Popen(  # noqa: S603 - our own
        command,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        wait_for("127.0.0.1", port, process)
        yield process, port
    finally:
        process.terminate()
        process.communicate(timeout=STOPS_S)
