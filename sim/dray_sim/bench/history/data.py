"""The data of the benchmark `history`: ten weeks of a factory, with nothing by chance but which order is which.

Orders and tasks are made as the gateway and the historian make them. The database itself makes all other rows, for
there are so many; it makes them from a list of what happens to every order.
"""

from __future__ import annotations

from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from random import Random

import msgspec
from sqlalchemy import insert, text
from sqlalchemy.ext.asyncio import AsyncConnection, create_async_engine

from dray.messages import AtvStatus, Phase, Reason, Role, Transport
from dray.messages.fact import (
    AnyFact,
    AtvStatusChanged,
    CarrierChanged,
    GoalContracted,
    GoodsDelivered,
    OrderFulfilled,
    PhaseEntered,
    PieceMade,
    TaskClosed,
    TaskOpened,
)
from dray.store import Store, open_store
from dray.store.access.digest import digest
from dray.store.factory.kpis import KpiSample
from dray.store.orders.orders import Item, Order, rows_of_items, rows_of_orders
from dray.store.orders.progress import OrderStatus
from dray.store.orders.tasks import TaskRow, row_of_task, tasks
from dray.store.tables import events, goals, kpi_samples, order_items, orders, products, tracking_links

EVENTS_EACH = 30
"""Events for each order, of which a third is about it: 100,000 orders have three million, some 1.5 GB with their indexes."""

NOW_S = 1_900_000_000.0

EVERY_S = 60.0
"""Between two orders: 100,000 of them are ten weeks."""

TAKEN_OVER_EVERY = 50
"""Orders, of which one has a takeover."""

SEED = 18
"""The same in every run."""

TASK, GOAL, ORDER = "TASK", "GOAL", "ORDER"
"""Placeholders for the names in what happens to every order."""


def order_of(number: int) -> Order:
    """The newest is 0. One order in ten thousand has D5 in its name."""
    at_s = NOW_S - EVERY_S * number
    name = f"PO-D5-{number}" if number % 10_000 == 5_000 else f"PO-{700_000 + number}"
    ended = number > 40
    return Order(
        id=f"O-{number}",
        status=OrderStatus.DELIVERED if ended else OrderStatus.IN_PRODUCTION,
        customer=f"Customer {number % 211}",
        token=f"token-{number}",
        items=(Item("P1", 4, 4, 4), Item("P2", 2, 2, 2)),
        created_at_s=at_s,
        reference=name,
        due_at_s=at_s + 7200,
        released_at_s=at_s,
        delivered_at_s=at_s + 3600 + number % 97 * 60 if ended else None,
        releases=1,
    )


def _task(number: int, chance: Random) -> TaskRow:
    at_s = NOW_S - EVERY_S * number
    return TaskRow(
        id=f"T-{number}",
        kind="transport",
        coordinator=f"M{number % 12}",
        item="P1",
        quantity=4,
        source=f"M{number % 12}",
        destination="OUT",
        goal=f"G-{number}",
        order_id=f"O-{number}",
        state="delivered",
        carrier=f"ATV{number % 50}",
        standby=f"ATV{(number + 1) % 50}",
        opened_at_s=at_s,
        contracted_at_s=at_s + 3,
        promised_at_s=at_s + 100,
        deadline_at_s=at_s + 300,
        closed_at_s=at_s + chance.uniform(60, 130),
        incarnation=1,
        number=number,
    )


def _goal(number: int) -> dict[str, object]:
    return {
        "id": f"G-{number}",
        "order_id": f"O-{number}",
        "item": 0,
        "product": "P1",
        "quantity": 4,
        "machine": f"M{number % 12}",
    }


def _link(order: Order) -> dict[str, object]:
    return {"token_hash": digest(order.token), "order_id": order.id, "created_at_s": order.created_at_s}


