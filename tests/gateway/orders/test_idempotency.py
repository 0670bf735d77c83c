"""An order that is sent again is not a second order."""

from __future__ import annotations

import asyncio
from typing import Any

import httpx
import pytest
from answers import problem
from gateway_kit import PRODUCT, House, draft, gateway
from wall_clock import NOW_S

from dray.gateway.access.principal import Scope
from dray.gateway.orders.idempotency import KEYS_KEPT_S, alone
from dray.gateway.orders.placement import OrderPlacement
from dray.messages import OrderReleased

pytestmark = pytest.mark.anyio

KEY = {"Idempotency-Key": "order-4711"}


async def send(house: House, body: dict[str, Any], headers: dict[str, str] = KEY) -> httpx.Response:
    return await house.client.post("/api/orders", json=body, headers=headers)


async def test_the_same_key_and_body_get_the_same_answer_and_one_order(house: House) -> None:
    first = await send(house, draft())
    again = await send(house, draft())
    assert first.status_code == again.status_code == 201
    assert again.content == first.content
    assert again.headers["location"] == first.headers["location"]
    assert "idempotency-replayed" not in first.headers
    assert again.headers["idempotency-replayed"] == "true"
    assert await house.orders_kept() == 1
    # A release is said again until it is answered.
    assert len({said.order for said in house.bus.sent_to("strategist", OrderReleased)}) == 1


async def test_the_same_order_written_in_another_way_is_the_same_body(house: House) -> None:
    first = await send(house, draft(due_at="2030-03-17T20:00:00Z"))
    turned = dict(reversed(draft(due_at="2030-03-17T21:00:00+01:00").items()))
    assert (await send(house, turned)).content == first.content


async def test_the_answer_stays_the_first_one_whatever_became_of_the_order(house: House) -> None:
    first = await send(house, draft(due_at="2030-03-17T20:00:00Z"))
    await house.client.post(f"{first.headers['location']}/cancel")
    house.wall.now_s += 86_400.0
    again = await send(house, draft(due_at="2030-03-17T20:00:00Z"))
    assert again.status_code == 201
    assert again.content == first.content


async def test_the_same_key_with_another_body_is_refused_and_nothing_stored(house: House) -> None:
    first = await send(house, draft())
    other = draft(items=[{"product": PRODUCT, "quantity": 6}])
    refused = problem(await send(house, other), 422, "key-used")
    assert refused["errors"][0]["field"] == "Idempotency-Key"
    assert refused["detail"] == (
        f"Idempotency-Key: it was used for another request ({first.json()['id']}); "
        "take a new key for each new one"
    )
    assert await house.orders_kept() == 1
    assert (await send(house, draft())).content == first.content


async def test_other_keys_and_no_key_make_other_orders(house: House) -> None:
    headers: tuple[dict[str, str], ...] = (KEY, {"Idempotency-Key": "order-4712"}, {}, {})
    answers = [await send(house, draft(), one) for one in headers]
    assert len({answer.json()["id"] for answer in answers}) == 4


async def test_a_key_at_work_is_refused_until_its_request_is_answered(
    house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun, go_on = asyncio.Event(), asyncio.Event()
    place_once = OrderPlacement.place_once

    async def slowly(placement: OrderPlacement, draft: Any, caller: str, key: str, *rest: Any) -> Any:
        async with alone(placement.keys_at_work, key):
            begun.set()
            await go_on.wait()
        return await place_once(placement, draft, caller, key, *rest)

    with monkeypatch.context() as patch:
        patch.setattr(OrderPlacement, "place_once", slowly)
        first = asyncio.create_task(send(house, draft()))
        await begun.wait()
    refused = await send(house, draft())
    problem(refused, 409, "key-at-work")
    assert refused.headers["retry-after"] == "1"
    go_on.set()
    answered = await first
    assert answered.status_code == 201
    assert (await send(house, draft())).content == answered.content
    assert await house.orders_kept() == 1


async def test_a_refused_body_leaves_its_key_free(house: House) -> None:
    problem(await send(house, draft(due_at="2020-01-01T00:00:00Z")), 422, "unusable-fields")
    assert house.placement.keys_at_work == {}
    assert (await send(house, draft())).status_code == 201


async def test_a_key_is_remembered_over_a_restart(url: str) -> None:
    async with gateway(url) as before:
        first = await send(before, draft())
    async with gateway(url) as after:
        again = await send(after, draft())
        assert again.content == first.content
        problem(await send(after, draft(customer="Other")), 422, "key-used")
        assert await after.orders_kept() == 1


async def test_two_gateways_on_one_database_take_an_order_once(url: str) -> None:
    async with gateway(url) as one, gateway(url) as other:
        first, second = await asyncio.gather(send(one, draft()), send(other, draft()))
        assert first.content == second.content
        assert await one.orders_kept() == 1


async def test_a_key_is_forgotten_after_a_week(house: House) -> None:
    first = await send(house, draft())
    house.wall.now_s = NOW_S + KEYS_KEPT_S + 1
    await send(house, draft(), {"Idempotency-Key": "another"})
    again = await send(house, draft())
    assert again.json()["id"] != first.json()["id"]


@pytest.mark.parametrize("key", ["", " ", "a b", "k" * 256, "\x7f"])
async def test_a_key_that_nobody_could_read_is_refused(house: House, key: str) -> None:
    refused = problem(await send(house, draft(), {"Idempotency-Key": key}), 422, "unusable-fields")
    assert refused["errors"][0]["field"] == "Idempotency-Key"
    assert await house.orders_kept() == 0


async def test_a_key_of_one_caller_is_not_the_key_of_another(house: House) -> None:
    first = await send(house, draft())
    _, erp = await house.key(Scope.ORDERS_WRITE)
    second = await send(house, draft(), KEY | erp)
    assert second.status_code == 201
    assert "idempotency-replayed" not in second.headers
    assert second.json()["id"] != first.json()["id"]
    assert (await send(house, draft(), KEY | erp)).json()["id"] == second.json()["id"]
