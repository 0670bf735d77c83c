"""Orders: placing, finding, releasing and cancelling them."""

from __future__ import annotations

from typing import Any

import msgspec
import pytest
from answers import problem
from fake_bus import PLANT, FakeBus
from gateway_kit import OTHER_PRODUCT, PRODUCT, House, draft, gateway
from heartbeats import events
from wall_clock import NOW_S, Wall

from dray.gateway.access.principal import Scope
from dray.messages import OrderCancelled, OrderReleased, OrderTaken
from dray.messages.fact import GoalContracted, GoodsDelivered, OrderAccepted, OrderDropped, PieceMade
from dray.plant.model import PlantFile
from dray.store.orders.progress import OrderStatus

pytestmark = pytest.mark.anyio


async def test_an_order_is_answered_with_its_place_and_its_customers_page(house: House) -> None:
    items = [{"product": PRODUCT, "quantity": 5}, {"product": OTHER_PRODUCT, "quantity": 1}]
    response = await house.client.post(
        "/api/orders",
        json=draft(items=items, due_at="2030-03-17T21:46:40+02:00", reference="4711"),
    )
    assert response.status_code == 201
    order = response.json()
    assert response.headers["location"] == f"/api/orders/{order['id']}"
    assert order["status"] == "released"
    assert order["customer"] == "Muster GmbH"
    assert order["reference"] == "4711"
    assert order["items"] == [item | {"made": 0, "delivered": 0, "wanted": None} for item in items]
    assert order["created_at"] == "2030-03-17T17:46:40.000Z"
    assert order["created_at_s"] == NOW_S
    assert order["due_at"] == "2030-03-17T19:46:40.000Z"
    assert order["due_at_s"] == NOW_S + 7200
    assert await house.get(response.headers["location"]) | {"hints": []} == order
    assert order["tracking_url"].startswith("http://dray.test/track/")
    page = await house.client.get(order["tracking_url"].replace("/track/", "/api/track/"))
    assert [(item["product"], item["quantity"]) for item in page.json()["items"]] == [
        (item["product"], item["quantity"]) for item in items
    ]


async def test_an_order_with_the_customer_and_reference_of_a_young_one_is_placed_with_a_hint(
    house: House,
) -> None:
    async def place(key: str = "", **fields: Any) -> dict[str, Any]:
        headers = {"Idempotency-Key": key} if key else {}
        answer = await house.client.post("/api/orders", json=draft(**fields), headers=headers)
        assert answer.status_code == 201
        placed: dict[str, Any] = answer.json()
        return placed

    first = await place(key="k1", reference="4711")
    assert first["hints"] == []
    house.wall.now_s += 720.0
    assert await place(key="k1", reference="4711") == first, "sent again under its key it is no other order"
    second = await place(key="k2", reference="4711")
    (hint,) = second["hints"]
    assert (hint["field"], hint["code"]) == ("reference", "placed_twice")
    assert hint["values"] == {"customer": "Muster GmbH", "order": first["id"], "minutes": "12"}
    assert hint["reason"].startswith(f"Muster GmbH has order {first['id']} with this reference, too")
    assert await place(key="k2", reference="4711") == second, "the first answer is given again, with its hint"
    house.wall.now_s += 60.0
    (hint,) = (await place(reference="4711"))["hints"]
    assert hint["values"]["order"] == second["id"], "the newest"
    for other in ({"reference": "4712"}, {"reference": "4711", "customer": "Other"}, {}, {}):
        assert (await place(**other))["hints"] == []
    house.wall.now_s += 3601.0
    assert (await place(reference="4711"))["hints"] == []


async def test_a_cancelled_order_is_no_reason_for_a_hint(house: House) -> None:
    first = await house.place(reference="4711")
    await house.client.post(f"/api/orders/{first['id']}/cancel")
    again = await house.client.post("/api/orders", json=draft(reference="4711"))
    assert again.json()["hints"] == []


async def test_an_urgent_order_is_wanted_soon_after_its_release_and_due_when_it_was_said(
    house: House,
) -> None:
    order = await house.place(priority="urgent", due_at="2030-03-18T17:46:40Z")
    assert order["priority"] == "urgent"
    assert order["wanted_at_s"] == NOW_S + 900.0 / house.projection.speed
    assert order["due_at_s"] == NOW_S + 86_400.0
    stored = await house.place(priority="low", release=False)
    assert stored["wanted_at_s"] is None
    released = (await house.client.post(f"/api/orders/{stored['id']}/release")).json()
    assert released["wanted_at_s"] == NOW_S + 16 * 3600.0 / house.projection.speed
    wrong = await house.client.post("/api/orders", json=draft(priority="at once"))
    assert problem(wrong, 422, "unusable-fields")["errors"][0]["field"] == "priority"


