"""Changing an order: what is still possible, said until it is confirmed, and what it becomes with that."""

from __future__ import annotations

from typing import Any

import httpx
import pytest
from answers import problem
from gateway_kit import OTHER_PRODUCT, PRODUCT, House, gateway
from heartbeats import events

from dray.messages import OrderReleased, OrderTaken
from dray.messages.base import COUNT_MAX
from dray.messages.fact import GoalContracted, GoodsDelivered, OrderAccepted, PieceMade
from dray.messages.keys import STRATEGIST

pytestmark = pytest.mark.anyio

LINES = [{"product": PRODUCT, "quantity": 5}, {"product": OTHER_PRODUCT, "quantity": 2}]


async def change(house: House, order: str, etag: str | None = "*", **body: Any) -> httpx.Response:
    headers = {} if etag is None else {"If-Match": etag}
    return await house.client.patch(f"/api/orders/{order}", json=body, headers=headers)


async def confirmed(house: House, order: str, number: int, *quantities: int, **more: Any) -> dict[str, Any]:
    """The strategist confirms, and the gateway has written it down."""
    taken = OrderTaken(order, 1, change=number, quantities=quantities, **more)
    house.bus.tell(STRATEGIST, "gateway", taken)
    await house.completions.written()
    answer: dict[str, Any] = await house.get(f"/api/orders/{order}")
    return answer


def begun(order: str, made: int = 3, delivered: int = 2) -> list[Any]:
    """M1 has made some pieces of the first line, and some have arrived."""
    told = events(
        STRATEGIST,
        OrderAccepted(order=order, goals=("G1",)),
        GoalContracted(
            goal="G1", order=order, item=0, product=PRODUCT, quantity=5, machine="M1", finish_s=9.0
        ),
    )
    arrived = GoodsDelivered(
        goal="G1", order=order, item=0, product=PRODUCT, quantity=delivered, delivered=delivered
    )
    return [*told, *events("M1", PieceMade(goal="G1", product=PRODUCT, made=made), arrived)]


async def test_less_is_wanted_until_the_strategist_has_said_what_machines_keep(house: House) -> None:
    order = (await house.place(items=LINES))["id"]
    answer = (await change(house, order, quantities=[3, 2])).json()
    assert [(item["quantity"], item["wanted"]) for item in answer["items"]] == [(5, 3), (2, None)]
    assert answer["changing"] is True
    said = house.bus.sent_to(STRATEGIST, OrderReleased)[-1]
    assert (said.change, [item.quantity for item in said.items]) == (1, [3, 2])
    after = await confirmed(house, order, 1, 4, 2)
    assert [(item["quantity"], item["wanted"]) for item in after["items"]] == [(4, None), (2, None)]
    assert after["changing"] is False


async def test_a_change_that_nobody_has_made_answers_no_change(house: House) -> None:
    """A thief of a gateway's certificate has told it to the strategist, which believes the gateway when it is told often enough."""
    order = (await house.place(items=LINES))["id"]
    await change(house, order, quantities=[3, 2])
    after = await confirmed(house, order, COUNT_MAX, 90, 2)
    assert [(item["quantity"], item["wanted"]) for item in after["items"]] == [(5, 3), (2, None)]
    assert order in house.outbox._reminders
    await confirmed(house, order, 1, 3, 2)
    assert order not in house.outbox._reminders


async def test_an_order_is_delivered_when_what_it_was_reduced_to_has_arrived_already(house: House) -> None:
    order = (await house.place(items=LINES[:1]))["id"]
    await house.say(begun(order, made=3, delivered=3))
    await change(house, order, quantities=[3])
    after = await confirmed(house, order, 1, 3)
    assert (after["status"], after["items"][0]["delivered"]) == ("delivered", 3)


async def test_more_is_ordered_at_once_and_is_taken_back_where_it_came_too_late(house: House) -> None:
    order = (await house.place(items=LINES[:1]))["id"]
    await change(house, order, quantities=[8])
    await house.say(begun(order, made=5, delivered=5))
    assert (await house.get(f"/api/orders/{order}"))["status"] == "in_delivery"
    after = await confirmed(house, order, 0, 5, fulfilled=True)
    assert (after["status"], after["items"][0]["quantity"], after["changing"]) == ("delivered", 5, False)


async def test_less_than_is_made_is_too_late_and_the_answer_says_what_is_possible(house: House) -> None:
    order = (await house.place(items=LINES))["id"]
    await house.say(begun(order, made=3))
    refused = problem(await change(house, order, quantities=[2, 2]), 409, "too-late")
    [error] = refused["errors"]
    assert error["field"] == "quantities[0]"
    assert "at least 3" in error["reason"]


