"""GET /api/changes: other systems follow orders and transports without a gap, and wait for what comes next."""

from __future__ import annotations

import asyncio
from typing import Any

import pytest
from answers import problem
from gateway_kit import House, draft, gateway

from dray.gateway.access.principal import Scope
from dray.gateway.http.problems import Problem
from dray.gateway.http.provided import provided
from dray.gateway.http.shares import share_of
from dray.gateway.orders import change_feed
from dray.gateway.orders.change_feed import WAITING_MOST, ChangeFeed
from dray.store.orders.change_log import Seen

pytestmark = pytest.mark.anyio

CALLED = {"from": "S3", "to": "M8", "item": "shaft", "quantity": 4}


async def changes(house: House, since: int, **asked: Any) -> dict[str, Any]:
    found: dict[str, Any] = await house.get("/api/changes", since=since, **asked)
    return found


def statuses(found: dict[str, Any]) -> list[tuple[str, str]]:
    return [(each["id"], each["status"]) for each in found["items"]]


async def test_who_begins_is_told_where_it_is_and_then_everything_once(house: House) -> None:
    before = await house.place(reference="PO-1")
    begin = await house.get("/api/changes")
    assert (begin["items"], begin["more"]) == ([], False)
    one, two = await house.place(reference="PO-2"), await house.place()
    await house.client.post(f"/api/orders/{before['id']}/cancel")
    transport = (await house.client.post("/api/transports", json=CALLED)).json()["id"]
    expected = [
        (one["id"], "released"),
        (two["id"], "released"),
        (before["id"], "cancelled"),
        (transport, "waiting"),
    ]
    assert statuses(await changes(house, begin["since"])) == expected
    at, told = begin["since"], []
    for _ in range(3):
        part = await changes(house, at, limit=2)
        told += part["items"]
        at = part["since"]
    assert [(each["id"], each["status"]) for each in told] == expected
    assert not part["more"]
    assert [each["reference"] for each in told] == ["PO-2", None, "PO-1", None]
    assert [each["kind"] for each in told] == ["order", "order", "order", "transport"]
    assert statuses(await changes(house, at)) == []
    assert statuses(await changes(house, begin["since"], kind="transport")) == expected[3:]
    # What is not shown counts as read.
    assert (await changes(house, begin["since"], kind="order"))["since"] == at


async def test_a_key_that_may_only_read_orders_is_told_of_no_transport(house: House) -> None:
    begin = (await house.get("/api/changes"))["since"]
    order = await house.place()
    transport = (await house.client.post("/api/transports", json=CALLED)).json()["id"]
    shown = {
        (Scope.ORDERS_READ,): [order["id"]],
        (Scope.ORDERS_READ, Scope.TRANSPORTS_CALL): [order["id"]],
        (Scope.ORDERS_READ, Scope.TRANSPORTS_CALL, Scope.FACTORY_READ): [order["id"], transport],
    }
    for scopes, ids in shown.items():
        _, header = await house.key(*scopes)
        answer = await house.client.get("/api/changes", params={"since": begin}, headers=header)
        assert [each["id"] for each in answer.json()["items"]] == ids, scopes
    _, header = await house.key(Scope.TRANSPORTS_CALL, Scope.FACTORY_READ)
    problem(await house.client.get("/api/changes", headers=header), 403, "not-allowed")


async def test_who_waits_is_answered_when_something_changes(
    house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(change_feed, "LOOK_EVERY_S", 0.0)
    begin = (await house.get("/api/changes"))["since"]
    many = [asyncio.create_task(changes(house, begin, wait=30)) for _ in range(5)]
    only = asyncio.create_task(changes(house, begin, wait=30, kind="transport"))
    order = await house.place()
    for each in await asyncio.gather(*many):
        assert statuses(each) == [(order["id"], "released")]
    assert not only.done()
    transport = (await house.client.post("/api/transports", json=CALLED)).json()["id"]
    assert statuses(await only) == [(transport, "waiting")]


async def test_a_wait_ends_without_a_change(house: House, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(change_feed, "LOOK_EVERY_S", 0.0)
    begin = (await house.get("/api/changes"))["since"]
    assert await changes(house, begin, wait=0.05) == {"items": [], "since": begin, "more": False}


async def test_one_caller_waits_in_a_share_of_all_requests(house: House) -> None:
    feed = provided(house.app, ChangeFeed)
    begin = await feed.newest()
    nothing = Seen(orders=False, transports=None)
    feed.waiting["key one"] = share_of(WAITING_MOST)
    with pytest.raises(Problem, match="wait for changes"):
        await feed.after(begin, nothing, 1, caller="key one", wait_s=30.0)
    # It is refused the wait alone, and nobody else is refused anything.
    assert not (await feed.after(begin, nothing, 1, caller="key one")).rows
    assert not (await feed.after(begin, nothing, 1, caller="key two", wait_s=0.01)).rows
    assert dict(feed.waiting) == {"key one": share_of(WAITING_MOST)}


async def test_what_is_forgotten_is_said(house: House) -> None:
    begin = (await house.get("/api/changes"))["since"]
    for _ in range(3):
        await house.place()
    now = (await house.get("/api/changes"))["since"]
    async with house.store.write() as work:
        assert await work.change_log.prune(1e12, 100)
    answer = await house.client.get("/api/changes", params={"since": begin})
    told = problem(answer, 410, "changes-forgotten")["detail"]
    assert "older than what is kept" in told
    assert "read GET /api/orders" in told
    # A database that was restored from a backup knows less than the one before.
    ahead = await house.client.get("/api/changes", params={"since": now + 1, "wait": 30})
    told = problem(ahead, 410, "changes-forgotten")["detail"]
    assert "was not given out" in told
    assert "older" not in told
    assert statuses(await changes(house, now)) == []


async def test_it_goes_on_after_a_restart(url: str) -> None:
    async with gateway(url) as house:
        begin = (await house.get("/api/changes"))["since"]
        first = await house.place()
    async with gateway(url) as house:
        second = await house.place()
        found = await changes(house, begin)
        assert [each["id"] for each in found["items"]] == [first["id"], second["id"]]


async def test_orders_that_are_placed_together_are_all_told(house: House) -> None:
    begin = (await house.get("/api/changes"))["since"]
    answers = await asyncio.gather(
        *(house.client.post("/api/orders", json=draft()) for _ in range(20)),
    )
    placed = {answer.json()["id"] for answer in answers}
    found = await changes(house, begin)
    assert {each["id"] for each in found["items"]} == placed
    assert len(found["items"]) == 20