async def test_an_answered_order_is_on_disk_when_the_store_is_opened_again(url: str) -> None:
    async with gateway(url) as before:
        order = await before.place(reference="4711")
    async with gateway(url) as after:
        assert await after.get(f"/api/orders/{order['id']}") | {"hints": []} == order
        async with after.store.read() as work:
            kept = await work.orders.get(order["id"])
    assert kept is not None
    assert kept.status is OrderStatus.RELEASED


async def test_a_released_order_is_given_to_the_strategist(house: House) -> None:
    given = house.bus.strategist()
    order = await house.place(due_at="2030-03-17T18:46:40Z")
    (released,) = given
    assert released.order == order["id"]
    assert [(item.product, item.quantity) for item in released.items] == [(PRODUCT, 5)]
    assert released.due_s == 3600.0


async def test_an_open_order_of_an_earlier_life_is_given_to_the_strategist_again(url: str) -> None:
    async with gateway(url) as before:
        order = await before.place()
        stored = await before.place(release=False)
    async with gateway(url) as after:
        given = await after.bus.next_to("strategist", OrderReleased)
        assert [one.order for one in after.bus.sent_to("strategist", OrderReleased)] == [order["id"]]
    assert given.order == order["id"] != stored["id"]


async def test_a_stored_order_is_given_to_nobody_until_it_is_released(house: House) -> None:
    order = await house.place(release=False)
    assert order["status"] == "stored"
    assert house.bus.sent == []
    for _ in range(2):
        response = await house.client.post(f"/api/orders/{order['id']}/release")
        assert response.status_code == 200
        assert response.json()["status"] == "released"
    assert [one.order for one in house.bus.sent_to("strategist", OrderReleased)] == [order["id"]]


async def test_a_cancelled_order_is_taken_back_from_the_strategist(house: House) -> None:
    order = await house.place()
    for _ in range(2):
        response = await house.client.post(f"/api/orders/{order['id']}/cancel")
        assert response.status_code == 200
        assert response.json()["status"] == "cancelled"
    assert [one.order for one in house.bus.sent_to("strategist", OrderCancelled)] == [order["id"]]
    house.bus.say(*events("strategist", OrderDropped(order=order["id"])))
    assert (await house.get(f"/api/orders/{order['id']}"))["status"] == "cancelled"


async def test_a_cancelled_order_cannot_be_released(house: House) -> None:
    order = await house.place(release=False)
    await house.client.post(f"/api/orders/{order['id']}/cancel")
    refused = problem(await house.client.post(f"/api/orders/{order['id']}/release"), 409, "order-ended")
    assert order["id"] in refused["detail"]
    assert "place it again" in refused["detail"]
    assert (await house.get(f"/api/orders/{order['id']}"))["status"] == "cancelled"


async def test_a_delivered_order_cannot_be_cancelled(house: House) -> None:
    order = await house.place()
    await house.say(delivery_of(order))
    kept = await house.get(f"/api/orders/{order['id']}")
    assert kept["status"] == "delivered"
    assert kept["delivered_at_s"] == NOW_S + 201.0
    assert kept["items"][0]["delivered"] == 5
    refused = problem(await house.client.post(f"/api/orders/{order['id']}/cancel"), 409, "order-ended")
    assert "delivered" in refused["detail"]
    assert await house.get(f"/api/orders/{order['id']}") == kept


