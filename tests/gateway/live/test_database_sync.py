"""What people decide at one gateway is seen at the others, which read it from the database that they share."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import AsyncIterator, Iterable
from contextlib import asynccontextmanager
from itertools import count
from typing import Any

import pytest
from fake_bus import FakeBus
from gateway_kit import PRODUCT, House, gateway
from heartbeats import events, machine_heartbeat
from wall_clock import NOW_S, Wall

from dray.gateway.factory.figure_sampler import Sampler
from dray.gateway.live import database_sync
from dray.gateway.live.database_sync import DatabaseSync
from dray.gateway.live.projection.orders import Orders as ShownOrders
from dray.gateway.live.views import OrderView
from dray.messages import (
    CancellationTaken,
    Event,
    MachineStatus,
    Message,
    OrderCancelled,
    OrderReleased,
    OrderRevoked,
    OrderTaken,
    RevocationTaken,
)
from dray.messages.fact import CommandObeyed, GoalContracted, GoodsDelivered
from dray.messages.keys import STRATEGIST
from dray.store.orders.orders import Mark, Order, Orders
from dray.store.orders.progress import Goal

pytestmark = pytest.mark.anyio


@asynccontextmanager
async def two_gateways(url: str) -> AsyncIterator[tuple[House, House]]:
    """Two gateways on one bus and one database, whose clocks agree."""
    bus, wall = FakeBus(), Wall()
    async with (
        gateway(url, bus=bus, wall=wall, gateway_name="gateway-1") as first,
        gateway(url, bus=bus, wall=wall, gateway_name="gateway-2") as second,
    ):
        yield first, second


def sync_of(house: House) -> DatabaseSync:
    """Another one, called by the test, that has seen nothing yet."""
    return DatabaseSync(house.store, house.projection, house.outbox.follow)


def shown(house: House) -> dict[str, OrderView]:
    return {view.id: view for view in house.projection.orders.views()}


def answer(house: House, name: str, message: Message) -> None:
    house.bus.tell(STRATEGIST, name, message)


async def test_an_order_placed_at_one_gateway_is_followed_at_the_other_from_place_to_cancellation(
    url: str,
) -> None:
    async with two_gateways(url) as (first, second):
        looks = sync_of(second)
        stored = (await first.place(release=False))["id"]
        assert shown(second) == {}
        await looks.look()
        assert shown(second)[stored].status == "stored"
        assert second.projection.factory(NOW_S).orders_open == 1

        for act, seen in (
            ("release", ("released", 1, None)),
            ("revoke", ("released", 1, NOW_S)),
            ("cancel", ("cancelled", 1, NOW_S)),
        ):
            assert (await first.client.post(f"/api/orders/{stored}/{act}")).status_code == 200
            await looks.look()
            view = shown(second)[stored]
            assert (view.status, view.releases, view.revoked_at_s) == seen
            assert view == shown(first)[stored]
        assert second.projection.factory(NOW_S).orders_open == 0
        # Each speaks to the strategist about what was decided at it.
        assert {sender for sender, to, _ in second.bus.sent if to == STRATEGIST} == {"gateway-1"}


async def test_an_order_that_the_strategist_has_given_back_is_stored_at_both(url: str) -> None:
    async with two_gateways(url) as (first, second):
        looks = sync_of(second)
        order = (await first.place())["id"]
        await looks.look()
        await first.client.post(f"/api/orders/{order}/revoke")
        answer(first, "gateway-1", RevocationTaken(order, 1, (5,)))
        await first.completions.written()
        await looks.look()
        assert shown(second)[order].status == "stored"


def facts(order: str, arrived: int) -> list[Event]:
    contracted = GoalContracted(
        goal="G1", order=order, item=0, product=PRODUCT, quantity=5, machine="M1", finish_s=9.0
    )
    delivered = GoodsDelivered(goal="G1", order=order, item=0, product=PRODUCT, quantity=5, delivered=arrived)
    return events(STRATEGIST, contracted, delivered)


async def test_an_order_that_ended_in_sql_ends_at_a_gateway_that_missed_the_same_facts(url: str) -> None:
    async with two_gateways(url) as (first, second):
        looks = sync_of(second)
        order = (await first.place())["id"]
        await looks.look()
        await first.say(facts(order, 2))
        await looks.look()
        answer(first, "gateway-1", OrderTaken(order, fulfilled=True))
        await first.completions.written()
        await looks.look()
        assert shown(second)[order] == shown(first)[order]
        assert shown(second)[order].status == "delivered"
        for house in (first, second):
            assert house.projection.factory(NOW_S).orders_delivered == 1


async def test_facts_that_a_gateway_heard_before_it_knew_of_their_order_are_read(url: str) -> None:
    async with two_gateways(url) as (first, second):
        looks = sync_of(second)
        order = (await first.place())["id"]
        await first.say(facts(order, 2))
        await second.historian.written()
        assert shown(second) == {}
        await looks.look()
        [item] = shown(second)[order].items
        assert (shown(second)[order].status, item.delivered) == ("in_delivery", 2)
        # And what comes now is added to that.
        first.bus.say(*facts(order, 5)[1:])
        assert shown(second)[order].status == "delivered"


async def test_what_is_repeated_about_an_order_changes_with_what_was_decided_elsewhere(url: str) -> None:
    async with two_gateways(url) as (first, second):
        looks, order = sync_of(second), (await first.place())["id"]
        await looks.look()

        async def repeated() -> Message | None:
            await looks.look()
            return second.outbox._reminders.get(order)

        async with second.store.read() as work:
            second.outbox.ask(await work.orders.open())
        released = await repeated()
        assert isinstance(released, OrderReleased)
        assert await repeated() is released

        await first.client.post(f"/api/orders/{order}/revoke")
        assert isinstance(await repeated(), OrderRevoked)

        answer(first, "gateway-1", RevocationTaken(order, 1, (5,)))
        await first.completions.written()
        assert await repeated() is None

        await second.client.post(f"/api/orders/{order}/release")
        await first.client.post(f"/api/orders/{order}/cancel")
        assert isinstance(await repeated(), OrderCancelled)
        answer(second, "gateway-2", CancellationTaken(order))
        assert await repeated() is None


async def test_what_is_heard_while_the_database_answers_is_not_taken_back(
    url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with two_gateways(url) as (first, second):
        looks, order = sync_of(second), (await second.place(release=False))["id"]
        many = Orders.many

        async def slow(orders: Orders, ids: Any) -> Any:
            found = await many(orders, ids)
            # A person is quicker at this gateway than the answer of its own database.
            assert (await second.client.post(f"/api/orders/{order}/release")).status_code == 200
            return found

        with monkeypatch.context() as patch:
            patch.setattr(Orders, "many", slow)
            await looks.look()
        assert shown(second)[order].status == "released"
        assert isinstance(second.outbox._reminders.get(order), OrderReleased)
        await sync_of(first).look()
        await looks.look()
        assert shown(first)[order] == shown(second)[order]


async def test_who_takes_an_alert_on_at_one_gateway_is_named_at_the_other(url: str) -> None:
    async with two_gateways(url) as (first, second):
        first.bus.say(machine_heartbeat("M8", status=MachineStatus.ERROR))
        for house in (first, second):
            await house.alerts.look()
        await first.alerts.acknowledge("machine_error-M8", "Day shift")
        await sync_of(second).look()
        [alert] = second.projection.alerts.views()
        assert (alert.acknowledged_by, alert.acknowledged_at_s) == ("Day shift", NOW_S)


async def test_who_was_first_to_take_an_alert_on_stays_though_the_other_gateway_has_not_looked(
    url: str,
) -> None:
    async with two_gateways(url) as (first, second):
        first.bus.say(machine_heartbeat("M8", status=MachineStatus.ERROR))
        for house in (first, second):
            await house.alerts.look()
        for house, name in ((first, "Day shift"), (second, "Night shift")):
            taken = await house.alerts.acknowledge("machine_error-M8", name)
            assert taken is not None
            assert taken.acknowledged_by == "Day shift"


async def test_an_alert_that_came_again_keeps_the_name_that_another_gateway_was_given(url: str) -> None:
    async with two_gateways(url) as (first, second):

        def break_down(seq: int, status: MachineStatus) -> None:
            at_s = first.wall.now_s - NOW_S
            first.bus.say(machine_heartbeat("M8", seq, at_s=at_s, status=status))

        break_down(1, MachineStatus.ERROR)
        for house in (first, second):
            await house.alerts.look()
        await first.alerts.acknowledge("machine_error-M8", "Day shift")
        await sync_of(second).look()
        first.wall.now_s += 60.0
        break_down(2, MachineStatus.IDLE)
        await first.alerts.look()
        ended_s = first.wall.now_s
        second.projection.look(ended_s)
        break_down(3, MachineStatus.ERROR)
        first.wall.now_s += 2.0
        for house in (first, second):
            await house.alerts.look()
        await first.alerts.acknowledge("machine_error-M8", "Night shift")
        # The second one has still to forget what has ended.
        async with second.store.write() as work:
            await work.alerts.end("machine_error-M8", ended_s, ended_s)
        async with second.store.read() as work:
            [kept] = await work.alerts.lasting()
        assert (kept.alert, kept.since_at_s) == ("machine_error-M8", first.wall.now_s)
        assert (kept.by, kept.at_s) == ("Night shift", first.wall.now_s)


async def test_of_a_minute_that_two_gateways_have_seen_one_sample_is_kept(url: str) -> None:
    async with two_gateways(url) as (first, second):
        samplers = [Sampler(house.projection, house.store, house.wall) for house in (first, second)]
        first.bus.say(*events("ATV1", CommandObeyed(command="c", what="stop", done=True)))
        first.bus.say(machine_heartbeat("M1"))
        for minute in (1, 2):
            first.wall.now_s = NOW_S + 60.0 * minute
            for sampler in samplers:
                await sampler.sample()
                first.wall.now_s += 0.01
        async with first.store.read() as work:
            kept = await work.kpis.between(0.0, 2 * NOW_S)
        assert [(sample.at_s, sample.commands) for sample in kept] == [(NOW_S + 60.0, 1), (NOW_S + 120.0, 0)]


async def test_a_running_gateway_looks_by_itself_also_after_its_database_was_away(
    url: str, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(database_sync, "LOOK_EVERY_S", 0.0)
    marks, calls, seen = Orders.marks, count(), asyncio.Event()

    async def fail_first(orders: Orders, since_s: float | None = None) -> dict[str, Mark]:
        if next(calls) == 0:
            raise ConnectionRefusedError
        return await marks(orders, since_s)

    def note(self: ShownOrders, order: Order, goals: Iterable[Goal] = ()) -> None:
        put(self, order, goals)
        seen.set()

    put = ShownOrders.put
    monkeypatch.setattr(Orders, "marks", fail_first)
    with caplog.at_level(logging.INFO, database_sync.__name__):
        async with two_gateways(url) as (first, second):
            order = await first.place()
            monkeypatch.setattr(ShownOrders, "put", note)
            while order["id"] not in shown(second):
                seen.clear()
                await seen.wait()
    assert [record.levelno for record in caplog.records if record.name == database_sync.__name__] == [
        logging.INFO
    ]


async def test_a_look_reads_what_has_changed_lately_and_not_all_that_is_open(
    url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with two_gateways(url) as (first, second):
        for _ in range(5):
            await first.place()
            first.wall.now_s += 60
        look = DatabaseSync(second.store, second.projection, second.outbox.follow)
        await look.restore()
        marks, read, here = Orders.marks, [], asyncio.current_task()

        async def noted(orders: Orders, since_s: float | None = None) -> dict[str, Mark]:
            found = await marks(orders, since_s)
            # The two gateways look by themselves, too.
            if asyncio.current_task() is here:
                read.append(len(found))
            return found

        monkeypatch.setattr(Orders, "marks", noted)
        await look.look()
        newest = await first.place()
        await look.look()
        monkeypatch.setattr(database_sync, "WHOLE_EVERY", 1)
        await look.look()
    assert read[:2] == [1, 2]
    assert read[2] == 6
    assert newest["id"] in shown(second)
