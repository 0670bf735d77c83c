"""Reconciliation: open orders are asked for at the start and from time to time, whatever was answered before."""

from __future__ import annotations

import asyncio
import logging
from typing import Any

import pytest
from fake_bus import FakeBus
from gateway_kit import PRODUCT, House, gateway
from heartbeats import events
from wall_clock import Wall

from dray.gateway.orders import reconciliation
from dray.gateway.orders.reconciliation import CANCELLED_AGAIN_S, RECONCILE_EVERY_S, Reconciliation
from dray.messages import Message, OrderCancelled, OrderReleased, OrderRevoked, OrderTaken
from dray.messages.fact import GoodsDelivered, MemoryLost
from dray.messages.keys import STRATEGIST
from dray.store.orders.orders import Orders
from dray_sim.clock.loop import run

pytestmark = pytest.mark.anyio


@pytest.fixture
def reconciling(house: House) -> Reconciliation:
    """Another one, called by the test."""
    return Reconciliation(house.store, house.outbox, house.wall)


def said(house: House) -> list[Message]:
    return [message for _, to, message in house.bus.sent if to == STRATEGIST]


async def taken(house: House) -> str:
    """The id of a new order that the strategist has taken."""
    order: str = (await house.place())["id"]
    house.bus.tell(STRATEGIST, "gateway", OrderTaken(order))
    return order


def test_a_gateway_reconciles_every_ten_minutes() -> None:
    times_s: list[float] = []

    class Watched(Reconciliation):
        async def reconcile(self) -> None:
            times_s.append(asyncio.get_running_loop().time())

    async def main() -> None:
        nobody: Any = None
        running = asyncio.create_task(Watched(nobody, nobody, Wall()).run())
        await asyncio.sleep(3.5 * RECONCILE_EVERY_S)
        running.cancel()

    run(main())
    assert times_s == pytest.approx([600.0, 1200.0, 1800.0])


async def test_orders_that_are_still_open_are_asked_for_again(
    house: House, reconciling: Reconciliation
) -> None:
    first, revoked, ended, cancelled = [await taken(house) for _ in range(4)]
    waiting = (await house.place())["id"]
    await house.place(release=False)
    async with house.store.write() as work:
        # As another gateway does it.
        await work.orders.revoke(revoked, house.wall.now_s)
    arrived = GoodsDelivered(goal="G1", order=ended, item=0, product=PRODUCT, quantity=5, delivered=5)
    await house.say(events("M1", arrived))
    assert (await house.client.post(f"/api/orders/{cancelled}/cancel")).status_code == 200
    before = said(house)
    await reconciling.reconcile()
    asked = said(house)[len(before) :]
    assert {(type(message), getattr(message, "order", "")) for message in asked} == {
        (OrderReleased, first),
        (OrderRevoked, revoked),
    }
    # The same as was said when it was released.
    assert [message for message in asked if isinstance(message, OrderReleased)] == before[:1]
    assert waiting in house.outbox._reminders


async def test_a_running_gateway_reconciles_and_ends_what_is_fulfilled(
    url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(reconciliation, "RECONCILE_EVERY_S", 0.0)
    async with gateway(url) as house:
        order = await taken(house)
        await house.bus.next_to(
            STRATEGIST, OrderReleased, after=len(house.bus.sent_to(STRATEGIST, OrderReleased))
        )
        house.bus.tell(STRATEGIST, "gateway", OrderTaken(order, fulfilled=True))
        await house.completions.written()
        assert (await house.get(f"/api/orders/{order}"))["status"] == "delivered"


async def test_all_open_orders_are_asked_for_at_once_when_a_strategist_has_lost_its_memory_and_for_no_other_agent(
    house: House,
) -> None:
    order = await taken(house)
    before = len(house.bus.sent_to(STRATEGIST, OrderReleased))
    for agent in ("M1", STRATEGIST):
        house.bus.say(*events(agent, MemoryLost(reason="a damaged journal")))
    asked = await house.bus.next_to(STRATEGIST, OrderReleased, after=before)
    assert asked.order == order
    assert len(house.bus.sent_to(STRATEGIST, OrderReleased)) == before + 1


async def test_two_gateways_may_ask_for_the_same_order(url: str) -> None:
    bus = FakeBus()
    async with (
        gateway(url, bus=bus, gateway_name="gateway-1") as first,
        gateway(url, bus=bus, gateway_name="gateway-2") as second,
    ):
        order = (await first.place())["id"]
        await Reconciliation(second.store, second.outbox, second.wall).reconcile()
        for house, name in ((first, "gateway-1"), (second, "gateway-2")):
            bus.tell(STRATEGIST, name, OrderTaken(order, fulfilled=True))
            await house.completions.written()
            assert order not in house.outbox._reminders
        assert (await second.get(f"/api/orders/{order}"))["status"] == "delivered"


async def test_without_a_database_a_gateway_reconciles_the_next_time(
    house: House,
    reconciling: Reconciliation,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:
    async def fail(_orders: Orders) -> None:
        raise ConnectionRefusedError

    order = await taken(house)
    with monkeypatch.context() as patch, caplog.at_level(logging.INFO):
        patch.setattr(Orders, "open", fail)
        await reconciling.reconcile()
    assert [record.levelno for record in caplog.records if record.name == reconciliation.__name__] == [
        logging.INFO
    ]
    assert order not in house.outbox._reminders
    await reconciling.reconcile()
    assert order in house.outbox._reminders


async def test_a_cancellation_that_may_not_have_been_heard_is_said_again_after_a_restart(url: str) -> None:
    wall = Wall()
    async with gateway(url, wall=wall) as house:
        name = (await house.place())["id"]
        never_released = (await house.place(release=False))["id"]
        for order_id in (name, never_released):
            assert (await house.client.post(f"/api/orders/{order_id}/cancel")).status_code == 200
    wall.now_s += CANCELLED_AGAIN_S / 2
    async with gateway(url, wall=wall, incarnation=2) as house:
        said = house.bus.sent_to(STRATEGIST, OrderCancelled)
        assert [message.order for message in said] == [name]
        assert house.bus.sent_to(STRATEGIST, OrderReleased) == []
    wall.now_s += CANCELLED_AGAIN_S
    async with gateway(url, wall=wall, incarnation=3) as house:
        assert house.bus.sent_to(STRATEGIST, OrderCancelled) == []
