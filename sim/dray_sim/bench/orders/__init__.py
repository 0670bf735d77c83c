"""Benchmark `orders`: how many orders are taken in a second, beside a bare insert.

The baseline is a straightforward implementation: FastAPI, the same model of the body, and the same rows inserted by
SQLAlchemy, a statement for each table: the order, its items, the customer's link, the Idempotency-Key, a line of the
audit log and one of the change log. Like ours, it has the order on disk before it answers. Both are served by uvicorn
with the same settings, each in a process of its own. The same client asks both over kept connections, in turns. Ours
also knows the caller by an API key and a repeated request by its Idempotency-Key, and checks whether the order is
probably sent twice. It offers each order to a strategist that takes it at once, and writes the change log by
triggers.
"""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory

from dray.gateway.orders.placement import MAX_OPEN_ORDERS
from dray_sim.bench.orders.customers import Customers
from dray_sim.bench.orders.servers import Served, prepare, serving
from dray_sim.bench.postgres import PostgresServer, installed
from dray_sim.bench.row import Row
from dray_sim.bench.usage import Usage

OPEN = (0, 1_000, MAX_OPEN_ORDERS)
"""Open orders before the measurement: none, a busy week, and the maximum less those that are placed."""

CLIENTS = (1, 16)
"""Concurrent clients: one system that waits for each answer, and a rush of them."""

ORDERS = {1: 60, 16: 200}
"""Orders placed in one round, by the number of clients: some tenths of a second, so that other load disturbs both
alike."""

ROUNDS = 9
"""Rounds of each, in turns; the figures are their medians."""

AIM = 0.8
"""Least share of the rate of bare inserts, with any number of open orders: the rest may cost a fifth."""

QUICK_ROUNDS = 3


def measure(quick: bool) -> list[Row]:
    """Measure both databases; PostgreSQL where it is installed.

    Args:
        quick: fewer rounds.
    """
    rows = []
    rounds = QUICK_ROUNDS if quick else ROUNDS
    # Each customer places one order in every round before its clock starts.
    placed = sum(ORDERS[clients] + clients for clients in CLIENTS) * rounds
    with _databases() as databases:
        for name, fresh in databases:
            for number, waiting in enumerate(OPEN):
                bare_url, our_url = fresh(f"bare{number}"), fresh(f"ours{number}")
                token = asyncio.run(prepare(our_url, min(waiting, MAX_OPEN_ORDERS - placed)))
                with serving("bare", bare_url, token) as bare, serving("ours", our_url, token) as ours:
                    rows += [_row(name, waiting, clients, bare, ours, rounds) for clients in CLIENTS]
    return rows


def _row(database: str, waiting: int, clients: int, bare: Served, ours: Served, rounds: int) -> Row:
    rates_hz: dict[Served, list[float]] = {bare: [], ours: []}
    used_s = dict.fromkeys(rates_hz, 0.0)
    for _ in range(rounds):
        for served, told in rates_hz.items():
            before_s = Usage.of([served.pid]).processor_s
            told.append(asyncio.run(Customers(served, clients).place(ORDERS[clients])))
            used_s[served] += Usage.of([served.pid]).processor_s - before_s
    our_hz, bare_hz = median(rates_hz[ours]), median(rates_hz[bare])
    each_ms = {served: 1000 * used_s[served] / (rounds * (ORDERS[clients] + clients)) for served in used_s}
    said = f"{clients} client{'s' if clients > 1 else ''}"
    return Row(
        f"orders: {database}, {waiting:,} open, {said}",
        our_hz,
        "1/s",
        bare_hz,
        "bare inserts of the same rows",
        AIM * bare_hz,
        note=f"processor time of an order {each_ms[ours]:.2f} ms, bare {each_ms[bare]:.2f} ms",
    )


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
    """Databases by name, each with a factory for new ones."""
    with ExitStack() as stack:
        folder = Path(stack.enter_context(TemporaryDirectory()))
        databases: list[tuple[str, _Files | _Server]] = [("SQLite", _Files(folder))]
        programs = installed()
        if programs is not None:
            server = PostgresServer(programs)
            stack.callback(server.close)
            databases.append(("PostgreSQL", _Server(server)))
        yield databases
