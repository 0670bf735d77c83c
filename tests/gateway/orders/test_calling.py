"""The key of one place, and its page: a plain form by which something is brought there or taken away, and nothing else."""

from __future__ import annotations

import re
from typing import Any

import httpx
import pytest
from answers import problem
from gateway_kit import HOME, NOW_S, House

from dray.gateway.access.principal import Scope
from dray.gateway.calling.code import drawn
from dray.gateway.calling.texts import TEXTS
from dray.messages import TransportOrdered

pytestmark = pytest.mark.anyio

PATH = "/api/transports"


async def key_of(house: House, *scopes: Scope, **fields: Any) -> tuple[str, dict[str, str]]:
    """A key's token, and the header that shows it."""
    _, header = await house.key(*scopes, **fields)
    return header["Authorization"].removeprefix("Bearer "), header


async def opened(house: House, token: str, **query: str) -> httpx.Response:
    return await house.visitor().get(f"/call/{token}", params=query, headers={"Accept-Language": "en"})


async def pressed(house: House, token: str, page: str, way: str) -> httpx.Response:
    """Press a button of the page, with what the form holds."""
    hidden = dict(re.findall(r'<input type="hidden" name="(\w+)" value="([^"]*)">', page))
    return await house.visitor().post(f"/call/{token}", data=hidden | {"way": way})


async def test_a_key_of_a_place_calls_for_that_place_only(house: House) -> None:
    _, header = await key_of(house, Scope.TRANSPORTS_CALL, places="M8")
    visitor = house.visitor(**header)
    brought = await visitor.post(PATH, json={"to": "M8", "item": "shaft", "quantity": 40})
    assert brought.status_code == 201, brought.text
    elsewhere = await visitor.post(PATH, json={"from": "S3", "to": "M9", "item": "shaft", "quantity": 40})
    told = problem(elsewhere, 403, "beyond-key")
    assert [(error["field"], error["reason"]) for error in told["errors"]] == [
        ("to", "this key calls for M8 only: it must be one of both places")
    ]


async def test_the_page_shows_what_its_key_calls_for_and_says_when_it_has_called_enough(house: House) -> None:
    token, header = await key_of(house, Scope.TRANSPORTS_CALL, places="M8", items="shaft", open_max=1)
    assert set(re.findall(r"[?]item=(\w+)", (await opened(house, token)).text)) == {"shaft"}
    page = (await opened(house, token, item="shaft")).text
    assert (await pressed(house, token, page, "bring")).status_code == 303
    second = await pressed(house, token, (await opened(house, token, item="shaft")).text, "bring")
    assert second.status_code == 422
    assert "1 calls of this key may be open at once, and are" in second.text
    assert len((await house.visitor(**header).get(PATH)).json()["items"]) == 1


@pytest.mark.parametrize(("named", "other"), [("to", "from"), ("from", "to")])
async def test_the_place_that_is_not_named_is_the_nearest_storage_that_keeps_it(
    house: House, named: str, other: str
) -> None:
    answer = (await house.client.post(PATH, json={named: "M8", "item": "shaft", "quantity": 40})).json()
    plant = house.projection.site.plant
    x_m, y_m = plant.position_of("M8")

    def away_m(storage: str) -> float:
        there = plant.position_of(storage)
        return (there[0] - x_m) ** 2 + (there[1] - y_m) ** 2

    assert answer[other] == min(plant.storages_of("shaft"), key=away_m)


async def test_one_place_must_be_named(house: House) -> None:
    answer = await house.client.post(PATH, json={"item": "shaft", "quantity": 40})
    assert [error["field"] for error in answer.json()["errors"]] == ["to"]


async def test_two_touches_without_a_script_call_once_and_the_page_tells_how_far_it_is(house: House) -> None:
    token, _ = await key_of(house, Scope.TRANSPORTS_CALL, places="M8", expires_at_s=NOW_S + 86_400.0)
    first = await opened(house, token)
    assert first.status_code == 200
    assert "M8" in first.text
    assert "<button" not in first.text
    assert first.headers["Cache-Control"] == "no-store"
    second = await opened(house, token, item="shaft")
    assert house.bus.sent_to("M8", TransportOrdered) == []
    for _ in range(2):  # The same form, sent again by an impatient thumb.
        done = await pressed(house, token, second.text, "bring")
        assert (done.status_code, done.headers["Location"]) == (303, f"/call/{token}")
    [asked] = house.bus.sent_to("M8", TransportOrdered)
    assert (asked.item, asked.quantity) == ("shaft", 40)
    shown = (await opened(house, token)).text
    assert shown.count("Call off") == 1
    off = await house.visitor().post(f"/call/{token}/{asked.transport}/cancel", data={})
    assert off.status_code == 303
    assert "being called off" in (await opened(house, token)).text
    actions = [(line.action, line.result) for line in await house.audit()]
    assert actions[0] == ("transport.cancel", "done")
    assert actions.count(("transport.call", "done")) == 2


