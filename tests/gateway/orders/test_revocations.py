"""Taking production back: asked for until it is confirmed, and published again with what is outstanding."""

from __future__ import annotations

from typing import Any

import pytest
from answers import problem
from gateway_kit import OTHER_PRODUCT, PRODUCT, House, gateway
from heartbeats import events

from dray.messages import OrderReleased, OrderRevoked, OrderTaken, RevocationTaken
from dray.messages.fact import GoalContracted, GoalWithdrawn, GoodsDelivered, OrderAccepted, PieceMade
from dray.messages.keys import STRATEGIST
from dray.store.orders.orders import Orders

pytestmark = pytest.mark.anyio

LINES = [{"product": PRODUCT, "quantity": 5}, {"product": OTHER_PRODUCT, "quantity": 2}]


async def post(house: House, order: str, what: str) -> dict[str, Any]:
    response = await house.client.post(f"/api/orders/{order}/{what}")
    assert response.status_code == 200, response.text
    answer: dict[str, Any] = response.json()
    return answer


async def confirmed(house: House, order: str, release: int, *outstanding: int) -> dict[str, Any]:
    """The strategist confirms, and the gateway has written it down."""
    house.bus.tell(STRATEGIST, "gateway", RevocationTaken(order, release, outstanding))
    await house.completions.written()
    answer: dict[str, Any] = await house.get(f"/api/orders/{order}")
    return answer


def begun(order: str) -> list[Any]:
    """M1 has made three pieces of the first line, and two have arrived."""
    told = events(
        STRATEGIST,
        OrderAccepted(order=order, goals=("G1",)),
        GoalContracted(
            goal="G1", order=order, item=0, product=PRODUCT, quantity=5, machine="M1", finish_s=9.0
        ),
    )
    arrived = GoodsDelivered(goal="G1", order=order, item=0, product=PRODUCT, quantity=2, delivered=2)
    return [*told, *events("M1", PieceMade(goal="G1", product=PRODUCT, made=3), arrived)]


async def test_an_order_is_stored_again_when_the_strategist_has_confirmed_and_not_before(
    house: House,
) -> None:
    order = (await house.place(items=LINES))["id"]
    for _ in range(2):
        asked = await post(house, order, "revoke")
        assert (asked["status"], asked["revoked_at_s"]) == ("released", house.wall.now_s)
    assert house.bus.sent_to(STRATEGIST, OrderRevoked) == [OrderRevoked(order, 1)]
    stored = await confirmed(house, order, 1, 5, 2)
    assert (stored["status"], stored["releases"]) == ("stored", 1)
    assert [view.status for view in house.projection.orders.views()] == ["stored"]
    assert (await post(house, order, "revoke"))["status"] == "stored"


async def test_what_arrived_stays_delivered_and_only_the_rest_is_published_again(house: House) -> None:
    order = (await house.place(items=LINES))["id"]
    await house.say(begun(order))
    await post(house, order, "revoke")
    stored = await confirmed(house, order, 1, 2, 2)
    # The gate has counted one piece more than anybody else has told of yet.
    assert [item["delivered"] for item in stored["items"]] == [3, 0]
    again = await post(house, order, "release")
    assert (again["status"], again["releases"], again["revoked_at_s"]) == ("released", 2, None)
    sent = house.bus.sent_to(STRATEGIST, OrderReleased)[-1]
    assert (sent.release, [item.quantity for item in sent.items]) == (2, [2, 2])


async def test_pieces_that_were_made_and_had_not_arrived_count_no_more(house: House) -> None:
    order = (await house.place(items=LINES))["id"]
    await house.say(begun(order))
    await post(house, order, "revoke")
    stored = await confirmed(house, order, 1, 3, 2)
    await house.say(events(STRATEGIST, GoalWithdrawn("G1", "M1", arrived=2), first=3))
    for shown in (stored, await house.get(f"/api/orders/{order}")):
        assert [item["delivered"] for item in shown["items"]] == [2, 0]
    assert [item["made"] for item in (await house.get(f"/api/orders/{order}"))["items"]] == [2, 0]
    [view] = house.projection.orders.views()
    assert [item.made for item in view.items] == [2, 0]


