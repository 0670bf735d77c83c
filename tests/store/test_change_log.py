"""The change log: whatever changes an order or a transport is in it, once, in the order of the commits."""

from __future__ import annotations

import asyncio

import msgspec
import pytest
from history import keep, order
from sqlalchemy import text

from dray.messages import TransportState
from dray.priorities import Priority
from dray.store import Store, downgrade, upgrade
from dray.store.orders.change_log import ORDER, TRANSPORT, Seen
from dray.store.orders.order_changes import Change
from dray.store.orders.orders import Order
from dray.store.orders.progress import OrderStatus, Progress
from dray.store.orders.transports import TransportFilter, TransportRow

pytestmark = pytest.mark.anyio

ALL = Seen(orders=True, transports=TransportFilter())

HUGE = 2**62


def transport(number: int = 1, **fields: object) -> TransportRow:
    row = TransportRow(
        id=f"T-{number}",
        status=TransportState.WAITING,
        source="S1",
        destination="M1",
        item="steel",
        quantity=4,
        priority=Priority.NORMAL.value,
        caller="key one",
        called_by="One",
        created_at_s=1000.0,
        due_at_s=2000.0,
        updated_at_s=1000.0,
    )
    return msgspec.structs.replace(row, **fields)


async def call(store: Store, *rows: TransportRow) -> None:
    async with store.write() as work:
        for row in rows:
            assert await work.transports.add(row)


async def told(store: Store, after: int = 0, seen: Seen = ALL) -> list[tuple[str, str]]:
    async with store.read() as work:
        rows = await work.change_log.page(after, HUGE, seen, 1000)
    assert [row.position for row in rows] == sorted({row.position for row in rows})
    return [(row.subject, row.status) for row in rows]


async def test_each_way_in_which_an_order_changes_is_in_it(store: Store) -> None:
    await keep(store, order(1, 4), order(2, 1, status=OrderStatus.STORED))
    assert await told(store) == [("O-1", "released"), ("O-2", "stored")]
    async with store.write() as work:
        await work.orders.release("O-2", 2000.0, 3000.0)
    async with store.write() as work:
        one = await work.orders.get("O-1")
        assert one is not None
        await work.orders.advance(one, Progress(OrderStatus.IN_PRODUCTION, (1,), (0,), None), 2001.0)
    async with store.write() as work:
        one = await work.orders.get("O-1")
        assert one is not None
        # No status changes, and one more is made.
        await work.orders.advance(one, Progress(OrderStatus.IN_PRODUCTION, (2,), (1,), None), 2002.0)
        two = await work.orders.get("O-2")
        assert two is not None
        change = Change(
            quantities=(3,), reference="x", due_at_s=None, priority=Priority.HIGH, wanted_at_s=None
        )
        await work.order_changes.ask(two, change, 2002.0)
    async with store.write() as work:
        await work.orders.revoke("O-1", 2003.0)
    async with store.write() as work:
        await work.orders.store("O-1", 1, (3,), 2004.0)
    async with store.write() as work:
        await work.orders.cancel("O-1", 2005.0)
        await work.orders.cancel("O-1", 2006.0)
    assert (await told(store))[2:] == [
        ("O-2", "released"),
        ("O-1", "in_production"),
        ("O-1", "in_production"),
        ("O-2", "released"),
        ("O-1", "in_production"),
        ("O-1", "stored"),
        ("O-1", "cancelled"),
    ]


class UndoneError(Exception):
    pass


async def keep_and_undo(store: Store, one: Order) -> None:
    async with store.write() as work:
        await work.orders.add(one)
        raise UndoneError


async def test_what_is_undone_was_no_change(store: Store) -> None:
    await keep(store)
    with pytest.raises(UndoneError):
        await keep_and_undo(store, order(1))
    assert await told(store) == []
    await keep(store, order(2))
    assert await told(store) == [("O-2", "released")]


