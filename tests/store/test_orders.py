"""Orders, keys and products in SQL."""

from __future__ import annotations

import msgspec
import pytest
from history import GEAR, PUMP, keep, order
from sqlalchemy.exc import IntegrityError

from dray.store import Store
from dray.store.orders.idempotency_keys import KeptAnswer
from dray.store.orders.order_filter import EVERY_ORDER, OrderFilter
from dray.store.orders.orders import Item, OrderTotals
from dray.store.orders.progress import Goal, OrderStatus, Progress, progress

pytestmark = pytest.mark.anyio


async def test_an_order_is_found_as_it_was_kept(store: Store) -> None:
    await keep(store, order(1, 4, 2), order(2))
    async with store.read() as work:
        assert await work.orders.get("O-1") == order(1, 4, 2)
        assert await work.orders.get("O-3") is None


async def test_an_order_of_a_product_that_was_never_made_here_is_refused(store: Store) -> None:
    with pytest.raises(IntegrityError):
        async with store.write() as work:
            await work.orders.add(order())


async def test_pages_are_newest_first_and_miss_nothing(store: Store) -> None:
    await keep(store, *(order(number) for number in range(1, 8)))
    seen: list[str] = []
    after: tuple[float, str] | None = None
    async with store.read() as work:
        while page := await work.orders.page(EVERY_ORDER, after, 3):
            seen += [one.id for one in page]
            after = (page[-1].created_at_s, page[-1].id)
    assert seen == [f"O-{number}" for number in range(7, 0, -1)]


async def test_a_page_holds_only_the_statuses_that_were_asked_for(store: Store) -> None:
    await keep(store, order(1), order(2, status=OrderStatus.STORED), order(3, status=OrderStatus.CANCELLED))
    wanted = OrderFilter(statuses=(OrderStatus.STORED, OrderStatus.CANCELLED))
    async with store.read() as work:
        found = await work.orders.page(wanted, None, 10)
        assert [one.id for one in found] == ["O-3", "O-2"]
        assert [one.id for one in await work.orders.open()] == ["O-1"]


async def test_whatever_changes_an_order_says_when(store: Store) -> None:
    await keep(store, order(1), order(2))
    one = order(1)
    begun = Progress(OrderStatus.RELEASED, (1,), (0,), None)
    seen = []
    async with store.write() as work:
        for change in (
            work.orders.advance(one, begun, 2009.0),
            work.orders.advance(msgspec.structs.replace(one, items=(Item("P1", 4, 1),)), begun, 2010.0),
            work.orders.revoke("O-1", 2011.0),
            work.orders.store("O-1", 1, (3,), 2012.0),
            work.orders.release("O-1", 2013.0, 2100.0),
            work.orders.cancel("O-1", 2014.0),
        ):
            await change
            found = await work.orders.get("O-1")
            assert found is not None
            seen.append(found.updated_at_s)
        since = [OrderFilter(updated_since_s=at_s) for at_s in (2014.0, 2014.001)]
        assert [len(await work.orders.page(each, None, 10)) for each in since] == [1, 0]
    assert seen == [2009.0, 2009.0, 2011.0, 2012.0, 2013.0, 2014.0]


async def test_only_a_stored_order_is_released_and_only_an_unended_one_cancelled(store: Store) -> None:
    await keep(store, order(1, status=OrderStatus.STORED), order(2, status=OrderStatus.DELIVERED))
    async with store.write() as work:
        for number in (1, 2):
            await work.orders.release(f"O-{number}", 10.0, 20.0)
        one, two = [await work.orders.get(f"O-{number}") for number in (1, 2)]
        assert one is not None
        assert (one.status, one.released_at_s) == (OrderStatus.RELEASED, 10.0)
        for number in (1, 2):
            await work.orders.cancel(f"O-{number}", 20.0)
        one, two = [await work.orders.get(f"O-{number}") for number in (1, 2)]
    assert one is not None
    assert two is not None
    assert (one.status, one.cancelled_at_s) == (OrderStatus.CANCELLED, 20.0)
    assert (two.status, two.cancelled_at_s) == (OrderStatus.DELIVERED, None)


