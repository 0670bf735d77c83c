"""Texts that JSON, addresses and forms can hold and a database cannot, or that are longer than anybody writes: refused, wherever they stand."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any

import pytest
from answers import problem
from gateway_kit import House

from dray.gateway.access.principal import Scope
from dray.gateway.access.rules import RULES
from dray.gateway.http.responses import write_cursor

pytestmark = pytest.mark.anyio

ODD = ["a\0b", "\0", "\ud800", "9" * 5_000, "O-" * 5_000, "\u202e"]
"""A NUL, which PostgreSQL has in no text; half a character; more digits than Python makes a number of; text that is slow to look through."""

STREAM = "/api/stream"


AT_LEAST = {
    ("POST", "/api/orders"),
    ("PATCH", "/api/orders/{order}"),
    ("POST", "/api/transports"),
    ("POST", "/api/schedules"),
    ("PATCH", "/api/schedules/{schedule}"),
    ("POST", "/api/people"),
    ("POST", "/api/keys"),
    ("POST", "/api/machines/{machine}/commands"),
    ("POST", "/api/stations/{station}/commands"),
}
"""Routes whose bodies are tried, whatever becomes of the document."""


def filled(template: str, chunk: str) -> str:
    return "/".join(chunk if part.startswith("{") else part for part in template.split("/"))


@pytest.mark.parametrize("chunk", ["%00", "a%00b", "%ED%A0%80", "%FF", "9" * 5_000])
async def test_no_route_fails_at_odd_text_in_its_address(house: House, chunk: str) -> None:
    failed = []
    for method, template in RULES:
        if "{" in template:
            answer = await house.client.request(method, filled(template, chunk), json={})
            failed += [(method, template, answer.status_code)] if answer.status_code >= 500 else []
    assert not failed, [each[:3] for each in failed]


async def test_a_nul_in_an_address_is_told_as_what_is_no_character(house: House) -> None:
    answer = await house.client.get("/api/orders/%00")
    assert (answer.status_code, answer.json()["type"]) == (404, "urn:dray:problem:unknown-order")
    assert answer.json()["instance"] == "/api/orders/\ufffd"


@pytest.mark.parametrize("value", ["%00", "%FF", "9" * 5_000])
async def test_no_route_fails_at_odd_text_in_its_question(house: House, value: str) -> None:
    paths, failed = house.app.openapi()["paths"], []
    for method, template in RULES:
        operation = paths.get(template, {}).get(method.lower(), {})
        for parameter in operation.get("parameters", ()):
            if parameter["in"] == "query" and template != STREAM:
                asked = f"{filled(template, 'unknown')}?{parameter['name']}={value}"
                answer = await house.client.request(method, asked)
                failed += [(method, asked[:80], answer.status_code)] if answer.status_code >= 500 else []
    assert not failed, [each[:3] for each in failed]


@pytest.mark.parametrize(
    ("path", "position"),
    [
        ("/api/tasks", (1.0, "a\0b")),
        ("/api/tasks/history", (1.0, "a\0b")),
        ("/api/transports", (1.0, "a\0b")),
        ("/api/orders", (1.0, "a\0b")),
        ("/api/orders?sort=customer", ("a\0b", "O-1")),
        ("/api/machines", ("a\0b",)),
    ],
)
async def test_a_cursor_with_a_character_that_no_database_holds_is_refused(
    house: House, path: str, position: tuple[str | float, ...]
) -> None:
    answer = await house.client.get(path, params={"cursor": write_cursor(*position)})
    told = problem(answer, 422, "unusable-fields")
    assert told["errors"][0]["field"] in ("cursor", "sort")


def changed(example: Any, odd: str) -> Iterator[Any]:
    """The example with one of its texts, or one of the names in it, made odd."""
    if isinstance(example, str):
        yield odd
    elif isinstance(example, Mapping):
        for name, value in example.items():
            yield from ({**example, name: inner} for inner in changed(value, odd))
            yield {**example, odd: value}
    elif isinstance(example, list):
        for at, value in enumerate(example):
            yield from ([*example[:at], inner, *example[at + 1 :]] for inner in changed(value, odd))


@pytest.mark.slow
@pytest.mark.parametrize("odd", ODD[1:4], ids=["nul", "surrogate", "digits"])
async def test_no_route_fails_at_odd_text_in_its_body(house: House, odd: str) -> None:
    document, failed = house.app.openapi(), []
    tried: set[tuple[str, str]] = set()
    schemas = document["components"]["schemas"]
    for method, template in RULES:
        operation = document["paths"].get(template, {}).get(method.lower(), {})
        content = operation.get("requestBody", {}).get("content", {}).get("application/json")
        if content is None:
            continue
        examples = [each["value"] for each in content.get("examples", {}).values()]
        if "$ref" in content["schema"]:
            examples += schemas[content["schema"]["$ref"].rpartition("/")[2]].get("examples", [])
        assert examples, f"{method} {template}: give its body an example"
        for body in (json.dumps(each) for example in examples for each in changed(example, odd)):
            tried.add((method, template))
            answer = await house.client.request(
                method,
                filled(template, "unknown"),
                content=body,
                headers={"Content-Type": "application/json", "If-Match": "*"},
            )
            failed += [(method, template, body[:80])] if answer.status_code >= 500 else []
    assert not failed, [each[:3] for each in failed]
    assert tried >= AT_LEAST


@pytest.mark.parametrize("field", ["item", "quantity", "way", "key"])
@pytest.mark.parametrize("odd", ODD, ids=["nul-inside", "nul", "surrogate", "digits", "orders", "override"])
async def test_the_page_of_a_call_key_does_not_fail_at_odd_text(house: House, field: str, odd: str) -> None:
    _, header = await house.key(Scope.TRANSPORTS_CALL, places="M8")
    token = header["Authorization"].removeprefix("Bearer ")
    form = {"item": "shaft", "quantity": "40", "way": "bring", "key": "k"} | {field: odd}
    body = "&".join(
        f"{name}=" + "".join(f"%{byte:02X}" for byte in value.encode("utf-8", "surrogatepass"))
        for name, value in form.items()
    )
    answer = await house.visitor().post(
        f"/call/{token}", content=body, headers={"Content-Type": "application/x-www-form-urlencoded"}
    )
    assert answer.status_code in (303, 422), answer.text
