"""A query parameter that a call does not know is refused; who asks again for what has not changed is told so."""

from __future__ import annotations

import pytest
from answers import problem
from gateway_kit import PRODUCT, House
from heartbeats import machine_heartbeat

from dray.gateway.access.rules import RULES

CALLS = sorted((method, path) for method, path in RULES if path.startswith("/api/") and path != "/api/stream")


def address(template: str) -> str:
    """A path of this template; nothing is there under it."""
    return template.replace("{", "").replace("}", "")


@pytest.mark.anyio
async def test_every_call_refuses_a_parameter_that_it_does_not_know(house: House) -> None:
    document = (await house.get("/api/openapi.json"))["paths"]
    for method, path in CALLS:
        answer = await house.client.request(method, address(path), params={"nosuch": "1", "x": "2"})
        told = problem(answer, 422, "unknown-parameter")
        assert [error["field"] for error in told["errors"]] == ["nosuch", "x"]
        parameters = document.get(path, {}).get(method.lower(), {}).get("parameters", [])
        known = sorted(each["name"] for each in parameters if each["in"] == "query")
        end = f"known here: {', '.join(known)}" if known else "none is known here"
        assert told["detail"] == f"'nosuch', 'x': there is no such parameter; {end}"


@pytest.mark.anyio
async def test_what_is_refused_for_its_query_does_nothing_and_is_in_the_audit_log(house: House) -> None:
    order = await house.place()
    problem(await house.client.post(f"/api/orders/{order['id']}/cancel?why=x"), 422, "unknown-parameter")
    assert (await house.get(f"/api/orders/{order['id']}"))["status"] == "released"
    line = (await house.audit(action="order.cancel"))[0]
    assert (line.result, line.target) == ("refused", order["id"])


@pytest.mark.anyio
async def test_a_stranger_is_not_told_what_a_call_knows(house: House) -> None:
    async with house.visitor() as visitor:
        problem(await visitor.get("/api/orders?nosuch=1"), 401, "not-logged-in")


@pytest.mark.anyio
async def test_many_unknown_parameters_get_a_short_answer(house: House) -> None:
    query = "&".join(f"{'x' * 200}{number}=1" for number in range(200))
    told = problem(await house.client.get(f"/api/orders?{query}"), 422, "unknown-parameter")
    assert len(told["errors"]) == 50
    assert max(len(error["field"]) for error in told["errors"]) == 64


@pytest.mark.anyio
async def test_pages_take_any_query(house: House) -> None:
    async with house.visitor() as visitor:
        assert (await visitor.get("/healthz?x=1")).status_code == 200
        assert (await visitor.get("/login?x=1")).status_code == 200


# --- If-None-Match -------------------------------------------------------------------------------


@pytest.mark.anyio
@pytest.mark.parametrize("given", ["{0}", "W/{0}", '"other", {0}', "*"])
async def test_what_has_not_changed_is_answered_with_304(house: House, given: str) -> None:
    await house.place()
    first = await house.client.get("/api/orders")
    again = await house.client.get(
        "/api/orders", headers={"If-None-Match": given.format(first.headers["etag"])}
    )
    assert (again.status_code, again.content) == (304, b"")
    assert again.headers["etag"] == first.headers["etag"]
    assert again.headers["cache-control"] == "no-store"
    assert "content-length" not in again.headers
    assert "content-type" not in again.headers


@pytest.mark.anyio
async def test_what_has_changed_is_answered_whole(house: House) -> None:
    await house.place()
    tag = (await house.client.get("/api/orders")).headers["etag"]
    await house.place()
    again = await house.client.get("/api/orders", headers={"If-None-Match": tag})
    assert again.status_code == 200
    assert len(again.json()["items"]) == 2
    assert again.headers["etag"] != tag


@pytest.mark.anyio
@pytest.mark.parametrize("noun", ["machines", "atvs", "tasks", "products", "plant", "kpis", "me"])
async def test_whatever_is_polled_has_a_tag(house: House, noun: str) -> None:
    house.bus.say(machine_heartbeat())
    first = await house.client.get(f"/api/{noun}")
    again = await house.client.get(f"/api/{noun}", headers={"If-None-Match": first.headers["etag"]})
    assert again.status_code == 304


@pytest.mark.anyio
async def test_refusals_tables_and_what_changes_something_have_no_tag(house: House) -> None:
    assert "etag" not in (await house.client.get("/api/orders/nosuch")).headers
    table = await house.client.get("/api/orders?format=csv", headers={"If-None-Match": "*"})
    assert (table.status_code, "etag" in table.headers) == (200, False)
    body = {"items": [{"product": PRODUCT, "quantity": 1}]}
    asked = await house.client.post("/api/orders/preview", json=body, headers={"If-None-Match": "*"})
    assert (asked.status_code, "etag" in asked.headers) == (200, False)


@pytest.mark.anyio
async def test_a_tag_is_no_key_to_what_somebody_may_not_see(house: House) -> None:
    tag = (await house.client.get("/api/me")).headers["etag"]
    async with house.visitor() as visitor:
        problem(await visitor.get("/api/me", headers={"If-None-Match": tag}), 401, "not-logged-in")