async def test_a_change_names_the_state_that_was_read_and_may_be_sent_again(house: House) -> None:
    placed = await house.place(items=LINES)
    order, etag = placed["id"], placed["etag"]
    assert problem(await change(house, order, None, priority="urgent"), 428, "no-version")
    first = await change(house, order, etag, priority="urgent")
    assert first.headers["etag"] == first.json()["etag"] != etag
    assert (await change(house, order, etag, priority="urgent")).json()["priority"] == "urgent"
    assert problem(await change(house, order, etag, priority="low"), 412, "changed-since")
    assert len(house.bus.sent_to(STRATEGIST, OrderReleased)) >= 2
    # The factory takes it as it was asked for: nobody's reading is out of date by that.
    after = await confirmed(house, order, 1, 5, 2)
    assert after["etag"] == first.json()["etag"]
    assert (await change(house, order, first.headers["etag"], priority="low")).status_code == 200


async def test_how_far_an_order_is_is_news_to_who_asks_again_and_no_other_version(house: House) -> None:
    placed = await house.place(items=LINES)
    order, etag = placed["id"], placed["etag"]
    read = await house.client.get(f"/api/orders/{order}")
    again = {"If-None-Match": read.headers["etag"]}
    assert (await house.client.get(f"/api/orders/{order}", headers=again)).status_code == 304
    await house.say(begun(order, made=3))
    news = await house.client.get(f"/api/orders/{order}", headers=again)
    assert (news.status_code, news.json()["items"][0]["made"], news.json()["etag"]) == (200, 3, etag)
    # What was read before that may be changed all the same.
    assert (await change(house, order, read.headers["etag"], priority="low")).status_code == 200


@pytest.mark.parametrize("given", ["{version}", "W/{version}", '"other", {version}', "{read}", "W/{read}"])
async def test_a_change_names_the_version_alone_or_with_what_was_read(house: House, given: str) -> None:
    placed = await house.place(items=LINES)
    read = (await house.client.get(f"/api/orders/{placed['id']}")).headers["etag"]
    tag = given.format(version=placed["etag"], read=read)
    assert (await change(house, placed["id"], tag, priority="low")).status_code == 200
    assert problem(await change(house, placed["id"], tag, priority="high"), 412, "changed-since")


async def test_an_order_goes_before_another_one_and_its_agents_are_told_another_time(house: House) -> None:
    first, second, third = [(await house.place(due_at=f"2030-03-1{day}T12:00:00Z")) for day in (8, 9, 9)]
    moved = (await change(house, third["id"], before=second["id"])).json()
    assert first["wanted_at_s"] < moved["wanted_at_s"] < second["wanted_at_s"]
    assert moved["due_at_s"] == third["due_at_s"]
    ahead = (await change(house, third["id"], before=first["id"])).json()
    assert ahead["wanted_at_s"] < first["wanted_at_s"]
    assert problem(await change(house, third["id"], before="O-0"), 422, "unusable-fields")


async def test_a_stored_order_is_changed_without_anybody_in_the_factory(house: House) -> None:
    order = (await house.place(items=LINES, release=False))["id"]
    after = (await change(house, order, quantities=[1, 9], reference="PO-9", priority="low")).json()
    assert ([item["quantity"] for item in after["items"]], after["changing"]) == ([1, 9], False)
    assert (after["reference"], after["priority"]) == ("PO-9", "low")
    assert house.bus.sent_to(STRATEGIST, OrderReleased) == []


async def test_what_has_ended_or_is_being_taken_back_is_not_changed(house: House) -> None:
    order = (await house.place(items=LINES))["id"]
    await change(house, order, priority="high")
    refused = await house.client.post(f"/api/orders/{order}/revoke")
    assert problem(refused, 409, "being-changed")
    await confirmed(house, order, 1, 5, 2)
    await house.client.post(f"/api/orders/{order}/revoke")
    assert problem(await change(house, order, priority="low"), 409, "being-taken-back")
    await house.client.post(f"/api/orders/{order}/cancel")
    assert problem(await change(house, order, priority="low"), 409, "order-ended")


@pytest.mark.parametrize(
    ("body", "field"),
    [
        ({"quantities": [1]}, "quantities"),
        ({"quantities": [0, 1]}, "quantities[0]"),
        ({"due_at": "2001-01-01T00:00:00Z"}, "due_at"),
        ({"priority": None}, "priority"),
        ({"customer": "else"}, "customer"),
    ],
)
async def test_what_means_nothing_is_refused_with_its_field(
    house: House, body: dict[str, Any], field: str
) -> None:
    order = (await house.place(items=LINES))["id"]
    assert problem(await change(house, order, **body), 422, "unusable-fields")["errors"][0]["field"] == field


async def test_a_change_that_was_answered_outlives_the_gateway(url: str) -> None:
    async with gateway(url) as before:
        order = (await before.place(items=LINES))["id"]
        await change(before, order, quantities=[3, 2])
    async with gateway(url) as after:
        said = after.bus.sent_to(STRATEGIST, OrderReleased)[-1]
        assert (said.change, [item.quantity for item in said.items]) == (1, [3, 2])
        assert (await confirmed(after, order, 1, 3, 2))["changing"] is False
