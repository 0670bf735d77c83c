"""Wherever it is sent, and whatever is asked for, the answer is a problem that says what, where and what to do."""

from __future__ import annotations

import httpx
import pytest
from answers import problem
from gateway_kit import House

from dray.gateway.http.responses import CURSOR_MOST, write_cursor

pytestmark = pytest.mark.anyio


@pytest.fixture
def house(quiet_house: House) -> House:
    """What is refused changes nothing, so one gateway refuses it all."""
    return quiet_house


# --- addresses and methods --------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("path", "kind"),
    [
        ("/api/orders/O-1", "unknown-order"),
        ("/api/orders/%FF", "unknown-order"),
        ("/api/orders/" + "x" * 5000, "unknown-order"),
        ("/api/orders/' OR 1=1 --", "unknown-order"),
        ("/api/machines/M99", "unknown-machine"),
        ("/api/atvs/ATV99", "unknown-atv"),
        ("/api/tasks/T99", "unknown-task"),
        ("/api/track/guess", "unknown-tracking-page"),
    ],
)
async def test_an_id_that_nobody_has_is_not_found(house: House, path: str, kind: str) -> None:
    told = problem(await house.client.get(path), 404, kind)
    assert len(told["detail"]) < 500


@pytest.mark.parametrize(
    "path",
    ["/api", "/api/", "/api/nothing", "/nothing", "/api/orders/", "/api/orders/O-1/nothing", "/static/no.js"],
)
async def test_an_address_where_nothing_is_is_not_found(house: House, path: str) -> None:
    told = problem(await house.client.get(path), 404, "not-found")
    assert path in told["detail"]
    assert "/api/docs" in told["detail"]


@pytest.mark.parametrize(
    ("method", "path", "allowed"),
    [
        ("PUT", "/api/orders", "GET, POST"),
        ("DELETE", "/api/orders/O-1", "GET, PATCH"),
        ("GET", "/api/orders/O-1/cancel", "POST"),
        ("PATCH", "/api/atvs/ATV1/commands", "POST"),
        ("POST", "/api/machines", "GET"),
        ("POST", "/healthz", "GET"),
        ("POST", "/", "GET"),
        ("POST", "/static/icon.svg", "GET"),
        ("TRACE", "/api/orders", "GET, POST"),
    ],
)
async def test_a_method_that_an_address_does_not_know_is_refused(
    house: House, method: str, path: str, allowed: str
) -> None:
    answer: httpx.Response = await house.client.request(method, path)
    told = problem(answer, 405, "method-not-allowed")
    assert answer.headers["allow"] == allowed
    assert told["detail"] == f"{path} does not know {method}; use {allowed}"


# --- questions --------------------------------------------------------------------------------------


LISTS = ["orders", "products", "machines", "atvs", "tasks", "events"]


@pytest.mark.parametrize("noun", LISTS)
@pytest.mark.parametrize("limit", ["0", "-1", "501", "ten", "1.5", "", "9" * 30])
async def test_a_page_has_between_1_and_500_items(house: House, noun: str, limit: str) -> None:
    told = problem(await house.client.get(f"/api/{noun}", params={"limit": limit}), 422, "unusable-fields")
    assert told["errors"][0]["field"] == "limit"


@pytest.mark.parametrize("noun", LISTS)
@pytest.mark.parametrize(
    "cursor",
    [
        "",
        "nonsense",
        "ä",
        "!!!!",
        "x" * (CURSOR_MOST + 1),
        write_cursor(),
        write_cursor("a", "b", "c"),
        write_cursor(10**30),
        write_cursor(-1),
        write_cursor(1e308, 5),
        write_cursor(1.0, "\0"),
        write_cursor("\0"),
        write_cursor("a\0", "b"),
    ],
)
async def test_a_cursor_that_is_not_from_this_list_is_refused(house: House, noun: str, cursor: str) -> None:
    told = problem(await house.client.get(f"/api/{noun}", params={"cursor": cursor}), 422, "unusable-fields")
    assert told["errors"][0]["field"] == "cursor"


@pytest.mark.parametrize(
    ("query", "field"),
    [
        ("/api/orders?status=lost", "status[0]"),
        ("/api/orders?status=stored&status=", "status[1]"),
        ("/api/orders?reference=%00", "reference"),
        ("/api/orders?customer=" + "x" * 201, "customer"),
        ("/api/orders?updated_since=yesterday", "updated_since"),
        ("/api/orders?updated_since=1900000000", "updated_since"),
        ("/api/orders?due_before=2030-01-01T00:00:00", "due_before"),
        ("/api/orders?due_before=0001-01-01T00:00:00%2B14:00", "due_before"),
        ("/api/tasks?state=lost", "state[0]"),
        ("/api/events?since=-1", "since"),
        ("/api/events?since=x", "since"),
        ("/api/events?since=99999999999999999999", "since"),
        ("/api/events?since=1&newest_first=true", "since"),
        ("/api/events?newest_first=maybe", "newest_first"),
        ("/api/events?task=" + "x" * 129, "task"),
        ("/api/events?task=%00", "task"),
        ("/api/audit?who=%00", "who"),
        ("/api/events?kind=" + "x" * 129, "kind[0]"),
        ("/api/events?" + "&".join(["agent=a"] * 51), "agent"),
    ],
)
async def test_a_question_that_cannot_be_answered_is_refused(house: House, query: str, field: str) -> None:
    told = problem(await house.client.get(query), 422, "unusable-fields")
    assert told["errors"][0]["field"] == field