async def test_a_cancelled_order_counts_on_but_stays_cancelled(store: Store) -> None:
    await keep(store, order(status=OrderStatus.CANCELLED))
    async with store.write() as work:
        await work.orders.advance(
            order(status=OrderStatus.CANCELLED), Progress(OrderStatus.DELIVERED, (4,), (4,), 9.0), 9.0
        )
        found = await work.orders.get("O-1")
    assert found is not None
    assert (found.status, found.delivered_at_s, found.items[0].delivered) == ("cancelled", None, 4)


async def test_an_order_that_is_taken_back_is_stored_when_the_factory_says_so_and_keeps_what_arrived(
    store: Store,
) -> None:
    await keep(store, order(1, 4, 2))
    async with store.write() as work:
        await work.orders.store("O-1", 1, (0, 1), 15.0)
        asked = [await work.orders.get("O-1")]
        for at_s in (20.0, 21.0):
            await work.orders.revoke("O-1", at_s)
        asked.append(await work.orders.get("O-1"))
        await work.orders.store("O-1", 2, (0, 1), 25.0)
        asked.append(await work.orders.get("O-1"))
        await work.orders.store("O-1", 1, (1, 2), 26.0)
        found = await work.orders.get("O-1")
        await work.orders.release("O-1", 30.0, 40.0)
        again = await work.orders.get("O-1")
    assert [one and (one.status, one.revoked_at_s, one.being_revoked) for one in asked] == [
        ("released", None, False),
        ("released", 20.0, True),
        ("released", 20.0, True),
    ]
    assert found is not None
    assert (found.status, found.revoked_at_s, found.delivered) == ("stored", 20.0, (3, 0))
    assert not found.being_revoked
    assert again is not None
    assert (again.status, again.releases, again.revoked_at_s) == ("released", 2, None)
    assert again.outstanding == (1, 2)


async def test_a_strategist_that_knows_nothing_of_a_release_leaves_what_is_known_of_it(store: Store) -> None:
    await keep(store, order())
    async with store.write() as work:
        await work.orders.advance(order(), Progress(OrderStatus.IN_DELIVERY, (3,), (2,), None), 9.0)
        await work.orders.revoke("O-1", 20.0)
        await work.orders.store("O-1", 1, (), 25.0)
        found = await work.orders.get("O-1")
    assert found is not None
    assert (found.status, found.delivered) == ("stored", (2,))


async def test_an_order_that_was_taken_back_too_late_is_delivered(store: Store) -> None:
    await keep(store, order())
    async with store.write() as work:
        await work.orders.revoke("O-1", 20.0)
        await work.orders.store("O-1", 1, (0,), 25.0)
        found = await work.orders.get("O-1")
    assert found is not None
    assert (found.status, found.revoked_at_s, found.delivered) == ("delivered", None, (4,))
    assert found.delivered_at_s == 25.0


@pytest.mark.parametrize("told_s", [None, 15.0])
async def test_an_order_ends_by_the_factorys_word_as_of_the_last_delivery_that_facts_tell_of(
    store: Store, told_s: float | None
) -> None:
    await keep(store, order(1, 4, 2), order(2))
    async with store.write() as work:
        await work.goals.put(
            [
                Goal("G1", "O-1", 0, "P1", 4, "M1", incarnation=1, made=1, delivered_at_s=told_s),
                Goal("G2", "O-1", 1, "P2", 2, "M2", incarnation=1, made=2),
                Goal("G3", "O-2", 0, "P1", 4, "M1", incarnation=1, delivered=2, delivered_at_s=18.0),
            ]
        )
        await work.orders.fulfil("O-1", 1, 20.0)
        found, other = await work.orders.get("O-1"), await work.orders.get("O-2")
    assert found is not None
    assert other is not None
    assert (found.status, found.delivered_at_s) == ("delivered", told_s or 20.0)
    assert [(item.made, item.delivered) for item in found.items] == [(4, 4), (2, 2)]
    assert other.status == "released"


@pytest.mark.parametrize("status", [OrderStatus.CANCELLED, OrderStatus.STORED, OrderStatus.DELIVERED])
async def test_the_factorys_word_ends_no_order_that_has_ended_or_is_stored(
    store: Store, status: OrderStatus
) -> None:
    kept = msgspec.structs.replace(order(status=status), releases=1)
    await keep(store, kept)
    async with store.write() as work:
        await work.orders.fulfil("O-1", 1, 20.0)
        assert await work.orders.get("O-1") == kept


