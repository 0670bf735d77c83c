"""Orders that recur over REST: every moment of a calendar is one order, as somebody would have placed it, whoever dies meanwhile."""

from __future__ import annotations

import asyncio
from typing import Any

import pytest
from fake_bus import FakeBus
from gateway_kit import OTHER_PRODUCT, PRODUCT, House, gateway
from recurring_kit import BRING, DAY_S, DRAFT, PATH, SIX_S, added, brought, change, look
from wall_clock import Wall

from dray.errors import UnavailableError
from dray.gateway.access.principal import Scope
from dray.gateway.http.provided import provided
from dray.gateway.orders.placement import OrderPlacement
from dray.gateway.schedules.scheduler import PUNCTUAL_S, Scheduler
from dray.messages import OrderReleased
from dray.store.orders.idempotency_keys import IdempotencyKeys

pytestmark = pytest.mark.anyio

ORDER = {
    "customer": "Hall 3",
    "items": [{"product": PRODUCT, "quantity": 20}, {"product": OTHER_PRODUCT, "quantity": 2}],
    "reference": "weekly",
    "priority": "high",
    "due_after_s": 7200,
}


@pytest.fixture(autouse=True)
def asked_by_the_test_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Only the test looks, and nobody besides when a schedule is new."""
    monkeypatch.setattr(Scheduler, "run", lambda _: asyncio.Event().wait())


async def orders(house: House) -> list[dict[str, Any]]:
    items: list[dict[str, Any]] = (await house.get("/api/orders"))["items"]
    return items


def published(house: House) -> set[str]:
    return {said.order for _, _, said in house.bus.sent if isinstance(said, OrderReleased)}


async def test_each_moment_is_one_order(house: House) -> None:
    schedule = await added(house, transport=None, order=ORDER)
    assert (schedule["transport"], schedule["order"]) == (None, ORDER)
    await look(house, SIX_S - 1)
    assert await orders(house) == []
    await look(house, SIX_S)
    await look(house, SIX_S + 1)
    [one] = await orders(house)
    assert {name: one[name] for name in ("customer", "reference", "priority", "status")} == {
        "customer": "Hall 3",
        "reference": "weekly",
        "priority": "high",
        "status": "released",
    }
    assert [(each["product"], each["quantity"]) for each in one["items"]] == [
        (PRODUCT, 20),
        (OTHER_PRODUCT, 2),
    ]
    assert one["due_at_s"] == SIX_S + 7200
    token = one["tracking_url"].rpartition("/")[2]
    assert (await house.client.get(f"/api/track/{token}")).status_code == 200
    assert published(house) == {one["id"]}
    now = await house.get(f"{PATH}/{schedule['id']}")
    assert now["last"] == {
        "planned_at": "2030-03-18T05:00:00.000Z",
        "transport": None,
        "order": one["id"],
        "refused": None,
        "made_up_at": None,
    }
    [line] = await house.audit(action="order.place")
    assert (line.who, line.who_kind, line.target) == (schedule["id"], "schedule", one["id"])
    await look(house, SIX_S + DAY_S)
    assert len(await orders(house)) == 2
    assert await brought(house) == []


async def test_two_gateways_use_a_moment_once(url: str) -> None:
    wall = Wall()
    async with (
        gateway(url, wall=wall) as house,
        gateway(url, wall=wall, bus=FakeBus(), incarnation=2) as other,
    ):
        await added(house, transport=None, order=ORDER)
        wall.now_s = SIX_S
        await asyncio.gather(*(provided(each.app, Scheduler).look() for each in (house, other) * 5))
        assert len(await orders(house)) == 1


async def test_a_death_before_the_end_of_the_transaction_leaves_the_moment_to_the_next_life(
    url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def died(*_: object) -> None:
        raise UnavailableError("database", "it went away", "start it again")

    async with gateway(url) as house:
        schedule = await added(house, transport=None, order=ORDER)
        with monkeypatch.context() as dying:
            dying.setattr(IdempotencyKeys, "add", died)
            with pytest.raises(UnavailableError):
                await look(house, SIX_S)
        assert (await house.get(f"{PATH}/{schedule['id']}"))["last"] is None
        assert await orders(house) == []
    async with gateway(url, incarnation=2, wall=Wall(SIX_S + 60)) as house:
        await look(house, SIX_S + 60)
        [one] = await orders(house)
        assert one["due_at_s"] == SIX_S + 7200


async def test_a_death_after_it_is_made_good_by_the_next_life(
    url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with gateway(url) as house:
        await added(house, transport=None, order=ORDER)
        with monkeypatch.context() as dying:
            dying.setattr(OrderPlacement, "publish", lambda *_: None)
            await look(house, SIX_S)
        assert published(house) == set()
    async with gateway(url, incarnation=2, wall=Wall(SIX_S + 60)) as house:
        [one] = await orders(house)
        assert published(house) == {one["id"]}
        await look(house, SIX_S + 60)
        assert len(await orders(house)) == 1


async def test_a_clock_that_is_set_back_places_nothing_again(house: House) -> None:
    schedule = await added(house, transport=None, order=ORDER)
    await look(house, SIX_S)
    house.wall.now_s = SIX_S - 3600
    schedule = await house.get(f"{PATH}/{schedule['id']}")
    schedule = await change(house, schedule, paused=True)
    schedule = await change(house, schedule, paused=False)
    assert schedule["next_runs"][0] == "2030-03-18T06:00:00+01:00"
    await look(house, SIX_S)
    [one] = await orders(house)
    assert (await house.get(f"{PATH}/{schedule['id']}"))["last"]["order"] == one["id"]


@pytest.mark.parametrize(
    ("late_s", "due_s"),
    [(PUNCTUAL_S, SIX_S + 600), (3 * 3600.0, SIX_S + 3 * 3600 + 600)],
)
async def test_what_is_made_up_for_is_due_from_then_on(house: House, late_s: float, due_s: float) -> None:
    await added(house, transport=None, order=ORDER | {"due_after_s": 600}, missed="catch_up")
    await look(house, SIX_S + late_s)
    [one] = await orders(house)
    assert one["due_at_s"] == due_s


async def test_a_transport_becomes_an_order_and_the_other_way_round(house: House) -> None:
    schedule = await change(house, await added(house), order=ORDER)
    assert (schedule["transport"], schedule["order"]) == (None, ORDER)
    await look(house, SIX_S)
    schedule = await change(house, await house.get(f"{PATH}/{schedule['id']}"), transport=BRING)
    assert (schedule["order"], schedule["transport"]["item"]) == (None, "shaft")
    await look(house, SIX_S + DAY_S)
    assert (len(await orders(house)), len(await brought(house))) == (1, 1)


async def test_what_cannot_be_placed_any_more_is_told_and_the_calendar_goes_on(
    house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    schedule = await added(house, transport=None, order=ORDER)
    monkeypatch.setattr("dray.gateway.orders.placement.MAX_OPEN_ORDERS", -1)
    await look(house, SIX_S)
    now = await house.get(f"{PATH}/{schedule['id']}")
    assert now["last"]["order"] is None
    assert "cancel some" in now["last"]["refused"]
    assert now["next_runs"][0] == "2030-03-19T06:00:00+01:00"
    assert await orders(house) == []


@pytest.mark.parametrize(
    ("order", "field"),
    [
        (ORDER | {"items": []}, "order.items"),
        (ORDER | {"items": [{"product": "cheese", "quantity": 1}]}, "order.items[0].product"),
        (ORDER | {"due_after_s": 599}, "order.due_after_s"),
        (ORDER | {"due_after_s": "soon"}, "order.due_after_s"),
        (ORDER | {"due_at": "2031-01-01T00:00:00Z"}, "order.due_at"),
        (ORDER | {"customer": ""}, "order.customer"),
    ],
)
async def test_an_order_that_cannot_be_is_refused_by_its_field(
    house: House, order: dict[str, Any], field: str
) -> None:
    body = {name: value for name, value in DRAFT.items() if name != "transport"}
    response = await house.client.post(PATH, json=body | {"order": order})
    assert response.status_code == 422
    assert [each["field"] for each in response.json()["errors"]] == [field]
    schedule = await added(house)
    place, version = f"{PATH}/{schedule['id']}", {"If-Match": schedule["etag"]}
    changed = await house.client.patch(place, json={"order": order}, headers=version)
    assert (changed.status_code, [each["field"] for each in changed.json()["errors"]]) == (422, [field])
    assert await house.get(place) == schedule


async def test_one_of_both_is_asked_for(house: House) -> None:
    neither = {name: value for name, value in DRAFT.items() if name != "transport"}
    for body in (neither, DRAFT | {"order": ORDER}):
        response = await house.client.post(PATH, json=body)
        assert response.status_code == 422
        assert "either transport" in response.text


async def test_who_may_place_no_orders_plans_none(house: House) -> None:
    _, header = await house.key(Scope.FACTORY_READ, Scope.FLOOR_WRITE)
    visitor = house.visitor(**header)
    plain = {name: value for name, value in DRAFT.items() if name != "transport"} | {"order": ORDER}
    refused = await visitor.post(PATH, json=plain)
    assert (refused.status_code, "orders:write" in refused.json()["detail"]) == (403, True)
    kept = await visitor.post(PATH, json=DRAFT)
    assert kept.status_code == 201
    changed = await visitor.patch(
        f"{PATH}/{kept.json()['id']}", json={"order": ORDER}, headers={"If-Match": kept.json()["etag"]}
    )
    assert changed.status_code == 403