def _happenings() -> Iterator[tuple[AnyFact, bool, bool, bool]]:
    """The facts of every order, each with whether it names the task, the goal and the order."""
    work = Transport("P1", 4, ("M1",), "OUT", "tote", goal=GOAL)
    yield GoalContracted(GOAL, ORDER, 0, "P1", 4, "M1", 900.0), False, True, True
    for made in (1, 2, 3, 4):
        yield PieceMade(GOAL, "P1", made), False, True, False
    yield TaskOpened(TASK, 1, Role.PRIMARY, 1, work, 20.0, 300.0, 5.0), True, True, False
    for phase in (Phase.APPROACHING, Phase.CARRYING, Phase.HANDING_OVER):
        yield PhaseEntered(TASK, 1, phase, "M1"), True, False, False
    yield TaskClosed(TASK, 1, "delivered", "ATV1", 45.0), True, False, False
    yield GoodsDelivered(GOAL, ORDER, 0, "P1", 4, 4), False, True, True
    yield OrderFulfilled(ORDER), False, False, True


_NUMBERS = (
    "WITH RECURSIVE numbers(n) AS (SELECT {first} UNION ALL SELECT n + 1 FROM numbers WHERE n + 1 < {last}) "
)

_STEPS = "CREATE TEMPORARY TABLE steps (step INTEGER, kind TEXT, has_task INTEGER, has_goal INTEGER, has_order INTEGER, fact TEXT, taken_over INTEGER)"

_EVENTS = """
INSERT INTO events (agent, incarnation, number, at_s, plant_s, kind, task, goal, order_id, fact)
SELECT 'M' || (o % 12), 1, (n / 12) * {each} + step + 1, {now} - o * {every} + step * 0.5, {now} - o * {every} + step * 0.5, kind,
    CASE WHEN has_task = 1 THEN 'T-' || o END, CASE WHEN has_goal = 1 THEN 'G-' || o END, CASE WHEN has_order = 1 THEN 'O-' || o END,
    REPLACE(REPLACE(REPLACE(fact, '"TASK"', '"T-' || o || '"'), '"GOAL"', '"G-' || o || '"'), '"ORDER"', '"O-' || o || '"')
FROM (SELECT n, {many} - 1 - n AS o FROM numbers) AS every_order, steps
WHERE taken_over IS NULL OR taken_over = CASE WHEN n % {taken} = 0 THEN 1 ELSE 0 END
ORDER BY n, step
"""

_DETAIL = """'{"customer":"Customer ' || (n % 211) || '","items":[{"product":"P1","quantity": 4},{"product":"P2","quantity": 2}]}'"""

_OTHERS = (
    """
INSERT INTO alerts (alert, kind, level, order_id, since_at_s, ended_at_s, told, search)
SELECT 'machine_error-' || n, 'machine_error', 'alarm', '', {now} - ({many} - n) * {every}, {now} - ({many} - n) * {every} + 300, '{{}}', 'm' || (n % 12)
FROM numbers WHERE n % 10 = 0
""",
    """
INSERT INTO audit (at_s, who, who_kind, from_ip, session, action, target, result, detail, search)
SELECT {now} - ({many} - n) * {every}, 'P' || (n % 23), 'person', '127.0.0.1', '', action, 'O-' || n, 'done', {detail},
    LOWER('P' || (n % 23) || char_10 || action || char_10 || 'O-' || n || char_10 || '127.0.0.1' || char_10 || {detail})
FROM (
    SELECT n, CASE WHEN n % 50 = 0 THEN 'vehicle.command' ELSE 'order.place' END AS action, '
' AS char_10 FROM numbers
) AS every_line
""",
    """
INSERT INTO spells (agent, doing, from_at_s, until_at_s, task, item, source, destination, other)
SELECT 'ATV' || (n % 50), CASE WHEN n % 3 = 0 THEN 'waits' ELSE 'carries' END, {now} - ({many} - n) * {every}, {now} - ({many} - n) * {every} + 240, '', '', '', '', ''
FROM numbers
""",
)
"""Alerts, audit entries of people, and audit entries of vehicles."""


_TAKEOVERS = """
INSERT INTO takeovers (agent, incarnation, number, at_s, fact)
SELECT agent, incarnation, number, at_s, fact FROM events WHERE kind = 'CarrierChanged'
"""


