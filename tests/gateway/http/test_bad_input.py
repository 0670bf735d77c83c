"""Whatever is sent, the answer is a problem that says what, where and what to do; nothing is stored."""

from __future__ import annotations

import json
from collections.abc import AsyncIterator
from typing import Any

import pytest
from answers import problem
from fake_bus import PLANT
from gateway_kit import PRODUCT, House, draft, gateway

from dray.gateway.http.middleware import BODY_BYTES
from dray.gateway.orders.drafts import MAX_ITEMS, MAX_QUANTITY
from dray.messages import OrderReleased

pytestmark = pytest.mark.anyio

LINE = {"product": PRODUCT, "quantity": 5}


class _Missing:
    """Stands for a field that is left out."""

    def __repr__(self) -> str:
        return "MISSING"  # The same in every worker, for it names the test.


MISSING = _Missing()

JSON = {"Content-Type": "application/json"}


@pytest.fixture
def house(quiet_house: House) -> House:
    """What is refused changes nothing, so one gateway refuses it all."""
    return quiet_house


async def nothing_stored(house: House) -> bool:
    return await house.orders_kept() == 0 and house.bus.sent_to("strategist", OrderReleased) == []


def line(**fields: Any) -> dict[str, Any]:
    return {name: value for name, value in (LINE | fields).items() if value is not MISSING}


def body(**fields: Any) -> dict[str, Any]:
    return {name: value for name, value in draft(**fields).items() if value is not MISSING}


async def refused(house: House, content: Any) -> list[dict[str, str]]:
    """The single faults of a body that has the right shape or nearly so."""
    answer = await house.client.post("/api/orders", content=json.dumps(content), headers=JSON)
    told = problem(answer, 422, "unusable-fields")
    first = told["errors"][0]
    assert told["detail"].startswith(f"{first['field']}: {first['reason']}")
    assert await nothing_stored(house)
    faults: list[dict[str, str]] = told["errors"]
    return faults


# --- orders whose fields cannot be used -------------------------------------------------------------


async def test_an_unknown_product_is_told_which_ones_there_are(house: House) -> None:
    (fault,) = await refused(house, body(items=[LINE, line(product="unobtainium")]))
    assert fault["field"] == "items[1].product"
    assert "'unobtainium'" in fault["reason"]
    for product in PLANT.products:
        assert product.id in fault["reason"]


async def test_all_faults_are_told_at_once(house: House) -> None:
    faults = await refused(
        house, body(items=[line(product="one"), line(product="two")], due_at="2020-01-01T00:00Z")
    )
    assert [fault["field"] for fault in faults] == ["items[0].product", "items[1].product", "due_at"]


@pytest.mark.parametrize(
    "quantity",
    [0, -1, MAX_QUANTITY + 1, 2**63, 10**400, "5", "", True, False, 5.0, 5.5, None, [], {}, MISSING],
    ids=str,
)
async def test_a_quantity_that_is_no_number_of_pieces_is_refused(house: House, quantity: Any) -> None:
    (fault,) = await refused(house, body(items=[LINE, line(quantity=quantity)]))
    assert fault["field"] == "items[1].quantity"


@pytest.mark.parametrize("number", ["NaN", "Infinity", "-Infinity", "1e999"])
async def test_a_quantity_that_json_does_not_know_is_refused(house: House, number: str) -> None:
    written = json.dumps(body()).replace("5", number)
    answer = await house.client.post("/api/orders", content=written, headers=JSON)
    assert problem(answer, 422, "unusable-fields")["errors"][0]["field"] == "items[0].quantity"
    assert await nothing_stored(house)


@pytest.mark.parametrize(
    "items",
    [[], [LINE] * (MAX_ITEMS + 1), None, MISSING, LINE, "items", 5],
    ids=["none", "too many", "null", "missing", "one that is no list", "text", "a number"],
)
async def test_an_order_has_some_items_and_not_too_many(house: House, items: Any) -> None:
    (fault,) = await refused(house, body(items=items))
    assert fault["field"] == "items"


@pytest.mark.parametrize(
    "product", ["", " ", "a b", "ä", "9gears", "x" * 33, "\u0000", "\ud800", 5, None, MISSING], ids=repr
)
async def test_a_product_is_named_by_an_id(house: House, product: Any) -> None:
    (fault,) = await refused(house, body(items=[line(product=product)]))
    assert fault["field"] == "items[0].product"