async def test_only_the_strategists_word_ends_the_reminders(
    house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("dray.gateway.orders.outbox.PAUSE_S", (0.001, 0.001))
    order = await house.place()
    house.bus.tell("somebody", "gateway", OrderTaken(order=order["id"]))
    again = await house.bus.next_to("strategist", OrderReleased, after=1)
    assert again.order == order["id"]


async def test_orders_are_listed_newest_first_in_pages_that_hold_each_once(url: str) -> None:
    wall = Wall()
    async with gateway(url, wall=wall) as house:
        placed = []
        for number in range(7):
            # Two of each moment: their ids decide.
            wall.now_s = NOW_S + number // 2
            placed.append((await house.place())["id"])
        whole = [order["id"] for order in (await house.get("/api/orders"))["items"]]
        assert sorted(whole) == sorted(placed)
        assert whole == sorted(placed, reverse=True)
        assert await in_pages(house, limit=2) == [whole[0:2], whole[2:4], whole[4:6], whole[6:7]]
        assert await in_pages(house, limit=7) == [whole]


async def test_orders_are_found_by_what_people_know_of_them(house: House) -> None:
    pump = [{"product": OTHER_PRODUCT, "quantity": 1}]
    first = await house.place(reference="PO-17", customer="Hall 3", due_at="2030-03-18T00:00:00Z")
    house.wall.now_s += 1
    second = await house.place(
        reference="PO-18", customer="Hall 3", items=pump, due_at="2030-03-19T00:00:00Z"
    )
    house.wall.now_s += 1
    third = await house.place(customer="Hall 4")

    async def found(**wanted: str) -> list[str]:
        names = [order["id"] for order in (await house.get("/api/orders", **wanted))["items"]]
        table = (await house.client.get("/api/orders", params=wanted | {"format": "csv"})).text
        assert [line.split(",")[0] for line in table.splitlines()[1:]] == names
        return names

    assert await found(reference="PO-17") == [first["id"]]
    assert await found(reference="PO-1") == []
    assert await found(customer="Hall 3") == [second["id"], first["id"]]
    assert await found(customer="Hall 3", product=PRODUCT) == [first["id"]]
    assert await found(product=OTHER_PRODUCT) == [second["id"]]
    assert await found(due_before="2030-03-19T00:00:00Z") == [first["id"]]
    assert await found(due_before="2030-03-19T02:00:00+01:00") == [second["id"], first["id"]]
    day = {"created_since": second["created_at"], "created_before": third["created_at"]}
    assert await found(**day) == [second["id"]]
    assert await found(**day, reference="PO-17") == []
    assert await found(updated_since=second["updated_at"]) == [third["id"], second["id"]]
    assert await found(updated_since=third["updated_at"], customer="Hall 3") == []


async def test_a_page_goes_on_behind_the_longest_names(house: House) -> None:
    for customer in ("顧" * 200, '"' * 200, "é" * 199 + "z"):
        await house.place(customer=customer, reference=customer)
    for sort in ("customer", "reference"):
        pages, cursor = [], {}
        while cursor is not None:
            page = await house.get("/api/orders", sort=sort, limit=1, **cursor)
            pages += [order[sort] for order in page["items"]]
            cursor = {"cursor": page["next_cursor"]} if page["next_cursor"] else None
        assert pages == ['"' * 200, "é" * 199 + "z", "顧" * 200]


async def test_who_follows_changes_by_their_newest_time_misses_none(house: House) -> None:
    order = await house.place()
    house.wall.now_s += 60
    other = await house.place()
    await house.client.post(f"/api/orders/{other['id']}/cancel")
    since = (await house.get(f"/api/orders/{other['id']}"))["updated_at"]
    house.wall.now_s += 60
    contracted = GoalContracted("G1", order["id"], 0, PRODUCT, 5, "M1", 9.0)
    await house.say(events("strategist", OrderAccepted(order=order["id"], goals=("G1",)), contracted))
    await house.say(events("M1", PieceMade(goal="G1", product=PRODUCT, made=1)))
    changed = (await house.get("/api/orders", updated_since=since))["items"]
    assert [each["id"] for each in changed] == [other["id"], order["id"]]
    assert [each["items"][0]["made"] for each in changed] == [0, 1]


async def test_a_page_stays_where_it_is_while_orders_come(house: House) -> None:
    first = [(await house.place())["id"] for _ in range(3)]
    page = await house.get("/api/orders", limit=1)
    house.wall.now_s += 1
    await house.place()
    rest = await house.get("/api/orders", limit=10, cursor=page["next_cursor"])
    assert sorted(order["id"] for order in page["items"] + rest["items"]) == sorted(first)


async def test_orders_are_found_by_one_status_or_several(house: House) -> None:
    released, stored, cancelled = [await house.place(release=release) for release in (True, False, True)]
    await house.client.post(f"/api/orders/{cancelled['id']}/cancel")
    for statuses, expected in (
        (["released"], {released["id"]}),
        (["stored", "cancelled"], {stored["id"], cancelled["id"]}),
        (["delivered"], set()),
    ):
        found = await house.get("/api/orders", status=statuses)
        assert {order["id"] for order in found["items"]} == expected
        assert found["next_cursor"] is None


@pytest.mark.parametrize("path", ["", "/release", "/revoke", "/cancel"])
async def test_an_unknown_order_is_not_found(house: House, path: str) -> None:
    method = "POST" if path else "GET"
    answer = await house.client.request(method, f"/api/orders/O-000000000-0000{path}")
    body = problem(answer, 404, "unknown-order")
    assert "O-000000000-0000" in body["detail"]
    assert "GET /api/orders" in body["detail"]


async def test_the_customers_view_tells_how_far_it_is_and_no_names(house: House) -> None:
    order = await house.place(reference="4711")
    path = "/api/track/" + order["tracking_url"].rpartition("/")[2]
    view = await house.get(path)
    assert [stage["name"] for stage in view["stages"] if stage["reached"]] == ["placed"]
    assert view["reference"] == "4711"
    await house.say(delivery_of(order))
    response = await house.client.get(path)
    assert all(stage["reached"] for stage in response.json()["stages"])
    assert "Muster" not in response.text
    assert order["id"] not in response.text
    assert response.headers["x-robots-tag"] == "noindex, nofollow"
    assert response.headers["cache-control"] == "private, no-store"


async def test_nobody_guesses_a_customers_page(house: House) -> None:
    problem(await house.client.get("/api/track/guess"), 404, "unknown-tracking-page")


async def test_an_order_may_have_no_due_time_and_then_a_shift(house: House) -> None:
    order = await house.place()
    assert order["due_at"] is None
    assert (await house.bus.next_to("strategist", OrderReleased)).due_s == 8 * 3600.0


async def test_more_orders_than_can_be_open_are_refused_until_one_has_ended(
    house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("dray.gateway.orders.placement.MAX_OPEN_ORDERS", 2)
    order = await house.place()
    _, other = await house.key(Scope.ORDERS_WRITE)
    assert (await house.client.post("/api/orders", json=draft(), headers=other)).status_code == 201
    await house.client.post(f"/api/orders/{order['id']}/cancel")
    _, third = await house.key(Scope.ORDERS_WRITE)
    last = await house.client.post("/api/orders", json=draft(), headers=third)
    response = await house.client.post("/api/orders", json=draft())
    problem(response, 503, "too-many-orders")
    assert int(response.headers["retry-after"]) > 0
    await house.client.post(f"/api/orders/{last.json()['id']}/cancel")
    await house.place()


async def test_an_order_for_what_the_plant_no_longer_makes_waits_and_says_so(
    url: str, caplog: pytest.LogCaptureFixture
) -> None:
    async with gateway(url) as before:
        order = await before.place()
    async with gateway(url, plant=without(PRODUCT), bus=FakeBus()) as after:
        assert (await after.get(f"/api/orders/{order['id']}"))["status"] == "released"
        assert after.bus.sent == []
    assert f"order {order['id']} waits: this plant does not make {PRODUCT}" in caplog.text


# --- helpers -------------------------------------------------------------------------------------


def without(product: str) -> PlantFile:
    """The plant, in which nobody makes this product any more, and nobody knows it."""
    replace = msgspec.structs.replace
    machines = tuple(
        replace(machine, makes=tuple(making for making in machine.makes if making.product != product))
        for machine in PLANT.machines
    )
    return replace(
        PLANT,
        products=tuple(each for each in PLANT.products if each.id != product),
        machines=tuple(machine for machine in machines if machine.makes),
    )


async def in_pages(house: House, limit: int) -> list[list[str]]:
    """Ids of all orders, page by page."""
    pages, cursor = [], None
    while True:
        params: dict[str, Any] = {"limit": limit} | ({"cursor": cursor} if cursor else {})
        page = await house.get("/api/orders", **params)
        pages.append([order["id"] for order in page["items"]])
        cursor = page["next_cursor"]
        if cursor is None:
            return pages


def delivery_of(order: dict[str, Any]) -> list[Any]:
    """What agents tell when the one item of an order is made and delivered."""
    name, (item,) = order["id"], order["items"]
    return [
        *events(
            "strategist",
            OrderAccepted(order=name, goals=("G1",)),
            GoalContracted(
                goal="G1",
                order=name,
                item=0,
                product=item["product"],
                quantity=item["quantity"],
                machine="M1",
                finish_s=900.0,
            ),
        ),
        *events(
            "M1",
            GoodsDelivered(
                goal="G1",
                order=name,
                item=0,
                product=item["product"],
                quantity=item["quantity"],
                delivered=item["quantity"],
            ),
            at_s=200.0,
        ),
    ]