async def test_an_order_is_not_published_again_before_the_factory_has_stopped(house: House) -> None:
    order = (await house.place())["id"]
    await post(house, order, "revoke")
    answer = await house.client.post(f"/api/orders/{order}/release")
    problem(answer, 409, "being-taken-back")
    assert answer.headers["retry-after"] == "1"
    # A release is said again until it is answered.
    assert {said.release for said in house.bus.sent_to(STRATEGIST, OrderReleased)} == {1}


@pytest.mark.parametrize("end", ["cancel", "deliver"])
async def test_an_order_that_has_ended_is_not_taken_back(house: House, end: str) -> None:
    order = (await house.place())["id"]
    if end == "cancel":
        await post(house, order, "cancel")
    else:
        arrived = GoodsDelivered(goal="G1", order=order, item=0, product=PRODUCT, quantity=5, delivered=5)
        await house.say(events("M1", arrived))
    problem(await house.client.post(f"/api/orders/{order}/revoke"), 409, "order-ended")
    assert house.bus.sent_to(STRATEGIST, OrderRevoked) == []


async def test_an_order_that_was_delivered_before_it_could_be_taken_back_is_delivered(house: House) -> None:
    order = (await house.place())["id"]
    await post(house, order, "revoke")
    told = await confirmed(house, order, 1, 0)
    assert (told["status"], told["revoked_at_s"]) == ("delivered", None)
    [view] = house.projection.orders.views()
    assert (view.status, view.items[0].delivered) == ("delivered", 5)


async def test_only_the_strategists_word_about_the_last_release_counts(house: House) -> None:
    order = (await house.place())["id"]
    await post(house, order, "revoke")
    house.bus.tell("ATV1", "gateway", RevocationTaken(order, 1, (5,)))
    house.bus.tell(STRATEGIST, "gateway", RevocationTaken(order, 2, (5,)))
    await house.completions.written()
    assert house.outbox.awaits(RevocationTaken(order, 1, ()))
    await confirmed(house, order, 1, 5)
    await post(house, order, "release")
    house.bus.tell(STRATEGIST, "gateway", OrderTaken(order=order, release=1))
    assert order in house.outbox._reminders
    house.bus.tell(STRATEGIST, "gateway", OrderTaken(order=order, release=2))
    assert order not in house.outbox._reminders


async def test_an_order_that_is_being_taken_back_goes_on_being_so_after_a_restart(url: str) -> None:
    async with gateway(url) as house:
        order = (await house.place())["id"]
        await post(house, order, "revoke")
    async with gateway(url, incarnation=2) as house:
        assert house.bus.sent_to(STRATEGIST, OrderRevoked) == [OrderRevoked(order, 1)]
        assert house.bus.sent_to(STRATEGIST, OrderReleased) == []
        assert (await confirmed(house, order, 1))["status"] == "stored"
    async with gateway(url, incarnation=3) as house:
        assert house.bus.sent_to(STRATEGIST, OrderRevoked) == []


async def test_an_order_that_is_being_taken_back_may_be_cancelled(house: House) -> None:
    order = (await house.place())["id"]
    await post(house, order, "revoke")
    assert (await post(house, order, "cancel"))["status"] == "cancelled"
    house.bus.tell(STRATEGIST, "gateway", RevocationTaken(order, 1, (5,)))
    assert (await house.get(f"/api/orders/{order}"))["status"] == "cancelled"


async def test_an_answer_that_cannot_be_written_is_asked_for_again(
    house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def fail(_orders: Orders, *_answer: Any) -> None:
        raise ConnectionRefusedError

    order = (await house.place())["id"]
    await post(house, order, "revoke")
    with monkeypatch.context() as patch:
        patch.setattr(Orders, "store", fail)
        assert (await confirmed(house, order, 1, 5))["status"] == "released"
    assert house.outbox.awaits(RevocationTaken(order, 1, ()))
    assert (await confirmed(house, order, 1, 5))["status"] == "stored"