async def test_what_is_taken_away_begins_at_the_place(house: House) -> None:
    token, header = await key_of(house, Scope.TRANSPORTS_CALL, places="M8")
    page = (await opened(house, token, item="shaft")).text
    await pressed(house, token, page, "take")
    [row] = (await house.visitor(**header).get(PATH)).json()["items"]
    assert row["from"] == "M8"


@pytest.mark.parametrize(
    ("scopes", "place"),
    [
        ((Scope.TRANSPORTS_CALL,), ""),
        ((Scope.TRANSPORTS_CALL, Scope.ORDERS_READ), "M8"),
        ((Scope.ORDERS_WRITE,), "M8"),
    ],
)
async def test_no_key_that_may_do_more_opens_a_page(
    house: House, scopes: tuple[Scope, ...], place: str
) -> None:
    token, _ = await key_of(house, *scopes, places=place)
    assert (await opened(house, token)).status_code == 404
    answer = await house.visitor().post(
        f"/call/{token}", data={"item": "shaft", "quantity": "40", "way": "bring"}
    )
    assert answer.status_code == 404
    assert house.bus.sent_to("M8", TransportOrdered) == []


async def test_the_administrators_token_and_a_key_that_was_taken_back_open_none(house: House) -> None:
    token, _ = await key_of(house, Scope.TRANSPORTS_CALL, places="M8", revoked_at_s=NOW_S - 1.0)
    assert (await opened(house, token)).status_code == 404
    assert (await opened(house, "no-key-at-all")).status_code == 404


async def test_a_form_that_means_nothing_is_refused_in_words_and_does_nothing(house: House) -> None:
    token, _ = await key_of(house, Scope.TRANSPORTS_CALL, places="M8")
    for data in ({"item": "gold", "quantity": "4"}, {"item": "shaft", "quantity": "-1"}, {"way": "bring"}):
        answer = await house.visitor().post(f"/call/{token}", data=data)
        assert answer.status_code == 422
        assert 'role="alert"' in answer.text
    assert house.bus.sent_to("M8", TransportOrdered) == []


def test_every_language_says_everything() -> None:
    assert len({frozenset(texts) for texts in TEXTS.values()}) == 1


async def test_a_sign_has_the_address_of_the_page_as_a_code_and_in_letters(house: House) -> None:
    token, _ = await key_of(house, Scope.TRANSPORTS_CALL, places="M8")
    visitor, address = house.visitor(), f"{HOME}/call/{token}"
    sign = await visitor.get(f"/call/{token}/sign", headers={"Accept-Language": "en"})
    assert sign.status_code == 200
    assert "<h1>M8</h1>" in sign.text
    assert "Assembly cell 4" in sign.text
    assert f'<p class="call-address">{address}</p>' in sign.text
    [image] = re.findall(r'<img src="(/call/[^"]+)"', sign.text)
    code = await visitor.get(image)
    assert (code.status_code, code.headers["Content-Type"]) == (200, "image/svg+xml")
    assert code.content == drawn(address)
    assert code.content != drawn(f"{address}/sign")
    assert code.headers["Cache-Control"] == "no-store"
    assert (await visitor.get(f"/call/{token}")).status_code == 200, "what the code leads to"


@pytest.mark.parametrize("what", ["sign", "code.svg"])
async def test_a_key_that_has_no_page_has_no_sign(house: House, what: str) -> None:
    everywhere, _ = await key_of(house, Scope.TRANSPORTS_CALL)
    more, _ = await key_of(house, Scope.TRANSPORTS_CALL, Scope.ORDERS_READ, places="M8")
    for token in (everywhere, more, "dray_nobody"):
        answer = await house.visitor().get(f"/call/{token}/{what}")
        assert answer.status_code == 404
        assert "<svg" not in answer.text


@pytest.mark.parametrize(
    ("scopes", "places", "has"),
    [
        (["transports:call"], ["M8"], True),
        (["transports:call", "transports:call"], ["M8"], True),
        (["transports:call"], ["M8", "M9"], False),
        (["transports:call"], [], False),
        (["transports:call", "orders:read"], ["M8"], False),
        (["orders:read"], [], False),
    ],
)
async def test_who_makes_the_key_of_one_place_is_told_its_page(
    house: House, scopes: list[str], places: list[str], has: bool
) -> None:
    made = await house.client.post("/api/keys", json={"name": "Button", "scopes": scopes, "places": places})
    assert made.status_code == 201, made.text
    token, url = made.json()["token"], made.json()["page_url"]
    assert url == (f"{HOME}/call/{token}" if has else None)
    page = await house.visitor().get(f"/call/{token}")
    assert page.status_code == (200 if has else 404)