async def test_the_factorys_word_ends_neither_another_release_nor_an_order_that_is_taken_back(
    store: Store,
) -> None:
    await keep(store, order(1), order(2))
    async with store.write() as work:
        await work.orders.fulfil("O-1", 2, 20.0)
        await work.orders.revoke("O-2", 10.0)
        await work.orders.fulfil("O-2", 1, 20.0)
        found = [await work.orders.get(f"O-{number}") for number in (1, 2)]
    assert [one and (one.status, one.delivered) for one in found] == [("released", (0,))] * 2


async def test_facts_that_come_when_an_order_has_ended_change_only_the_time_of_its_end(store: Store) -> None:
    await keep(store, order(1, 4))
    times_s: list[float | None] = []
    async with store.write() as work:
        await work.orders.fulfil("O-1", 1, 20.0)
        for goals in ([], [delivered_goal(1, 15.0)], [delivered_goal(1, 15.0), delivered_goal(3, 16.0)]):
            read = await work.orders.get("O-1")
            assert read is not None
            await work.orders.advance(read, progress(read.quantities, goals, 1, read.delivered), 30.0)
            found = await work.orders.get("O-1")
            assert found is not None
            assert (found.status, found.items) == ("delivered", read.items)
            times_s.append(found.delivered_at_s)
    assert times_s == [20.0, 15.0, 16.0]


def delivered_goal(pieces: int, at_s: float) -> Goal:
    """A goal of the first item of which so many pieces have arrived."""
    goal = Goal(f"G{pieces}", "O-1", 0, "P1", pieces, "M1", incarnation=1)
    goal.made = goal.delivered = pieces
    goal.delivered_at_s = at_s
    return goal


async def test_an_advance_that_was_read_before_somebody_took_the_order_back_does_not_undo_that(
    store: Store,
) -> None:
    await keep(store, order())
    async with store.write() as work:
        read = await work.orders.get("O-1")
        assert read is not None
        await work.orders.revoke("O-1", 20.0)
        await work.orders.store("O-1", 1, (4,), 25.0)
        await work.orders.advance(read, Progress(OrderStatus.IN_PRODUCTION, (1,), (0,), None), 30.0)
        found = await work.orders.get("O-1")
    assert found is not None
    assert found.status is OrderStatus.STORED


async def test_totals_count_an_order_without_due_time_as_on_time(store: Store) -> None:
    finished = [order(number, status=OrderStatus.DELIVERED) for number in (1, 2, 3)]
    finished[0].delivered_at_s, finished[1].delivered_at_s = 4000.0, 6000.0
    finished[2].due_at_s, finished[2].delivered_at_s = None, 9000.0
    await keep(store, order(4), *finished)
    async with store.read() as work:
        assert await work.orders.totals() == OrderTotals(delivered=3, on_time=2)


async def test_an_older_life_of_the_strategist_is_not_noted(store: Store) -> None:
    await keep(store, order())
    async with store.write() as work:
        for life in (3, 2):
            await work.orders.accept({"O-1": life})
        found = await work.orders.get("O-1")
    assert found is not None
    assert found.incarnation == 3


async def test_products_that_left_the_plant_stay_known_to_their_orders(store: Store) -> None:
    await keep(store, order(1, 4, 2))
    renamed = msgspec.structs.replace(PUMP, name="Better pump")
    async with store.write() as work:
        await work.products.replace([renamed])
        assert await work.products.made_here() == ["P2"]
        await work.products.replace([GEAR, renamed])
        assert await work.products.made_here() == ["P1", "P2"]
        assert await work.orders.get("O-1") == order(1, 4, 2)


async def test_a_key_is_kept_with_its_answer_and_forgotten_with_age(store: Store) -> None:
    kept = KeptAnswer("key", "print", "O-1", '{"id":"O-1"}', 1000.0)
    await keep(store, order())
    async with store.write() as work:
        await work.keys.add(kept)
        assert await work.keys.get("key") == kept
        assert await work.keys.get("other") is None
        await work.keys.forget_before(1000.0)
        assert await work.keys.get("key") == kept
        await work.keys.forget_before(1000.1)
        assert await work.keys.get("key") is None


async def test_a_key_cannot_be_used_twice(store: Store) -> None:
    kept = KeptAnswer("key", "print", "O-1", "{}", 1.0)

    async def use_it() -> None:
        async with store.write() as work:
            await work.keys.add(kept)

    await keep(store, order())
    await use_it()
    with pytest.raises(IntegrityError):
        await use_it()
