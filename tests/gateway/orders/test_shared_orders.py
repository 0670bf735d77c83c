"""Orders of a plant with several strategists: all are told, whoever holds one answers, and what all of them tell of it counts."""

from __future__ import annotations

import pytest
from gateway_kit import PRODUCT, gateway
from heartbeats import events

from dray.gateway.orders.reconciliation import Reconciliation
from dray.messages import OrderReleased, OrderTaken
from dray.messages.fact import (
    GoalContracted,
    GoalLost,
    GoodsDelivered,
    OrderAccepted,
    OrderFulfilled,
    OrderTakenOver,
)
from dray.messages.keys import strategists_of

pytestmark = pytest.mark.anyio


def made_by(goal: str, order: str, quantity: int, held: int) -> GoalContracted:
    return GoalContracted(goal, order, 0, PRODUCT, quantity, "M1", finish_s=900.0, held=held)


async def test_of_several_strategists_all_are_told_and_whoever_holds_the_order_answers(url: str) -> None:
    async with gateway(url, strategists=2) as house:
        first, second = (await house.place())["id"], (await house.place())["id"]
        for each in strategists_of(2):
            assert [said.order for said in house.bus.sent_to(each, OrderReleased)] == [first, second]
        assert house.bus.sent_to("strategist3", OrderReleased) == []
        house.bus.tell("strategist2", "gateway", OrderTaken(order=first))
        house.bus.tell("strategist", "gateway", OrderTaken(order=second, fulfilled=True))
        await house.completions.written()
        assert first not in house.outbox._reminders
        assert second not in house.outbox._reminders
        assert (await house.get(f"/api/orders/{second}"))["status"] == "delivered"


async def test_an_order_that_goes_from_one_strategist_to_the_other_is_delivered_by_the_facts_of_both(
    url: str,
) -> None:
    async with gateway(url, strategists=2) as house:
        name = (await house.place())["id"]
        await house.say(
            events(
                "strategist",
                OrderAccepted(name, ("G1",), held=1),
                made_by("G1", name, 5, held=1),
                GoodsDelivered("G1", name, 0, PRODUCT, 2, delivered=2),
                life=7,
            )
        )
        await house.say(
            events(
                "strategist2",
                OrderTakenOver(name, 2, ("G1",)),
                GoalLost("G1", "M1", arrived=2, successor="G2", held=2),
                made_by("G2", name, 3, held=2),
            )
        )
        assert (await house.get(f"/api/orders/{name}"))["status"] == "in_delivery"
        await house.say(
            events("strategist2", GoodsDelivered("G2", name, 0, PRODUCT, 3, delivered=3), first=4)
        )
        assert (await house.get(f"/api/orders/{name}"))["status"] == "delivered"
        assert house.projection.orders.get(name).status == "delivered"


async def test_an_order_whose_last_pieces_nobody_has_told_of_is_asked_for_when_it_is_said_to_have_ended(
    url: str,
) -> None:
    """They arrived while nobody held the order, and the gate told its next holder."""
    async with gateway(url, strategists=2) as house:
        name = (await house.place())["id"]
        house.bus.tell("strategist", "gateway", OrderTaken(order=name))
        await house.say(
            events("strategist", OrderAccepted(name, ("G1",), held=1), made_by("G1", name, 5, held=1))
        )
        before = len(house.bus.sent_to("strategist2", OrderReleased))
        await house.say(events("strategist2", OrderTakenOver(name, 2, ()), OrderFulfilled(name)))
        await house.bus.next_to("strategist2", OrderReleased, after=before)
        house.bus.tell("strategist2", "gateway", OrderTaken(order=name, fulfilled=True))
        await house.completions.written()
        assert (await house.get(f"/api/orders/{name}"))["status"] == "delivered"


async def test_an_order_of_which_all_pieces_are_told_is_not_asked_for_at_its_end(
    url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    doubted: list[str] = []
    monkeypatch.setattr(Reconciliation, "doubt", lambda _self, order: doubted.append(order))
    async with gateway(url) as house:
        name = (await house.place())["id"]
        house.bus.tell("strategist", "gateway", OrderTaken(order=name))
        told = (made_by("G1", name, 5, held=0), GoodsDelivered("G1", name, 0, PRODUCT, 5, delivered=5))
        await house.say(events("strategist", OrderAccepted(name, ("G1",)), *told, OrderFulfilled(name)))
        assert (await house.get(f"/api/orders/{name}"))["status"] == "delivered"
        assert doubted == []
