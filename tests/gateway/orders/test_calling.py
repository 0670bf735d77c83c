"""The key of one place, and its page: a plain form by which something is brought there or taken away, and nothing else."""

from __future__ import annotations

import asyncio
import re
from string import Formatter
from typing import Any

import httpx
import pytest
from answers import problem
from gateway_kit import HOME, NOW_S, House
from heartbeats import events, machine_heartbeat

from dray.errors import UnavailableError
from dray.gateway.access.principal import Scope
from dray.gateway.calling.code import drawn
from dray.gateway.calling.texts import REFUSALS, TEXTS
from dray.gateway.http import fault_codes
from dray.messages import (
    THING,
    BufferLevel,
    Role,
    StrandedGoods,
    TaskBrief,
    Transport,
    TransportCancelled,
    TransportOrdered,
    TransportState,
)
from dray.messages.fact import TaskOpened, TransportProgressed
from dray.store.orders.transports import TransportRow, Transports

pytestmark = pytest.mark.anyio

PATH = "/api/transports"


async def key_of(house: House, *scopes: Scope, **fields: Any) -> tuple[str, dict[str, str]]:
    """A key's token, and the header that shows it."""
    _, header = await house.key(*scopes, **fields)
    return header["Authorization"].removeprefix("Bearer "), header


async def opened(house: House, token: str, **query: str) -> httpx.Response:
    return await house.visitor().get(f"/call/{token}", params=query, headers={"Accept-Language": "en"})


async def pressed(house: House, token: str, page: str, way: str, language: str = "en") -> httpx.Response:
    """Press a button of the page, with what the form holds."""
    hidden = dict(re.findall(r'<input type="hidden" name="(\w+)" value="([^"]*)">', page))
    header = {"Accept-Language": language}
    return await house.visitor().post(f"/call/{token}", data=hidden | {"way": way}, headers=header)


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
    reason = "open calls of this key: 1, and it may have no more; cancel one, or wait until one has ended"
    assert f'role="alert">Not called: {reason}</p>' in second.text, "one reason is enough"
    german = await pressed(
        house, token, (await opened(house, token, item="shaft")).text, "bring", language="de"
    )
    assert "Nicht gerufen: offene Rufe dieses Schlüssels: 1, mehr darf er nicht haben." in german.text
    assert len((await house.visitor(**header).get(PATH)).json()["items"]) == 1


@pytest.mark.parametrize("language", list(REFUSALS))
def test_each_refusal_of_the_page_fills_in_what_its_reason_has(language: str) -> None:
    def fields(text: str) -> set[str]:
        return {field for _, field, _, _ in Formatter().parse(text) if field is not None}

    reasons = {**fault_codes.TEXTS, **fault_codes.WORDS}
    assert REFUSALS.keys() == TEXTS.keys() - {"en"}
    assert REFUSALS[language].keys() == REFUSALS["de"].keys()
    for code, words in REFUSALS[language].items():
        if code in reasons:
            assert fields(words) <= fields(reasons[code]), code
        else:
            assert code == "too-many-transports"
            assert not fields(words)


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
    assert "<button" not in first.text.partition("<details")[0]
    assert first.headers["Cache-Control"] == "no-store"
    assert first.headers["Referrer-Policy"] == "same-origin"
    second = await opened(house, token, item="shaft")
    assert house.bus.sent_to("M8", TransportOrdered) == []
    for _ in range(2):  # The same form, sent again by an impatient thumb.
        done = await pressed(house, token, second.text, "bring")
        assert (done.status_code, done.headers["Location"]) == (303, f"/call/{token}#called")
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


@pytest.mark.parametrize(("level", "away"), [(33, 33), (90, 40)])
async def test_no_more_is_taken_away_than_is_there(house: House, level: int, away: int) -> None:
    stock = (BufferLevel(item="shaft", level=level, on_order=0, capacity=120, reorder_point=20),)
    await house.say([machine_heartbeat("M8", buffers=stock)])
    token, header = await key_of(house, Scope.TRANSPORTS_CALL, places="M8")
    page = (await opened(house, token, item="shaft")).text
    assert f"Take {away} away" in page
    await pressed(house, token, page, "take")
    [row] = (await house.visitor(**header).get(PATH)).json()["items"]
    assert (row["from"], row["quantity"]) == ("M8", away)


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


