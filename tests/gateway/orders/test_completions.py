"""An order whose last facts never come ends by the strategist's word, and no other one does."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import Any

import pytest
from gateway_kit import OTHER_PRODUCT, PRODUCT, House, gateway
from heartbeats import events
from wall_clock import NOW_S

from dray.messages import OrderReleased, OrderTaken
from dray.messages.fact import GoalContracted, GoodsDelivered, OrderAccepted
from dray.messages.keys import STRATEGIST
from dray.store.orders.orders import Orders

pytestmark = pytest.mark.anyio

LINES = [{"product": PRODUCT, "quantity": 5}, {"product": OTHER_PRODUCT, "quantity": 2}]


async def told(house: House, order: str, release: int = 1) -> dict[str, Any]:
    """The strategist says that all of the order has arrived, and the gateway has done with it what it does."""
    house.bus.tell(STRATEGIST, "gateway", OrderTaken(order, release, fulfilled=True))
    await house.completions.written()
    answer: dict[str, Any] = await house.get(f"/api/orders/{order}")
    return answer


def arrived(order: str, pieces: int) -> GoodsDelivered:
    return GoodsDelivered(goal="G1", order=order, item=0, product=PRODUCT, quantity=pieces, delivered=pieces)


def begun(order: str) -> list[Any]:
    """M1 makes the first line, and two pieces have arrived."""
    contracted = GoalContracted(
        goal="G1", order=order, item=0, product=PRODUCT, quantity=5, machine="M1", finish_s=9.0
    )
    return events(STRATEGIST, OrderAccepted(order=order, goals=("G1",)), contracted, arrived(order, 2))


def counts(order: dict[str, Any]) -> list[tuple[int, int]]:
    return [(item["made"], item["delivered"]) for item in order["items"]]


async def test_an_order_whose_last_facts_never_come_is_delivered_when_the_strategist_says_so(
    house: House,
) -> None:
    order = (await house.place(items=LINES))["id"]
    await house.say(begun(order))
    assert (await house.get(f"/api/orders/{order}"))["status"] == "in_delivery"
    house.wall.now_s += 3600.0
    ended = await told(house, order)
    assert (ended["status"], counts(ended)) == ("delivered", [(5, 5), (2, 2)])
    # The last delivery of which a fact tells.
    assert ended["delivered_at_s"] == NOW_S + 103.0
    [view] = house.projection.orders.views()
    assert (view.status, view.delivered_at_s) == ("delivered", NOW_S + 103.0)
    assert house.projection.factory(house.wall.now_s).orders_delivered == 1
    assert order not in house.outbox._reminders


async def test_an_order_of_which_no_delivery_was_heard_ends_when_the_strategist_says_so(house: House) -> None:
    order = (await house.place())["id"]
    house.wall.now_s += 3600.0
    assert (await told(house, order))["delivered_at_s"] == house.wall.now_s


async def test_facts_that_are_merely_late_change_only_when_the_order_was_delivered(house: House) -> None:
    order = (await house.place(items=LINES[:1]))["id"]
    assert (await told(house, order))["delivered_at_s"] == NOW_S
    await house.say(begun(order))
    await house.say(events("M1", arrived(order, 5), at_s=200.0))
    late = await house.get(f"/api/orders/{order}")
    assert (late["status"], counts(late), late["delivered_at_s"]) == ("delivered", [(5, 5)], NOW_S + 201.0)
    [view] = house.projection.orders.views()
    assert (view.status, view.delivered_at_s) == ("delivered", NOW_S + 201.0)
    assert house.projection.factory(house.wall.now_s).orders_delivered == 1


@pytest.mark.parametrize("act", ["cancel", "revoke"])
async def test_the_strategists_word_ends_no_order_that_was_cancelled_or_is_being_taken_back(
    house: House, act: str
) -> None:
    order = (await house.place())["id"]
    acted = (await house.client.post(f"/api/orders/{order}/{act}")).json()
    assert await told(house, order) == acted
    assert house.peer.ignored == 1
    assert order in house.outbox._reminders


@pytest.mark.parametrize("act", [Orders.cancel, Orders.revoke])
async def test_a_word_that_crosses_a_cancellation_or_a_revocation_comes_too_late(
    house: House, act: Callable[[Orders, str, float], Awaitable[None]]
) -> None:
    order = (await house.place())["id"]
    async with house.store.write() as work:
        house.bus.tell(STRATEGIST, "gateway", OrderTaken(order, fulfilled=True))
        await act(work.orders, order, NOW_S)
        acted = await work.orders.get(order)
    await house.completions.written()
    async with house.store.read() as work:
        assert await work.orders.get(order) == acted


async def test_only_the_strategists_word_about_the_release_that_was_asked_for_counts(house: House) -> None:
    order = (await house.place())["id"]
    house.bus.tell("ATV1", "gateway", OrderTaken(order, fulfilled=True))
    assert (await told(house, order, release=2))["status"] == "released"
    assert order in house.outbox._reminders
    assert (await told(house, order))["status"] == "delivered"


async def test_the_strategists_word_is_asked_for_until_it_is_written_down(
    house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def fail(_orders: Orders, *_word: Any) -> None:
        raise ConnectionRefusedError

    order = (await house.place())["id"]
    with monkeypatch.context() as patch:
        patch.setattr(Orders, "fulfil", fail)
        assert (await told(house, order))["status"] == "released"
    assert order in house.outbox._reminders
    assert (await told(house, order))["status"] == "delivered"
    assert order not in house.outbox._reminders


async def test_an_order_that_ended_while_everybody_was_away_ends_after_a_restart(url: str) -> None:
    async with gateway(url) as house:
        order = (await house.place(items=LINES))["id"]
        house.bus.tell(STRATEGIST, "gateway", OrderTaken(order))
        await house.say(begun(order))
    async with gateway(url, incarnation=2) as house:
        [asked] = house.bus.sent_to(STRATEGIST, OrderReleased)
        assert (await told(house, asked.order, asked.release))["status"] == "delivered"
    async with gateway(url, incarnation=3) as house:
        assert house.bus.sent_to(STRATEGIST, OrderReleased) == []
        assert house.projection.factory(NOW_S).orders_delivered == 1