@asynccontextmanager
async def filled(url: str, many: int) -> AsyncIterator[Store]:
    """A store with so many orders, and all that belongs to them."""
    store = await open_store(url)
    chance = Random(SEED)
    try:
        async with store.database.write() as connection:
            names = [{"id": name, "name": name, "made_here": True} for name in ("P1", "P2")]
            await connection.execute(insert(products), names)
        for numbers in _batched(many, 5_000):
            async with store.database.write() as connection:
                new = [order_of(number) for number in numbers]
                rows = rows_of_orders(new)
                await connection.execute(insert(orders), rows)
                await connection.execute(insert(order_items), rows_of_items(new))
                await connection.execute(insert(tracking_links), list(map(_link, new)))
                await connection.execute(insert(goals), list(map(_goal, numbers)))
                told = [
                    row_of_task(_task(number, chance), str(row["search"]))
                    for number, row in zip(numbers, rows, strict=True)
                ]
                await connection.execute(insert(tasks), told)
        async with store.database.write() as connection:
            await connection.execute(insert(kpi_samples), [_minute(number) for number in range(many)])
        await _add_all(url, many)
        yield store
    finally:
        await store.close()


async def _add_all(url: str, many: int) -> None:
    """Write the events of all orders. The indexes are made at the end, and no time limit applies."""
    engine = create_async_engine(url)
    try:
        async with engine.begin() as connection:
            for index in events.indexes:
                await connection.run_sync(index.drop)
        for numbers in _batched(many, 2_000):
            async with engine.begin() as connection:
                await _add(connection, numbers, many)
        for index in events.indexes:
            async with engine.begin() as connection:
                await connection.run_sync(index.create)
        async with engine.begin() as connection:
            await connection.execute(text(_TAKEOVERS))
            # A database does this by itself, in time.
            await connection.execute(text("ANALYZE"))
    finally:
        await engine.dispose()


async def _add(connection: AsyncConnection, numbers: range, many: int) -> None:
    """Write the events of some orders, which are counted from the oldest."""
    await connection.execute(text("DROP TABLE IF EXISTS steps"))
    await connection.execute(text(_STEPS))
    of_step = "INSERT INTO steps VALUES (:step, :kind, :has_task, :has_goal, :has_order, :fact, :taken_over)"
    await connection.execute(text(of_step), list(_steps()))
    values = {
        "many": many,
        "now": NOW_S,
        "every": EVERY_S,
        "each": EVENTS_EACH,
        "taken": TAKEN_OVER_EVERY,
        "detail": _DETAIL,
    }
    first_and_last = _NUMBERS.format(first=numbers.start, last=numbers.stop)
    for statement in (_EVENTS, *_OTHERS):
        await connection.execute(text(first_and_last + statement.format(**values)))


def _steps() -> Iterator[dict[str, object]]:
    often = list(_happenings())
    for step, (fact, task, goal, order) in enumerate(often):
        yield _step(step, fact, task, goal, order)
    rest = range(len(often), EVENTS_EACH)
    taken = CarrierChanged(TASK, 2, "ATV3", "ATV1", Reason.SILENT, 5.5)
    other = AtvStatusChanged(AtvStatus.IDLE)
    yield _step(rest[0], taken, task=True, taken_over=1)
    yield _step(rest[0], other, taken_over=0)
    for step in rest[1:]:
        yield _step(step, other)


def _step(
    step: int,
    fact: AnyFact,
    task: bool = False,
    goal: bool = False,
    order: bool = False,
    taken_over: int | None = None,
) -> dict[str, object]:
    return {
        "step": step,
        "kind": type(fact).__name__,
        "has_task": int(task),
        "has_goal": int(goal),
        "has_order": int(order),
        "fact": msgspec.json.encode(fact).decode(),
        "taken_over": taken_over,
    }


def _minute(number: int) -> dict[str, object]:
    """One sample, with 1 in every field except its times."""
    return dict.fromkeys(KpiSample.__struct_fields__, 1) | {
        "at_s": NOW_S - EVERY_S * number,
        "span_s": EVERY_S,
    }


def _batched(many: int, most: int) -> Iterator[range]:
    for first in range(0, many, most):
        yield range(first, min(first + most, many))