@pytest.mark.parametrize(
    "customer",
    [
        "",
        "   ",
        "\t",
        "a\nb",
        "a\u0000b",
        "a\u007f",
        "a\u202eb",
        "\u2066a",
        "x" * 201,
        "\ud800",
        5,
        None,
        [],
        MISSING,
    ],
    ids=repr,
)
async def test_a_customer_has_a_name_of_one_line(house: House, customer: Any) -> None:
    (fault,) = await refused(house, body(customer=customer))
    assert fault["field"] == "customer"


@pytest.mark.parametrize("reference", ["", "   ", "a\nb", "x" * 201, 5], ids=repr)
async def test_a_reference_is_one_line_too(house: House, reference: Any) -> None:
    (fault,) = await refused(house, body(reference=reference))
    assert fault["field"] == "reference"


@pytest.mark.parametrize("release", ["true", 1, 0, None, "no"], ids=repr)
async def test_whether_to_release_is_yes_or_no(house: House, release: Any) -> None:
    (fault,) = await refused(house, body(release=release))
    assert fault["field"] == "release"


@pytest.mark.parametrize(
    ("due_at", "words"),
    [
        ("2030-03-17T17:46:39Z", "it is past: here it is 2030-03-17T17:46:40+00:00"),
        ("2030-03-17T17:46:40Z", "it is past"),
        ("0001-01-01T00:00:00Z", "it is past"),
        ("2100-01-01T00:00:00Z", "before 2100"),
        ("9999-12-31T23:59:59Z", "before 2100"),
        ("2030-03-17T20:00:00", "time zone"),
        ("2030-03-17", "time zone"),
        ("tomorrow", "no ISO 8601 time"),
        ("2030-13-01T00:00:00Z", "no ISO 8601 time"),
        ("2030-02-30T00:00:00Z", "no ISO 8601 time"),
        ("", "no ISO 8601 time"),
        ("2030-03-17T20:00:00+99:00", "no ISO 8601 time"),
        ("9999-12-31T23:59:59-12:00", "out of the calendar"),
        ("0001-01-01T00:00:00+12:00", "out of the calendar"),
        (1_900_003_600, "as text"),
        (True, "as text"),
        ([], "as text"),
    ],
    ids=repr,
)
async def test_a_due_time_is_a_moment_to_come_with_its_zone(house: House, due_at: Any, words: str) -> None:
    (fault,) = await refused(house, body(due_at=due_at))
    assert fault["field"] == "due_at"
    assert words in fault["reason"]


@pytest.mark.parametrize(
    ("content", "field"),
    [
        (body(colour="red"), "colour"),
        (body(items=[line(colour="red")]), "items[0].colour"),
        (body(id="O-1"), "id"),
    ],
    ids=["of an order", "of an item", "an id"],
)
async def test_a_field_that_nobody_knows_is_refused(house: House, content: Any, field: str) -> None:
    (fault,) = await refused(house, content)
    assert fault["field"] == field
    assert "no such field" in fault["reason"]


@pytest.mark.parametrize("content", [[], [LINE], "order", 5, True, None], ids=repr)
async def test_a_body_that_is_no_object_is_refused(house: House, content: Any) -> None:
    (fault,) = await refused(house, content)
    assert fault["field"] == "body"


async def test_no_more_faults_are_told_than_a_person_reads(house: House) -> None:
    assert len(await refused(house, body(items=[{str(i): 0 for i in range(200)}]))) == 50


# --- bodies that cannot be read ---------------------------------------------------------------------


@pytest.mark.parametrize(
    ("content", "kind"),
    [
        (b"{", "not-json"),
        (b"customer=Muster", "not-json"),
        (b"{'customer': 'Muster'}", "not-json"),
        (b'{"customer": "Muster",}', "not-json"),
        (b"\xff\xfe\x00", "bad-request"),
        (b'{"customer": "\xe4"}', "bad-request"),
        (b"[" * 30_000, "bad-request"),
        (b'{"customer": ' + b"9" * 5000 + b"}", "bad-request"),
    ],
    ids=["cut off", "a form", "single quotes", "a comma", "no text", "latin-1", "nested", "a long number"],
)
async def test_a_body_that_is_not_json_is_refused(house: House, content: bytes, kind: str) -> None:
    answer = await house.client.post("/api/orders", content=content, headers=JSON)
    told = problem(answer, 400, kind)
    assert "JSON" in told["title"] + told["detail"]
    assert "UTF-8" in told["detail"]
    assert await nothing_stored(house)