async def test_transports_are_told_to_whom_they_are_shown(store: Store) -> None:
    await keep(store, order(1))
    await call(store, transport(1), transport(2, source="S2", caller="key two"))
    async with store.write() as work:
        await work.transports.put(transport(2, source="S2", caller="key two", status=TransportState.ON_BOARD))
    order_rows = [("O-1", "released")]
    first, second = [("T-1", "waiting")], [("T-2", "waiting"), ("T-2", "on_board")]
    for seen, shown in (
        (ALL, order_rows + first + second),
        (Seen(orders=True, transports=None), order_rows),
        (Seen(orders=False, transports=TransportFilter()), first + second),
        (Seen(orders=False, transports=TransportFilter(caller="key two")), second),
        (Seen(orders=False, transports=TransportFilter(places=("S2",))), second),
        (Seen(orders=False, transports=TransportFilter(places=("M1",))), first + second),
        (Seen(orders=False, transports=TransportFilter(places=())), []),
        (Seen(orders=False, transports=None), []),
    ):
        assert await told(store, seen=seen) == shown, seen
    async with store.read() as work:
        rows = await work.change_log.page(0, HUGE, ALL, 2)
    assert [(row.kind, row.reference) for row in rows] == [(ORDER, order(1).reference), (TRANSPORT, None)]


async def test_positions_follow_one_another_as_commits_do(store: Store) -> None:
    seen: list[int] = []

    async def place(number: int) -> None:
        await keep(store, order(number))
        async with store.read() as work:
            seen.append((await work.change_log.ends())[1])

    async def follow() -> list[str]:
        at, found = 0, []
        while len(found) < 30:
            async with store.read() as work:
                rows = await work.change_log.page(at, HUGE, ALL, 3)
            found += [row.subject for row in rows]
            at = rows[-1].position if rows else at
            await asyncio.sleep(0)
        return found

    following = asyncio.create_task(follow())
    await asyncio.gather(*(place(number) for number in range(30)))
    assert sorted(await following) == sorted(f"O-{number}" for number in range(30))
    assert seen == sorted(seen)


async def test_what_is_forgotten_leaves_a_mark(store: Store) -> None:
    async with store.read() as work:
        begin, newest = await work.change_log.ends()
    assert begin == newest
    await keep(store, *(order(number) for number in range(1, 8)))
    async with store.read() as work:
        rows = await work.change_log.page(0, HUGE, ALL, 100)
    old_s = rows[4].at_s
    async with store.write() as work:
        # The line with which it begins, and the first four orders, of which the last one stays.
        assert await work.change_log.prune(old_s, 3) == 3
        assert await work.change_log.prune(old_s, 3) == 1
        assert await work.change_log.prune(old_s, 3) == 0
        assert await work.change_log.ends() == (rows[3].position, rows[-1].position)
    async with store.write() as work:
        assert await work.change_log.prune(1e12, 100) == 3
        assert await work.change_log.ends() == (rows[-1].position, rows[-1].position)
    await keep(store, order(9))
    assert await told(store, rows[-1].position) == [("O-9", "released")]


async def test_after_an_upgrade_orders_from_before_are_followed(store: Store) -> None:
    await keep(store, order(1))
    await downgrade(store.database, "0038")
    await upgrade(store.database)
    assert await told(store) == []
    async with store.write() as work:
        await work.orders.cancel("O-1", 2000.0)
    assert await told(store) == [("O-1", "cancelled")]


async def test_the_triggers_are_there_after_all_migrations(store: Store) -> None:
    """SQLite loses those of a table that a migration copies."""
    async with store.database.read() as connection:
        is_sqlite = connection.dialect.name == "sqlite"
        query = (
            "SELECT name FROM sqlite_master WHERE type = 'trigger'"
            if is_sqlite
            else "SELECT tgname FROM pg_trigger WHERE NOT tgisinternal"
        )
        names = set((await connection.execute(text(query))).scalars())
    assert names >= {
        f"log_{what}_{table}" for what in ("new", "changed") for table in ("orders", "transports")
    }
