"""Benchmark `history`: how long a person waits for a search in a factory's whole history.

It writes 100,000 orders, as many tasks and 3,000,000 events (`quick`: a tenth of each) into a new database. The
alerts, the audit log, the minutes and the spells of those ten weeks are added. Then it asks as the panels ask. It
looks for a name that one order in ten thousand has, a page deep in the list, and all late orders. It also reads the
page of an order, with its events or without forgotten ones, and a shift's report. The time to build the database is
reported separately. The baseline counts the rows of the same table in the same run and on the same connection. It
reads every row once and returns none. A search for an order has another baseline: a bare SQL query of an index. It
asks for the id of the order with exactly this reference. All tables have their statistics (ANALYZE). `replay`
measures the moments that panels showed.

Afterwards the same pages are read over REST and orders are placed, while a hundredth of the log is forgotten (`use`).
The duration of one such transaction, in which nobody else can write, is reported separately.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Awaitable, Callable, Iterator, Sequence
from statistics import median
from typing import Any

from sqlalchemy import Table, func, select, text

from dray.gateway.factory.shift_reporter import ShiftReporter
from dray.gateway.live.projection import Projection
from dray.gateway.live.timescale import TimeScale
from dray.gateway.orders.timeline import timeline
from dray.plant import default_plant
from dray.store import Store, Work
from dray.store.access.audit import AuditFilter
from dray.store.database.searching import Sought
from dray.store.factory.alert_history import AlertFilter, alerts
from dray.store.history.events import EventFilter
from dray.store.orders.order_filter import EVERY_ORDER, OrderFilter
from dray.store.orders.order_histories import KINDS, together
from dray.store.orders.order_sorting import Sorting
from dray.store.orders.tasks import TaskFilter, tasks
from dray.store.retention import AT_ONCE, DAY_S, Retention
from dray.store.tables import audit, events, orders
from dray_sim.bench.history.data import EVENTS_EACH, EVERY_S, NOW_S, filled, order_of
from dray_sim.bench.history.forgetting import TimedStore, kept_after
from dray_sim.bench.history.use import BEFORE, beside, used
from dray_sim.bench.postgres import databases
from dray_sim.bench.row import Row

ORDERS = 100_000

AIM_MS = 200.0
"""Aim for a list (ms): for a later one people wait noticeably."""

REPORT_MS = 1_000.0
"""A page with all figures of a shift; nobody turns its pages."""

START_MS = 60_000.0
"""Aim for a historian's start (ms): agents keep only their last 10,000 facts for it."""

PAGE = 51
"""Rows that a panel asks for: fifty, and one that shows whether there are more."""

CSV_ROWS = 200
"""Rows in the first part of a CSV file: the answer begins with them."""

SHIFT_S = 8 * 3600.0

ROUNDS = 7

BARE_ROUNDS = 101
"""Rounds of a query that takes a fraction of a millisecond."""

FORGOTTEN = 20
"""Transactions that forget."""

Read = Callable[[Work], Awaitable[Sequence[object]]]

Ask = Callable[[Store], Awaitable[Sequence[object]]]


