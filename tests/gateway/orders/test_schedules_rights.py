"""Recurring work over REST: who may see it, change it, and go on with it."""

from __future__ import annotations

import csv
import io
from typing import Any

import msgspec
import pytest
from answers import problem
from gateway_kit import PRODUCT, House
from recurring_kit import BRING, DAY_S, DRAFT, PATH, SIX_S, added, brought, change, look

from dray.gateway.access.principal import Scope

pytestmark = [pytest.mark.anyio, pytest.mark.usefixtures("asked_by_the_test_alone")]


async def test_who_may_only_read_changes_nothing(house: House) -> None:
    schedule = await added(house)
    _, reader = await house.key(Scope.FACTORY_READ)
    visitor = house.visitor(**reader)
    assert (await visitor.get(PATH)).json()["items"] == [schedule]
    assert (await visitor.post(PATH, json=DRAFT | {"name": "Mine"})).status_code == 403
    assert (await visitor.delete(f"{PATH}/{schedule['id']}", headers={"If-Match": "*"})).status_code == 403


@pytest.mark.parametrize("how", ["key taken back", "key run out", "person out"])
async def test_what_belongs_to_who_may_do_nothing_any_more_pauses_and_says_so(house: House, how: str) -> None:
    if how == "person out":
        owner = await house.log_in("maria")
    else:
        expires = {"expires_at_s": SIX_S - 1} if how == "key run out" else {}
        key, header = await house.key(Scope.FLOOR_WRITE, Scope.FACTORY_READ, **expires)
        owner = house.visitor(**header)
    begun = await owner.post(PATH, json=DRAFT)
    assert begun.status_code == 201, begun.text
    place = f"{PATH}/{begun.json()['id']}"
    assert begun.json()["owner_gone"] is False
    if how == "person out":
        assert (await house.client.post("/api/people/maria/disable")).status_code == 200
    elif how == "key taken back":
        assert (await house.client.post(f"/api/keys/{key.id}/revoke")).status_code < 300
    await look(house, SIX_S)
    assert await brought(house) == []
    stopped = await house.get(place)
    assert (stopped["paused"], stopped["owner_gone"], stopped["next_runs"]) == (True, True, [])
    [listed] = (await house.get(PATH))["items"]
    assert listed == stopped
    [line] = [each for each in await house.audit(action="schedule.change") if each.who_kind == "schedule"]
    assert how.partition(" ")[0] in msgspec.json.decode(line.detail)["owner_gone"]
    await look(house, SIX_S + 1)
    assert await house.get(place) == stopped
    # A name is no reason to go on. Whoever lets it go on has it from then on.
    renamed = await change(house, stopped, name="Shafts for M8")
    assert (renamed["paused"], renamed["owner_gone"]) == (True, True)
    going = await change(house, renamed, paused=False)
    assert (going["paused"], going["owner_gone"]) == (False, False)
    await look(house, SIX_S + DAY_S)
    assert len(await brought(house)) == 1


async def test_who_may_place_no_orders_takes_on_none(house: House) -> None:
    key, header = await house.key(Scope.FLOOR_WRITE, Scope.FACTORY_READ, Scope.ORDERS_WRITE)
    order = {"customer": "Hall 3", "items": [{"product": PRODUCT, "quantity": 1}]}
    draft = {name: value for name, value in DRAFT.items() if name != "transport"} | {"order": order}
    begun = await house.visitor(**header).post(PATH, json=draft)
    assert (await house.client.post(f"/api/keys/{key.id}/revoke")).status_code < 300
    await look(house, SIX_S)
    _, header = await house.key(Scope.FLOOR_WRITE, Scope.FACTORY_READ)
    asked = await house.visitor(**header).patch(
        f"{PATH}/{begun.json()['id']}", json={"paused": False}, headers={"If-Match": "*"}
    )
    problem(asked, 403, "not-allowed")


ORDERED = {"customer": "Hall 3", "items": [{"product": PRODUCT, "quantity": 1}]}


@pytest.mark.parametrize(
    "change",
    [
        {"calendar": "* * * * *"},
        {"time_zone": "Asia/Tokyo"},
        {"holidays": ["2030-03-18"]},
        {"missed": "catch_up"},
        {"skipped": ["2030-03-18T06:00:00+01:00"]},
        {"paused": True},
        {"paused": False},
        {"name": "Another"},
        {"transport": BRING},
        {"order": ORDERED | {"customer": "Me"}},
        None,
    ],
    ids=lambda change: "removed" if change is None else str(*change),
)
async def test_who_may_place_no_orders_changes_nothing_of_anothers_that_recurs(
    house: House, change: dict[str, Any] | None
) -> None:
    begun = await added(house, transport=None, order=ORDERED, paused=change == {"paused": False})
    place = f"{PATH}/{begun['id']}"
    before = await house.get(place)
    _, header = await house.key(Scope.FLOOR_WRITE, Scope.FACTORY_READ)
    visitor, version = house.visitor(**header), {"If-Match": "*"}
    if change is None:
        answer = await visitor.delete(place, headers=version)
    else:
        answer = await visitor.patch(place, json=change, headers=version)
    problem(answer, 403, "not-allowed")
    assert await house.get(place) == before
    # Who may place orders may.
    _, header = await house.key(Scope.FLOOR_WRITE, Scope.ORDERS_WRITE, Scope.ORDERS_READ)
    visitor = house.visitor(**header)
    if change is None:
        answer = await visitor.delete(place, headers=version)
    else:
        answer = await visitor.patch(place, json=change, headers=version)
    assert answer.status_code < 300, answer.text


async def test_who_may_read_no_orders_is_told_of_no_others_that_recur(house: House) -> None:
    await added(house)
    others = await added(house, name="Hall 3", transport=None, order=ORDERED)
    _, header = await house.key(Scope.FLOOR_WRITE, Scope.FACTORY_READ, Scope.ORDERS_WRITE)
    visitor = house.visitor(**header)
    draft = {name: value for name, value in DRAFT.items() if name != "transport"}
    own = (await visitor.post(PATH, json=draft | {"name": "Own", "order": ORDERED})).json()
    listed = (await visitor.get(PATH)).json()["items"]
    assert {each["name"] for each in listed} == {"Shafts", "Own"}
    rows = csv.DictReader(io.StringIO((await visitor.get(PATH, params={"format": "csv"})).text))
    assert {row["name"] for row in rows} == {"Shafts", "Own"}
    assert (await visitor.get(f"{PATH}/{own['id']}")).status_code == 200
    place, version = f"{PATH}/{others['id']}", {"If-Match": "*"}
    problem(await visitor.get(place), 404, "unknown-schedule")
    problem(await visitor.patch(place, json={"name": "Mine"}, headers=version), 404, "unknown-schedule")
    problem(await visitor.delete(place, headers=version), 404, "unknown-schedule")
    assert len((await house.get(PATH))["items"]) == 3