async def test_an_empty_body_is_refused(house: House) -> None:
    told = problem(await house.client.post("/api/orders", content=b"", headers=JSON), 422, "unusable-fields")
    assert told["errors"] == [{"field": "body", "reason": "it is missing", "code": "missing"}]
    assert await nothing_stored(house)


@pytest.mark.parametrize(
    "kind",
    [None, "", "text/plain", "application/x-www-form-urlencoded", "multipart/form-data; boundary=x", "json"],
)
async def test_a_body_that_is_not_called_json_is_refused(house: House, kind: str | None) -> None:
    headers = {} if kind is None else {"Content-Type": kind}
    answer = await house.client.post("/api/orders", content=json.dumps(body()), headers=headers)
    told = problem(answer, 415, "not-called-json")
    assert "send application/json" in told["detail"]
    assert await nothing_stored(house)


@pytest.mark.parametrize("kind", ["application/json; charset=utf-8", "application/vnd.dray+json"])
async def test_json_may_be_called_by_its_other_names(url: str, kind: str) -> None:
    async with gateway(url) as house:
        answer = await house.client.post(
            "/api/orders", content=json.dumps(body()), headers={"Content-Type": kind}
        )
        assert answer.status_code == 201


@pytest.mark.parametrize("announced", [True, False], ids=["announced", "in pieces"])
async def test_a_body_that_is_too_large_is_refused(url: str, announced: bool) -> None:
    async def pieces() -> AsyncIterator[bytes]:
        for _ in range(5):
            yield b" " * 1000

    async with gateway(url, body_limit_bytes=4096) as house:
        content = b" " * 5000 if announced else pieces()
        answer = await house.client.post("/api/orders", content=content, headers=JSON)
        told = problem(answer, 413, "body-too-large")
        assert "4096 bytes" in told["detail"]
        assert answer.headers["connection"] == "close"
        assert answer.headers["x-content-type-options"] == "nosniff"
        assert await nothing_stored(house)


async def test_only_a_file_may_be_as_large_as_a_file(house: House) -> None:
    content = json.dumps(body()).encode().ljust(BODY_BYTES + 1)
    told = problem(
        await house.client.post("/api/orders", content=content, headers=JSON), 413, "body-too-large"
    )
    assert f"{BODY_BYTES} bytes" in told["detail"]
    csv = b'{"csv": "", "dry_run": true}'.ljust(BODY_BYTES + 1)
    answer = await house.client.post("/api/orders/import", content=csv, headers=JSON)
    assert answer.status_code == 200


async def test_a_body_as_large_as_allowed_is_read(url: str) -> None:
    async with gateway(url, body_limit_bytes=4096) as house:
        content = json.dumps(body()).encode().ljust(4096)
        answer = await house.client.post("/api/orders", content=content, headers=JSON)
        assert answer.status_code == 201


@pytest.mark.parametrize(
    "origin", ["http://evil.test", "null", "http://dray.test.evil.test", "http://dray.test:81", "http://["]
)
async def test_a_page_of_another_site_cannot_place_an_order(house: House, origin: str) -> None:
    answer = await house.client.post("/api/orders", json=body(), headers={"Origin": origin})
    problem(answer, 403, "other-origin")
    assert await nothing_stored(house)


async def test_our_own_page_can_place_an_order(url: str) -> None:
    async with gateway(url) as house:
        answer = await house.client.post("/api/orders", json=body(), headers={"Origin": "http://dray.test"})
        assert answer.status_code == 201


async def test_a_choice_of_nothing_is_not_named_among_the_choices(house: House) -> None:
    told = problem(await house.client.get("/api/audit?result=odd"), 422, "unusable-fields")
    assert told["errors"][0]["reason"] == "it is none of done, refused, failed"
