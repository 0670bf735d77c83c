"""Keys of other systems: what they open, and how they end."""

from __future__ import annotations

from typing import Any

import httpx
import pytest
from answers import problem
from gateway_kit import House, gateway
from wall_clock import NOW_S

from dray.gateway.access.keys import KNOWN_S
from dray.gateway.access.principal import Scope
from dray.gateway.access.tokens import new_key
from dray.store.access.api_keys import ApiKey, ApiKeys

pytestmark = pytest.mark.anyio


async def test_a_key_ends_with_its_time_or_when_it_is_taken_back(
    house: House, visitor: httpx.AsyncClient
) -> None:
    _, short = await house.key(Scope.ORDERS_READ, expires_at_s=NOW_S + 60)
    key, long = await house.key(Scope.ORDERS_READ)
    for header in (short, long):
        assert (await visitor.get("/api/orders", headers=header)).status_code == 200
    house.wall.now_s += 60
    problem(await visitor.get("/api/orders", headers=short), 401, "not-logged-in")
    async with house.store.write() as work:
        await work.api_keys.revoke(key.id, house.wall.now_s)
    house.wall.now_s += KNOWN_S
    problem(await visitor.get("/api/orders", headers=long), 401, "not-logged-in")


async def test_a_key_that_is_used_all_the_time_is_looked_up_once_a_second(
    house: House, visitor: httpx.AsyncClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    _, header = await house.key(Scope.ORDERS_READ)
    asked: list[str] = []
    find = ApiKeys.find

    async def counting(keys: ApiKeys, token: str) -> ApiKey | None:
        asked.append(token)
        return await find(keys, token)

    monkeypatch.setattr(ApiKeys, "find", counting)
    for _ in range(30):
        assert (await visitor.get("/api/products", headers=header)).status_code == 200
        house.wall.now_s += 0.125
    assert len(asked) == 4
    house.wall.now_s -= 3600.0
    await visitor.get("/api/products", headers=header)
    assert len(asked) == 5, "a clock that was set back makes nothing known for an hour"


async def test_a_key_that_nobody_has_is_looked_up_each_time(house: House, visitor: httpx.AsyncClient) -> None:
    token = new_key()
    header = {"Authorization": f"Bearer {token}"}
    problem(await visitor.get("/api/products", headers=header), 401, "not-logged-in")
    async with house.store.write() as work:
        key = ApiKey(id="k1", name="ERP", scopes="orders:read", created_at_s=NOW_S)
        await work.api_keys.add(token, key)
    assert (await visitor.get("/api/products", headers=header)).status_code == 200


async def test_a_key_tells_what_it_is_and_when_it_was_used(house: House, visitor: httpx.AsyncClient) -> None:
    key, header = await house.key(Scope.ORDERS_READ)
    me = (await visitor.get("/api/me", headers=header)).json()
    assert me == {
        "kind": "key",
        "id": key.id,
        "name": "ERP",
        "role": None,
        "areas": None,
        "station": "",
        "scopes": ["orders:read"],
        "expires_at_s": None,
    }
    house.wall.now_s += 30
    await visitor.get("/api/me", headers=header)
    async with house.store.read() as work:
        kept = await work.api_keys.get(key.id)
    assert kept is not None
    assert kept.used_at_s == NOW_S, "not written for every request"


async def test_a_scope_that_this_dray_does_not_know_allows_nothing(
    house: House, visitor: httpx.AsyncClient
) -> None:
    key, header = await house.key()
    async with house.store.database.write() as connection:
        await connection.exec_driver_sql("UPDATE api_keys SET scopes = 'orders:read teleport'")
    assert (await visitor.get("/api/me", headers=header)).json()["scopes"] == ["orders:read"]
    assert key.scopes == ""


DAY_S = 86_400.0

GIVEN: dict[str, Any] = {
    "name": "Button",
    "scopes": ["transports:call"],
    "places": ["M8"],
    "items": ["shaft"],
    "open_max": 4,
    "open_each_max": 2,
    "priority": "normal",
    "days": 9,
}
"""What the key of the next test may give at most."""


@pytest.mark.parametrize(
    ("field", "more"),
    [
        ("places", []),
        ("places", ["M8", "M9"]),
        ("items", []),
        ("items", ["bearing"]),
        ("open_max", 5),
        ("open_each_max", 3),
        ("priority", "high"),
        ("days", None),
        ("days", 11),
    ],
)
async def test_a_key_makes_none_that_may_more_than_itself_or_longer(
    house: House, field: str, more: Any
) -> None:
    """Whoever has stolen it has one for longer otherwise, or for other places."""
    _, header = await house.key(
        Scope.PEOPLE_WRITE,
        Scope.TRANSPORTS_CALL,
        places="M8",
        items="shaft",
        open_max=4,
        open_each_max=2,
        expires_at_s=NOW_S + 10 * DAY_S,
    )
    thief = house.visitor(**header)
    made = await thief.post("/api/keys", json=GIVEN)
    assert made.status_code == 201, made.text
    told = problem(await thief.post("/api/keys", json=GIVEN | {field: more}), 403, "not-allowed")
    assert field in told["detail"]
    assert (await house.client.post("/api/keys", json=GIVEN | {field: more})).status_code == 201


async def test_one_key_asks_so_often_and_no_more(url: str) -> None:
    async with gateway(url, key_burst=3, key_rate_hz=0.5) as house, house.visitor() as visitor:
        _, busy = await house.key(Scope.ORDERS_READ)
        _, other = await house.key(Scope.ORDERS_READ)
        for _ in range(3):
            assert (await visitor.get("/api/orders", headers=busy)).status_code == 200
        answer = await visitor.get("/api/orders", headers=busy)
        problem(answer, 429, "too-many-tries")
        assert answer.headers["retry-after"] == "2"
        assert (await visitor.get("/api/orders", headers=other)).status_code == 200
        house.wall.now_s += 2
        assert (await visitor.get("/api/orders", headers=busy)).status_code == 200
