"""A key calls within its limits: at its places, of its materials, no sooner than its priority allows, and only so much at once."""

from __future__ import annotations

import asyncio
from datetime import UTC, datetime
from typing import Any

import httpx
import pytest
from answers import problem
from gateway_kit import House
from heartbeats import events
from wall_clock import NOW_S

from dray.gateway.access.principal import Scope
from dray.gateway.orders import transports as transports_module
from dray.messages import TransportCancelled, TransportOrdered, TransportState
from dray.messages.fact import TransportProgressed

pytestmark = pytest.mark.anyio

PATH = "/api/transports"
DRAFT = {"from": "S3", "to": "M8", "item": "shaft", "quantity": 40}


async def button(house: House, **limits: Any) -> httpx.AsyncClient:
    """Somebody with a key that calls within some limits."""
    _, header = await house.key(Scope.TRANSPORTS_CALL, **limits)
    return house.visitor(**header)


async def called(caller: httpx.AsyncClient, **fields: Any) -> str:
    answer = await caller.post(PATH, json=DRAFT | fields)
    assert answer.status_code == 201, answer.text
    return str(answer.json()["id"])


def in_s(seconds: float) -> str:
    return datetime.fromtimestamp(NOW_S + seconds, UTC).isoformat()


@pytest.mark.parametrize(
    ("limits", "fields", "field", "told"),
    [
        ({"places": "M9 M10"}, {}, "to", "M10, M9"),
        ({"places": "M9"}, {"from": "S3", "to": "M8"}, "to", "M9"),
        ({"items": "bearing housing"}, {}, "item", "bearing, housing"),
        ({"priority": "normal"}, {"priority": "urgent"}, "priority", "normal"),
        ({"priority": "high"}, {"priority": "urgent"}, "priority", "high"),
        ({"priority": "low"}, {"priority": "normal"}, "priority", "low"),
    ],
)
async def test_what_is_beyond_a_key_is_refused_with_the_field_and_what_it_may(
    house: House, limits: dict[str, Any], fields: dict[str, Any], field: str, told: str
) -> None:
    caller = await button(house, **limits)
    body = problem(await caller.post(PATH, json=DRAFT | fields), 403, "beyond-key")
    [error] = body["errors"]
    assert error["field"] == field
    assert told in error["reason"]
    assert error["reason"] in body["detail"]
    assert house.bus.sent_to("M8", TransportOrdered) == []
    assert (await house.get(PATH))["items"] == []
    assert (await house.audit())[0].result == "refused"


async def test_a_key_that_is_not_urgent_is_not_so_by_a_due_time_either(house: House) -> None:
    caller = await button(house)
    body = problem(await caller.post(PATH, json=DRAFT | {"due_at": in_s(60)}), 403, "beyond-key")
    assert [(each["field"], each["code"]) for each in body["errors"]] == [("due_at", "only_later")]
    assert in_s(900.0) in body["errors"][0]["reason"]
    await called(caller, due_at=in_s(890.0))
    [asked] = house.bus.sent_to("M8", TransportOrdered)
    assert asked.due_s == pytest.approx(890.0)
    urgent = await button(house, priority="urgent")
    await called(urgent, due_at=in_s(5.0))


async def test_a_key_of_several_places_calls_for_each_of_them(house: House) -> None:
    caller = await button(house, places="M8 M9")
    await called(caller, to="M8")
    await called(caller, **{"from": "M8", "to": "S3"})
    problem(await caller.post(PATH, json=DRAFT | {"to": "M6"}), 403, "beyond-key")


async def test_only_so_many_calls_of_a_key_are_open_at_once(house: House) -> None:
    caller = await button(house, open_max=2, open_each_max=2)
    first = await called(caller)
    await called(caller)
    refused = await caller.post(PATH, json=DRAFT)
    body = problem(refused, 429, "key-full")
    assert body["errors"][0] == {
        "field": "key",
        "reason": "open calls of this key: 2, and it may have no more; cancel one, or wait until one has ended",
        "code": "key_full",
        "values": {"most": "2"},
    }
    assert int(refused.headers["retry-after"]) > 0
    assert len((await caller.get(PATH)).json()["items"]) == 2
    assert len(house.bus.sent_to("M8", TransportOrdered)) == 2
    ended = TransportProgressed(
        first, TransportState.DELIVERED, item="shaft", quantity=40, source="S3", destination="M8"
    )
    await house.say(events("M8", ended))
    await called(caller)


async def test_what_is_asked_again_under_its_key_is_answered_also_when_as_much_is_open_as_may_be(
    house: House,
) -> None:
    caller = await button(house, open_max=1)
    header = {"Idempotency-Key": "press-1"}
    first = await caller.post(PATH, json=DRAFT, headers=header)
    again = await caller.post(PATH, json=DRAFT, headers=header)
    assert (again.status_code, again.content) == (201, first.content)
    problem(await caller.post(PATH, json=DRAFT, headers={"Idempotency-Key": "press-2"}), 429, "key-full")


async def test_one_place_takes_only_so_many_of_the_calls_of_a_key(house: House) -> None:
    caller = await button(house, open_each_max=1)
    await called(caller, to="M8")
    body = problem(await caller.post(PATH, json=DRAFT | {"to": "M8"}), 429, "key-full")
    assert [(each["field"], each["values"]) for each in body["errors"]] == [
        ("to", {"place": "M8", "most": "1"})
    ]
    # Where it is fetched counts for keys of that place only: one storage serves many.
    await called(caller, to="M9")
    own = await button(house, places="M8", open_each_max=1)
    await called(own, **{"from": "M8", "to": "S3"})
    body = problem(await own.post(PATH, json=DRAFT), 429, "key-full")
    assert [each["field"] for each in body["errors"]] == ["to"]


async def test_calls_that_come_together_do_not_pass_the_bound(house: House) -> None:
    caller = await button(house, open_max=3)
    answers = await asyncio.gather(*(caller.post(PATH, json=DRAFT) for _ in range(8)))
    assert sorted(each.status_code for each in answers) == [201] * 3 + [429] * 5
    assert len(house.bus.sent_to("M8", TransportOrdered)) == 3


async def test_a_key_that_may_see_the_factory_sees_more_than_it_calls_for(house: House) -> None:
    _, header = await house.key(Scope.TRANSPORTS_CALL, Scope.FACTORY_READ, places="M9")
    elsewhere = (await house.client.post(PATH, json=DRAFT)).json()["id"]
    caller = house.visitor(**header)
    assert [each["id"] for each in (await caller.get(PATH)).json()["items"]] == [elsewhere]
    assert (await caller.get(f"{PATH}/{elsewhere}")).status_code == 200


async def test_one_key_takes_its_share_of_all_transports_and_leaves_the_others_theirs(
    house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(transports_module, "OPEN_MAX", 8)
    greedy, other = await button(house), await button(house)
    mine = [await called(greedy) for _ in range(2)]
    body = problem(await greedy.post(PATH, json=DRAFT), 429, "share-used")
    assert "of 8 open transports one caller may have 2" in body["detail"]
    await called(other)
    assert (await house.client.post(PATH, json=DRAFT)).status_code == 201, "and a person is heard, too"
    assert (await greedy.post(f"{PATH}/{mine[0]}/cancel")).status_code == 200
    assert house.bus.sent_to("M8", TransportCancelled) == [TransportCancelled(mine[0])]
