"""Customers' links: found by their token alone, taken back, and made for orders of an older Dray."""

from __future__ import annotations

import pytest
from history import keep, order
from sqlalchemy import text

from dray.store import Store, downgrade, upgrade
from dray.store.access.digest import digest
from dray.store.orders.milestones import OrderTimes
from dray.store.orders.tracking_links import Link

pytestmark = pytest.mark.anyio


async def test_a_link_is_found_by_its_token_and_by_nothing_like_it(store: Store) -> None:
    await keep(store, order(1), order(2))
    async with store.write() as work:
        await work.links.add("one", Link("O-1", 10.0))
        await work.links.add("two", Link("O-2", 11.0, expires_at_s=99.0))
    async with store.read() as work:
        assert await work.links.find("one") == Link("O-1", 10.0)
        assert await work.links.find("two") == Link("O-2", 11.0, expires_at_s=99.0)
        for other in ("", "One", "one ", "o%", digest("one"), "\udcff"):
            assert await work.links.find(other) is None


async def test_no_token_of_a_link_is_written_down(store: Store) -> None:
    await keep(store, order(1))
    async with store.write() as work:
        await work.links.add("made-by-hand", Link("O-1", 10.0))
    async with store.database.read() as connection:
        rows = (await connection.execute(text("SELECT * FROM tracking_links"))).all()
    assert digest("made-by-hand") in rows[0]
    assert "made-by-hand" not in str(rows)


async def test_what_is_taken_back_stays_so_and_is_counted_once(store: Store) -> None:
    await keep(store, order(1), order(2))
    async with store.write() as work:
        for token, of in (("a", "O-1"), ("b", "O-1"), ("c", "O-2")):
            await work.links.add(token, Link(of, 10.0))
        assert await work.links.revoke("a", 20.0) == 1
        assert await work.links.revoke("a", 30.0) == 0
        assert await work.links.revoke_all("O-1", 40.0) == 1
        assert await work.links.revoke_all("O-3", 40.0) == 0
    async with store.read() as work:
        assert await work.links.find("a") == Link("O-1", 10.0, revoked_at_s=20.0)
        assert await work.links.find("b") == Link("O-1", 10.0, revoked_at_s=40.0)
        assert await work.links.find("c") == Link("O-2", 10.0)


async def test_the_links_of_orders_of_an_older_dray_go_on_working(store: Store) -> None:
    await keep(store, order(1), order(2))
    await downgrade(store.database, "0001")
    await upgrade(store.database)
    async with store.read() as work:
        assert await work.links.find("token-1") == Link("O-1", 1001.0)
        assert await work.links.find("token-2") == Link("O-2", 1002.0)
        assert await work.orders.get("O-1") == order(1)


async def test_an_order_of_which_nothing_was_heard_has_reached_nothing(store: Store) -> None:
    await keep(store, order(1))
    async with store.read() as work:
        assert await work.milestones.of_order("O-1") == OrderTimes()
        assert await work.milestones.piece_times_s(["g"]) == {"g": ()}
        assert await work.milestones.promises_missed_by_s() == ()
