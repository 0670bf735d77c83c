"""Where all callers have one bound together, one of them takes a share of it, and the others go on."""

from __future__ import annotations

import asyncio
from typing import Any

import pytest
from answers import problem
from gateway_kit import House
from gateway_kit import draft as order_draft
from httpx import AsyncClient
from recurring_kit import BRING, DAY_S, SIX_S, look
from recurring_kit import DRAFT as SCHEDULE

from dray.gateway.access.principal import Scope
from dray.gateway.http.problems import Problem
from dray.gateway.http.shares import share_of
from dray.gateway.orders.drafts import OrderDraft
from dray.gateway.orders.placement import OrderPlacement
from dray.gateway.schedules.scheduler import Scheduler
from dray.store.orders.orders import Order
from dray.store.work import Work

pytestmark = pytest.mark.anyio


@pytest.fixture(autouse=True)
def asked_by_the_test_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Only the test looks at what recurs, and nobody besides when it is new."""
    monkeypatch.setattr(Scheduler, "run", lambda _: asyncio.Event().wait())


async def caller(house: House, *scopes: Scope) -> AsyncClient:
    """Another one than the client of the house, with a key of its own."""
    _, header = await house.key(*scopes)
    return house.visitor(**header)


def test_a_share_is_a_part_and_never_nothing() -> None:
    assert [share_of(each) for each in (5_000, 50, 12, 3, 0)] == [1_250, 12, 3, 1, 1]


async def test_one_caller_begins_a_share_of_all_drafts(house: House, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("dray.gateway.routes.factory.plant_drafts.MAX_DRAFTS", 4)
    greedy, path = await caller(house, Scope.FLOOR_WRITE, Scope.FACTORY_READ), "/api/plant-drafts"
    begun = await greedy.post(path, json={"name": "One"})
    assert begun.status_code == 201, begun.text
    problem(await greedy.post(path, json={"name": "Two"}), 429, "share-used")
    assert (await house.client.post(path, json={"name": "Another's"})).status_code == 201
    assert [each["name"] for each in sorted((await house.get(path))["items"], key=lambda each: each["at_s"])]
    removed = await greedy.delete(f"{path}/{begun.json()['id']}", headers={"If-Match": '"1"'})
    assert removed.status_code == 204
    assert (await greedy.post(path, json={"name": "Two"})).status_code == 201


@pytest.fixture
async def greedy(house: House, monkeypatch: pytest.MonkeyPatch) -> AsyncClient:
    """A caller that has begun all the recurring work that is its share: one of four."""
    monkeypatch.setattr("dray.gateway.schedules.scheduler.SCHEDULES_MAX", 4)
    greedy = await caller(house, Scope.FLOOR_WRITE, Scope.FACTORY_READ)
    begun = await greedy.post("/api/schedules", json=SCHEDULE | {"name": "One"})
    assert begun.status_code == 201, begun.text
    return greedy


async def test_one_caller_begins_a_share_of_all_recurring_work(house: House, greedy: AsyncClient) -> None:
    path = "/api/schedules"
    problem(await greedy.post(path, json=SCHEDULE | {"name": "Two"}), 429, "share-used")
    answer = await house.client.post(path, json=SCHEDULE | {"name": "Another's"})
    assert answer.status_code == 201, answer.text
    # Whoever changes what another has begun does not make it an own one.
    ours = {"If-Match": answer.headers["ETag"]}
    changed = await greedy.patch(f"{path}/{answer.json()['id']}", json={"paused": True}, headers=ours)
    assert changed.status_code == 200, changed.text
    assert (await house.client.post(path, json=SCHEDULE | {"name": "A third"})).status_code == 429


def recurring(work: dict[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in (SCHEDULE | work).items() if value is not None}


ORDERS = {"transport": None, "order": order_draft()}


@pytest.mark.parametrize(
    ("work", "bound", "most", "path"),
    [
        ({}, "dray.gateway.orders.transports.OPEN_MAX", 8, "/api/transports"),
        (
            ORDERS,
            "dray.gateway.orders.placement.MAX_OPEN_ORDERS",
            4,
            "/api/orders",
        ),
    ],
    ids=["transports", "orders"],
)
async def test_all_recurring_work_of_one_caller_has_its_share_and_not_one_each(
    house: House, monkeypatch: pytest.MonkeyPatch, work: dict[str, Any], bound: str, most: int, path: str
) -> None:
    monkeypatch.setattr(bound, most)
    greedy = await caller(house, Scope.FLOOR_WRITE, Scope.FACTORY_READ, Scope.ORDERS_WRITE)
    draft = recurring(work)
    for number in range(4):
        begun = await greedy.post("/api/schedules", json=draft | {"name": f"{number}"})
        assert begun.status_code == 201, begun.text
    await look(house, SIX_S)
    assert len((await house.get(path))["items"]) == 2
    refused = [each["last"]["refused"] for each in (await house.get("/api/schedules"))["items"]]
    assert [None if why is None else "one caller may have 2" in why for why in sorted(refused, key=bool)] == [
        *(None, None),
        *(True, True),
    ]
    # Others are not held up by it.
    assert (await house.client.post("/api/schedules", json=draft | {"name": "Another's"})).status_code == 201
    await look(house, SIX_S + DAY_S)
    assert len((await house.get(path))["items"]) == 3


async def test_recurring_work_may_be_planned_by_who_has_used_its_share(
    house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("dray.gateway.orders.placement.MAX_OPEN_ORDERS", 2)
    greedy = await caller(house, Scope.FACTORY_READ, Scope.FLOOR_WRITE, Scope.ORDERS_WRITE)
    assert (await greedy.post("/api/orders", json=order_draft())).status_code == 201
    problem(await greedy.post("/api/orders", json=order_draft()), 429, "share-used")
    begun = await greedy.post("/api/schedules", json=recurring(ORDERS))
    assert begun.status_code == 201, begun.text
    changed = await greedy.patch(
        f"/api/schedules/{begun.json()['id']}",
        json={"order": order_draft(customer="Another")},
        headers={"If-Match": begun.json()["etag"]},
    )
    assert changed.status_code == 200, changed.text


async def test_an_order_that_recurs_counts_until_it_is_published(
    house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("dray.gateway.orders.placement.MAX_OPEN_ORDERS", 2)
    greedy = await caller(house, Scope.FACTORY_READ, Scope.FLOOR_WRITE, Scope.ORDERS_WRITE)
    assert (await greedy.post("/api/schedules", json=recurring(ORDERS))).status_code == 201
    keep, meanwhile = OrderPlacement.keep, []

    async def slowly(self: OrderPlacement, work: Work, order: Order, key: str) -> None:
        with (
            pytest.raises(Problem) as refused,
            self.order(OrderDraft.model_validate(order_draft()), order.caller),
        ):
            pass
        meanwhile.append(refused.value.kind)
        await keep(self, work, order, key)

    monkeypatch.setattr(OrderPlacement, "keep", slowly)
    await look(house, SIX_S)
    assert (meanwhile, await house.orders_kept()) == (["share-used"], 1)
    # One that was refused counts no longer.
    [order] = (await house.get("/api/orders"))["items"]
    monkeypatch.setattr(OrderPlacement, "keep", keep)
    await look(house, SIX_S + DAY_S)
    assert (await house.client.post(f"/api/orders/{order['id']}/cancel")).status_code == 200
    assert (await greedy.post("/api/orders", json=order_draft())).status_code == 201


async def test_recurring_work_belongs_to_who_has_said_last_what_is_done(house: House) -> None:
    button = await caller(house, Scope.FLOOR_WRITE, Scope.TRANSPORTS_CALL)
    begun = await button.post("/api/schedules", json=SCHEDULE)
    assert begun.status_code == 201, begun.text

    async def seen() -> int:
        return len((await button.get("/api/transports")).json()["items"])

    await look(house, SIX_S)
    assert await seen() == 1
    # Another name and the same work are no other work: it is the button's still.
    path = f"/api/schedules/{begun.json()['id']}"
    same, other = {"name": "Shafts again", "transport": BRING}, {"transport": BRING | {"quantity": 20}}
    for change, more in ((same, 1), (other, 0)):
        at_s, before = house.wall.now_s, await seen()
        answer = await house.client.patch(path, json=change, headers={"If-Match": "*"})
        assert answer.status_code == 200, answer.text
        await look(house, at_s + DAY_S)
        assert await seen() == before + more
    transports = (await house.get("/api/transports"))["items"]
    assert len(transports) == 3
    [anothers] = [each["id"] for each in transports if each["quantity"] == 20]
    assert (await button.post(f"/api/transports/{anothers}/cancel")).status_code == 404


@pytest.mark.parametrize(
    "oftener",
    [
        {"calendar": "0,30 6 * * *"},
        {"time_zone": "Europe/London"},
        {"holidays": ["2030-12-25"]},
        {"holidays_of": "DE"},
    ],
)
async def test_who_lets_anothers_recurring_work_come_oftener_uses_its_own_share(
    house: House, monkeypatch: pytest.MonkeyPatch, oftener: dict[str, Any]
) -> None:
    monkeypatch.setattr("dray.gateway.orders.transports.OPEN_MAX", 8)
    _, header = await house.key(Scope.FLOOR_WRITE, Scope.TRANSPORTS_CALL)
    button = house.visitor(**header)
    begun = await button.post("/api/schedules", json=SCHEDULE)
    _, header = await house.key(Scope.FLOOR_WRITE, Scope.FACTORY_READ)
    path = f"/api/schedules/{begun.json()['id']}"
    answer = await house.visitor(**header).patch(path, json=oftener, headers={"If-Match": "*"})
    assert answer.status_code == 200, answer.text
    for day in range(3):
        for hour_s in (0.0, 3600.0):
            await look(house, SIX_S + day * DAY_S + hour_s)
    # The one that it was has its whole share.
    for _ in range(2):
        called = await button.post("/api/transports", json={"to": "M8", "item": "shaft", "quantity": 1})
        assert called.status_code == 201, called.text
    assert len((await house.get("/api/transports"))["items"]) == 4


async def test_who_takes_on_recurring_work_has_its_share_of_that(house: House, greedy: AsyncClient) -> None:
    path = "/api/schedules"
    another = await house.client.post(path, json=SCHEDULE | {"name": "Another's"})
    taken = await greedy.patch(
        f"{path}/{another.json()['id']}",
        json={"transport": BRING | {"quantity": 20}},
        headers={"If-Match": "*"},
    )
    problem(taken, 429, "share-used")


async def test_one_caller_has_half_of_all_open_orders(house: House, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("dray.gateway.orders.placement.MAX_OPEN_ORDERS", 4)
    greedy, path = await caller(house, Scope.ORDERS_WRITE, Scope.ORDERS_READ), "/api/orders"

    async def placed(**fields: Any) -> str:
        answer = await greedy.post(path, json=order_draft(**fields))
        assert answer.status_code == 201, answer.text
        return str(answer.json()["id"])

    first, _ = await placed(), await placed()
    body = problem(await greedy.post(path, json=order_draft()), 429, "share-used")
    assert "of 4 open orders one caller may have 2" in body["detail"]
    assert await house.orders_kept() == 2
    assert (await house.client.post(path, json=order_draft())).status_code == 201
    assert (await greedy.post(f"{path}/{first}/cancel")).status_code == 200
    await placed()
