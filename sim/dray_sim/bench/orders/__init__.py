"""Benchmark `orders`: how many orders are taken in a second, beside a bare insert.

The baseline is what anybody would write first: FastAPI, one model, one INSERT by SQLAlchemy, on a database that has the
order on disk when it is answered. Both are served by uvicorn with the same settings, each in a process of its own, and
asked by the same client over kept connections; they take turns. Ours checks who asks, keeps an Idempotency-Key, the
items, the customer's link and a line of the audit log, and tells a strategist that takes each order at once.
"""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from dray_sim.bench.orders.customers import Customers
from dray_sim.bench.orders.servers import Served, fill, serving
from dray_sim.bench.postgres import PostgresServer, installed
from dray_sim.bench.row import Row

OPEN = (0, 1_000, 10_000)
"""Orders that have not ended when the last one is placed: none, a busy week, and as many as the gateway takes."""

CLIENTS = (1, 16)
"""One system that waits for each answer, and a rush of them."""

ORDERS = {1: 300, 16: 800}
"""Placed in one run, by clients: some seconds."""

REPEATS = 3
"""The best of three: other work on the machine can only make a run slower."""

AIM = 0.8
"""Of the bare insert's rate, whatever is open: a fifth is what all the rest may cost."""

QUICK = 10
"""A quick run places so many times fewer, once."""


def measure(quick: bool) -> list[Row]:
    """Measure both databases; PostgreSQL where it is installed.

    Args:
        quick: a tenth of the work.
    """
    rows = []
    with _databases() as databases:
        for name, fresh in databases:
            for number, waiting in enumerate(OPEN):
                bare_url, our_url = fresh(f"bare{number}"), fresh(f"ours{number}")
                # Each customer places one before the clock begins to run.
                placed = sum(_count(clients, quick) + clients for clients in CLIENTS) * _repeats(quick)
                before = max(0, waiting - placed)
                asyncio.run(fill(our_url, before))
                with serving("bare", bare_url) as bare, serving("ours", our_url) as ours:
                    rows += [_row(name, waiting, clients, bare, ours, quick) for clients in CLIENTS]
    return rows


def _row(database: str, waiting: int, clients: int, bare: Served, ours: Served, quick: bool) -> Row:
    best = {"bare": 0.0, "ours": 0.0}
    for _ in range(_repeats(quick)):
        for name, served in (("bare", bare), ("ours", ours)):
            rate_hz = asyncio.run(Customers(served, clients).place(_count(clients, quick)))
            best[name] = max(best[name], rate_hz)
    said = f"{clients} client{'s' if clients > 1 else ''}"
    return Row(
        f"orders: {database}, {waiting:,} open, {said}",
        best["ours"],
        "1/s",
        best["bare"],
        "bare FastAPI and SQLAlchemy insert",
        AIM * best["bare"],
    )


def _count(clients: int, quick: bool) -> int:
    return ORDERS[clients] // (QUICK if quick else 1)


def _repeats(quick: bool) -> int:
    return 1 if quick else REPEATS


class _Files:
    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def __call__(self, name: str) -> str:
        return f"sqlite+aiosqlite:///{self._folder / name}.db"


class _Server:
    def __init__(self, server: PostgresServer) -> None:
        self._server = server

    def __call__(self, name: str) -> str:
        self._server.create(name)
        return self._server.url(name)


@contextmanager
def _databases() -> Iterator[list[tuple[str, _Files | _Server]]]:
    """Names of databases, and what makes a new one on each."""
    with ExitStack() as stack:
        folder = Path(stack.enter_context(TemporaryDirectory()))
        databases: list[tuple[str, _Files | _Server]] = [("SQLite", _Files(folder))]
        programs = installed()
        if programs is not None:
            server = PostgresServer(programs)
            stack.callback(server.close)
            databases.append(("PostgreSQL", _Server(server)))
        yield databases
