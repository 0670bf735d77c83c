"""The statistics of a fleet: orders late or in time, and whether the history is whole."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Awaitable, Callable
from pathlib import Path

from dray.cli.fleet.rollout.order_statistics import OrderCount, OrderStatistics
from dray.messages import Event
from dray.messages.fact import TaskClosed
from dray.plant.model import BillLine, Product
from dray.store import Store, open_store
from dray.store.orders.orders import Item, Order
from dray.store.orders.progress import OrderStatus


def closed(number: int, life: int = 1, at_s: float = 100.0) -> Event:
    fact = TaskClosed(task=f"M1-{life}.{number}", epoch=1, outcome="delivered", carrier="ATV1")
    return Event(agent="M1", incarnation=life, number=number, at_s=at_s, fact=fact)


def order(number: int, due_at_s: float | None, delivered_at_s: float | None = None) -> Order:
    return Order(
        id=f"O-{number}",
        status=OrderStatus.DELIVERED if delivered_at_s else OrderStatus.RELEASED,
        customer="Hall 3",
        token=f"token {number}",
        items=(Item("P1", 1),),
        created_at_s=1.0,
        due_at_s=due_at_s,
        delivered_at_s=delivered_at_s,
    )


def with_books(
    folder: Path, fill: Callable[[Store], Awaitable[None]], look: Callable[[OrderStatistics], Awaitable[None]]
) -> None:
    """Fill a database, and look into it as a command does."""
    url = f"sqlite+aiosqlite:///{folder / 'dray.db'}"

    async def story() -> None:
        store = await open_store(url)
        try:
            await fill(store)
        finally:
            await store.close()
        async with OrderStatistics.open(url) as statistics:
            await look(statistics)

    asyncio.run(story())


def test_an_order_is_late_when_its_time_is_over_whether_or_not_it_has_come(tmp_path: Path) -> None:
    now_s = time.time()
    orders = (
        order(1, due_at_s=100.0, delivered_at_s=90.0),
        order(2, due_at_s=100.0, delivered_at_s=110.0),
        order(3, due_at_s=now_s - 60.0),
        order(4, due_at_s=now_s + 3600.0),
        order(5, due_at_s=None),
    )

    async def fill(store: Store) -> None:
        async with store.write() as work:
            await work.products.replace(
                [Product(id="P1", name="Gear unit", lot=4, bill=(BillLine("steel", 1),))]
            )
            for each in orders:
                await work.orders.add(each)

    async def look(statistics: OrderStatistics) -> None:
        assert await statistics.orders() == OrderCount(delivered=2, late=2)

    with_books(tmp_path, fill, look)
    assert OrderCount(5, 3).since(OrderCount(2, 2)) == OrderCount(3, 1)


def test_the_history_is_whole_when_all_facts_of_the_present_lives_are_written(tmp_path: Path) -> None:
    async def fill(store: Store) -> None:
        async with store.write() as work:
            told = [closed(1), closed(1, life=2), closed(3, life=2), closed(6, life=2)]
            await work.events.add(told, lambda plant_s: plant_s)

    async def look(statistics: OrderStatistics) -> None:
        for numbers, lacking in (
            ({}, 0),
            ({"M1": (2, 1)}, 0),
            ({"M1": (2, 3)}, 1),
            ({"M1": (2, 6)}, 3),
            ({"M1": (2, 8)}, 5),
            ({"M1": (3, 2)}, 2),
            ({"M1": (2, 3), "M2": (1, 4)}, 5),
        ):
            assert await statistics.missing(numbers) == lacking

    with_books(tmp_path, fill, look)


def test_the_history_is_that_of_a_time(tmp_path: Path) -> None:
    async def fill(store: Store) -> None:
        async with store.write() as work:
            await work.events.add(
                [closed(number, at_s=100.0 * number) for number in range(1, 6)], lambda plant_s: plant_s
            )

    async def look(statistics: OrderStatistics) -> None:
        assert (await statistics.history(200.0, 400.0)).delivered_s == [200.0, 300.0, 400.0]

    with_books(tmp_path, fill, look)