async def test_a_touch_that_comes_twice_at_once_is_one_call_and_no_refusal(house: House) -> None:
    token, _ = await key_of(house, Scope.TRANSPORTS_CALL, places="M8")
    page = (await opened(house, token, item="shaft")).text
    answers = await asyncio.gather(*(pressed(house, token, page, "bring") for _ in range(6)))
    assert {answer.status_code for answer in answers} == {303}
    assert len(house.bus.sent_to("M8", TransportOrdered)) == 1


async def test_the_second_of_two_touches_shows_the_refusal_of_the_first(house: House) -> None:
    token, header = await key_of(house, Scope.TRANSPORTS_CALL, places="M8", open_max=1)
    page = (await opened(house, token, item="shaft")).text
    assert (await pressed(house, token, page, "take")).status_code == 303
    answers = await asyncio.gather(*(pressed(house, token, page, "bring") for _ in range(6)))
    for answer in answers:
        assert answer.status_code == 422
        assert "it may have no more" in answer.text
    assert house.bus.sent_to("M8", TransportOrdered) == []
    assert len((await house.visitor(**header).get(PATH)).json()["items"]) == 1


async def test_a_touch_whose_first_request_failed_is_done_by_the_second(
    house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    token, _ = await key_of(house, Scope.TRANSPORTS_CALL, places="M8")
    page = (await opened(house, token, item="shaft")).text
    add, failures = Transports.add, [UnavailableError("the database", "gone", "wait")]

    async def failing(rows: Transports, row: TransportRow) -> bool:
        if failures:
            raise failures.pop()
        return await add(rows, row)

    monkeypatch.setattr(Transports, "add", failing)
    answers = await asyncio.gather(*(pressed(house, token, page, "bring") for _ in range(2)))
    assert sorted(answer.status_code for answer in answers) == [303, 503]
    assert len(house.bus.sent_to("M8", TransportOrdered)) == 1


async def test_a_page_that_was_gone_back_to_and_sent_with_something_else_is_another_call(
    house: House,
) -> None:
    token, header = await key_of(house, Scope.TRANSPORTS_CALL, places="M8")
    page = (await opened(house, token, item="shaft")).text
    for way in ("bring", "take"):
        assert (await pressed(house, token, page, way)).status_code == 303
    rows = (await house.visitor(**header).get(PATH)).json()["items"]
    assert sorted(row["from"] == "M8" for row in rows) == [False, True]


async def test_the_key_of_another_place_calls_nothing_off_and_sees_nothing_of_it(house: House) -> None:
    token, _ = await key_of(house, Scope.TRANSPORTS_CALL, places="M8")
    page = (await opened(house, token, item="shaft")).text
    await pressed(house, token, page, "bring")
    [asked] = house.bus.sent_to("M8", TransportOrdered)
    other, header = await key_of(house, Scope.TRANSPORTS_CALL, places="M9")
    assert (await house.visitor().post(f"/call/{other}/{asked.transport}/cancel", data={})).status_code == 303
    assert house.bus.sent_to("M8", TransportCancelled) == []
    assert "Call off" not in (await opened(house, other)).text
    visitor = house.visitor(**header)
    assert (await visitor.get(f"{PATH}/{asked.transport}")).status_code == 404
    assert (await visitor.post(f"{PATH}/{asked.transport}/cancel")).status_code == 404


# --- things without master data ---

BOX = {"thing": "pump housing for Meier", "place": "S3", "ability": "tote", "key": "k1"}


async def asked_for(house: House, token: str, **fields: str) -> httpx.Response:
    return await house.visitor().post(f"/call/{token}", data=BOX | fields, headers={"Accept-Language": "en"})


@pytest.mark.parametrize(("way", "ends"), [("bring", ("S3", "M8")), ("take", ("M8", "S3"))])
async def test_a_thing_is_called_for_without_a_script_once(
    house: House, way: str, ends: tuple[str, str]
) -> None:
    token, header = await key_of(house, Scope.TRANSPORTS_CALL, places="M8")
    page = (await opened(house, token)).text
    form = page[page.index('<details class="call-thing"') :]
    assert set(re.findall(r'name="(\w+)"', form[: form.index("</details>")])) >= {
        "thing",
        "place",
        "key",
        "way",
    }
    assert '<option value="M8"' not in page
    for _ in range(2):
        answer = await asked_for(house, token, way=way)
        assert (answer.status_code, answer.headers["Location"]) == (303, f"/call/{token}#called")
    [asked] = house.bus.sent_to(ends[1], TransportOrdered)
    assert (asked.item, asked.quantity, asked.source, asked.ability) == (THING, 1, ends[0], "tote")
    [row] = (await house.visitor(**header).get(PATH)).json()["items"]
    assert (row["thing"], row["from"], row["to"]) == (BOX["thing"], *ends)
    assert "pump housing for Meier" in (await opened(house, token)).text


@pytest.mark.parametrize(
    "fields",
    [
        {"thing": " "},
        {"place": ""},
        {"place": "M8"},
        {"place": "nowhere"},
        {"ability": "magic"},
        {"thing": "a\u202eb"},
    ],
)
async def test_a_thing_that_cannot_be_is_refused_in_words_and_what_was_written_stays(
    house: House, fields: dict[str, str]
) -> None:
    token, _ = await key_of(house, Scope.TRANSPORTS_CALL, places="M8")
    answer = await asked_for(house, token, way="bring", **fields)
    assert answer.status_code == 422
    assert 'role="alert"' in answer.text
    if "thing" not in fields:
        assert 'value="pump housing for Meier"' in answer.text
        assert '<details class="call-thing" open>' in answer.text
    assert house.bus.sent_to("M8", TransportOrdered) == []


async def test_a_key_for_named_materials_calls_for_no_things(house: House) -> None:
    token, _ = await key_of(house, Scope.TRANSPORTS_CALL, places="M8", items="shaft")
    assert "call-thing" not in (await opened(house, token)).text
    assert (await asked_for(house, token, way="bring")).status_code == 422


async def test_what_people_write_is_text_on_the_page(house: House) -> None:
    token, _ = await key_of(house, Scope.TRANSPORTS_CALL, places="M8")
    assert (await asked_for(house, token, way="bring", thing="<b>\"x'")).status_code == 303
    page = (await opened(house, token)).text
    assert "<b>" not in page
    assert "&lt;b&gt;" in page


@pytest.mark.parametrize(
    ("node", "handed", "told"),
    [
        ("c2", "", "on board of ATV2, which has failed at c2"),
        ("", "", "on board of ATV2, which has failed"),
        ("c2", "b2", "it is handed over at b2"),
    ],
)
async def test_the_page_tells_where_a_thing_is_whose_vehicle_has_failed(
    house: House, node: str, handed: str, told: str
) -> None:
    token, _ = await key_of(house, Scope.TRANSPORTS_CALL, places="M8")
    await asked_for(house, token, way="bring")
    [asked] = house.bus.sent_to("M8", TransportOrdered)
    task = f"{asked.transport}-1"
    work = Transport(THING, 1, ("S3",), "M8", "tote")
    aboard = TransportProgressed(
        asked.transport, TransportState.ON_BOARD, THING, 1, "S3", "M8", task=task, carrier="ATV2"
    )
    opened_task = TaskOpened(task, 1, Role.PRIMARY, 1, work, 20.0, 900.0, 105.0)
    await house.say(events("M8", opened_task, aboard))
    left = StrandedGoods(atv="ATV2", node=node, until_s=NOW_S + 800.0, handed_at=handed)
    brief = TaskBrief(
        task=task,
        epoch=1,
        item=THING,
        quantity=1,
        source="S3",
        destination="M8",
        deadline_s=900.0,
        primary="ATV2",
        stranded=left,
    )
    await house.say([machine_heartbeat("M8", tasks=(brief,))])
    assert told in (await opened(house, token)).text