def measure(quick: bool) -> list[Row]:
    """Measure both databases; PostgreSQL where it is installed.

    Args:
        quick: a tenth of the rows.
    """
    return asyncio.run(measured(ORDERS // 10 if quick else ORDERS))


async def measured(many: int, before: int = BEFORE) -> list[Row]:
    """Measure both databases.

    Args:
        many: orders there are.
        before: orders that are placed before anything is forgotten.
    """
    rows: list[Row] = []
    with databases() as both:
        for name, url in both.items():
            begun_s = time.perf_counter()
            async with filled(url, many) as store:
                rows.append(await _built(f"history: {name}", store, time.perf_counter() - begun_s))
                bare_ms = await _bare_ms(store)
                for what, table, ask in _questions(many):
                    row = await _row(f"history: {name}, {what}", store, table, ask)
                    rows.append(row if what != _search_of(many) else beside(row, bare_ms))
                rows.append(await _size(f"history: {name}, size", store))
                rows += await used(f"history: {name}", url, store, many, bare_ms, before)
                rows.append(await _start(f"history: {name}, the historian's start", store))
                rows.append(await _forgotten(f"history: {name}", store))
                what = "the page of an order whose events are forgotten"
                rows.append(
                    await _row(f"history: {name}, {what}", store, events, _order_page(order_of(many - 1).id))
                )
    return rows


async def _built(name: str, store: Store, took_s: float) -> Row:
    async with store.database.read() as connection:
        count = (await connection.execute(select(func.count()).select_from(events))).scalar_one()
    return Row(f"{name}, {count:,} events built in", took_s, "s", took_s, "itself")


def _questions(many: int) -> Iterator[tuple[str, Table, Ask]]:
    """The questions, each with the table that is read for it."""

    def orders_page(wanted: OrderFilter, sorting: Sorting, after: Any = None, limit: int = PAGE) -> Ask:
        return _read(lambda work: work.orders.page(wanted, after, limit, sorting))

    one = OrderFilter(words=(Sought("d5"),))
    deep = order_of(many // 2)
    work_first = Sorting("work")
    yield _search_of(many), orders, orders_page(one, work_first)
    yield "first page", orders, orders_page(EVERY_ORDER, work_first)
    yield "a page in the middle", orders, orders_page(EVERY_ORDER, work_first, work_first.place(deep))
    yield "first part of a CSV file", orders, orders_page(EVERY_ORDER, work_first, limit=CSV_ROWS)
    yield "late orders by customer", orders, orders_page(OrderFilter(late_at_s=NOW_S), Sorting("customer"))
    yield (
        f"a vehicle in {many:,} tasks",
        tasks,
        _read(lambda work: work.tasks.page(TaskFilter(words=(Sought("atv0"), Sought("d5"))), None, PAGE)),
    )
    yield (
        "tasks by how late they were",
        tasks,
        _read(lambda work: work.tasks.page(TaskFilter(late_at_s=NOW_S), None, PAGE, "late")),
    )
    yield (
        f"an order in {many * EVENTS_EACH:,} events",
        events,
        _read(lambda work: work.events.page(EventFilter(order=deep.id), None, PAGE, newest_first=False)),
    )
    yield "the page of an order", events, _order_page(deep.id)
    yield "alerts of one machine", alerts, _read(lambda work: work.alerts.page(_ALERTS, None, PAGE))
    yield (
        "the audit log of one person",
        audit,
        _read(lambda work: work.audit.page(AuditFilter(who="P7", until_s=deep.created_at_s), None, PAGE)),
    )
    word = AuditFilter(words=(Sought("d5"),), by_orders=True)
    yield (
        f"D5 in {many:,} lines of the audit log",
        audit,
        _read(lambda work: work.audit.page(word, None, PAGE)),
    )
    yield "the report of a shift ten days ago", events, _report


_ALERTS = AlertFilter(words=(Sought("m4"),))


def _order_page(order: str) -> Ask:
    async def read(work: Work) -> Sequence[object]:
        goals = (await work.goals.of_orders([order]))[order]
        await work.milestones.of_order(order)
        logged = await work.events.page(
            EventFilter(kinds=KINDS, order=order), None, 5_001, newest_first=False
        )
        kept = await work.order_histories.of_order(order)
        return timeline(together(kept, logged), goals).moments

    return _read(read)


async def _report(store: Store) -> Sequence[object]:
    """The report of a shift ten days ago, compared with the shift a day before it."""
    projection = Projection(default_plant().file, TimeScale(0.0, NOW_S))
    since_s = NOW_S - 10 * DAY_S
    report = await ShiftReporter(store, projection, None, 1.0).report(
        since_s, since_s + SHIFT_S, since_s - DAY_S, NOW_S, orders=True, people=True
    )
    return report.figures


def _read(read: Read) -> Ask:
    async def ask(store: Store) -> Sequence[object]:
        async with store.read() as work:
            return await read(work)

    return ask


async def _row(name: str, store: Store, table: Table, ask: Ask) -> Row:
    asked_ms: list[float] = []
    counted_ms: list[float] = []
    found = 0
    for _ in range(ROUNDS):
        begun_s = time.perf_counter()
        found = len(await ask(store))
        asked_ms.append(1000 * (time.perf_counter() - begun_s))
        # A large table is counted once: that takes seconds.
        if not counted_ms or counted_ms[0] < AIM_MS:
            counted_ms.append(await _counted_ms(store, table))
    note = f"{found} rows; slowest of {ROUNDS} {max(asked_ms):.0f} ms"
    aim_ms = REPORT_MS if ask is _report else AIM_MS
    return Row(
        name, median(asked_ms), "ms", median(counted_ms), "to count the table", aim_ms, note, less=True
    )


def _search_of(many: int) -> str:
    return f"D5 in {many:,} orders"


async def _bare_ms(store: Store) -> float:
    """Median time of the bare query of an index, measured at the driver."""
    one = text("SELECT id FROM orders WHERE reference = :reference")
    took_ms: list[float] = []
    async with store.database.read() as connection:
        for _ in range(BARE_ROUNDS):
            begun_s = time.perf_counter()
            (await connection.execute(one, {"reference": order_of(0).reference})).scalar_one()
            took_ms.append(1000 * (time.perf_counter() - begun_s))
    return median(took_ms)


async def _counted_ms(store: Store, table: Table) -> float:
    async with store.database.read() as connection:
        begun_s = time.perf_counter()
        (await connection.execute(select(func.count()).select_from(table))).scalar_one()
        return 1000 * (time.perf_counter() - begun_s)


async def _size(name: str, store: Store) -> Row:
    """All of it, with its indexes."""
    async with store.database.read() as connection:
        if connection.dialect.name == "postgresql":
            query = "SELECT pg_database_size(current_database())"
        else:
            query = "SELECT page_count * page_size FROM pragma_page_count(), pragma_page_size()"
        size = (await connection.execute(text(query))).scalar_one()
        count = (await connection.execute(select(func.count()).select_from(events))).scalar_one()
    note = f"{size / count:,.0f} bytes for each of {count:,} events, with the orders and all else"
    return Row(name, size / 1e9, "GB", size / 1e9, "itself", note=note)


async def _start(name: str, store: Store) -> Row:
    counted_ms = await _counted_ms(store, events)
    async with store.read() as work:
        begun_s = time.perf_counter()
        known = await work.events.known()
        took_ms = 1000 * (time.perf_counter() - begun_s)
    note = f"{len(known)} lives"
    return Row(name, took_ms, "ms", counted_ms, "to count the table", START_MS, note, less=True)


async def _forgotten(name: str, store: Store) -> Row:
    """The oldest events, as the historian forgets them."""
    timed = TimedStore(store)
    async with store.read() as work:
        (oldest,) = await work.events.page(EventFilter(), None, 1, newest_first=False)
    old = oldest.at_s + EVERY_S * FORGOTTEN * AT_ONCE / EVENTS_EACH
    begun_s = time.perf_counter()
    await Retention(timed, kept_after(old), lambda: NOW_S).forget()
    a_second = FORGOTTEN * AT_ONCE / (time.perf_counter() - begun_s)
    took_ms = timed.took_ms[:FORGOTTEN]
    note = f"{AT_ONCE} events each, {a_second:,.0f} a second with pauses; slowest of {FORGOTTEN} {max(took_ms):.0f} ms"
    return Row(
        f"{name}, a transaction that forgets",
        median(took_ms),
        "ms",
        AIM_MS,
        "what is waited for",
        AIM_MS,
        note,
        less=True,
    )
