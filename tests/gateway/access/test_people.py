"""People and keys over REST: who is let in, by what, and who may decide that."""

from __future__ import annotations

from typing import Any

import msgspec
import pytest
from answers import problem
from fake_bus import PLANT
from gateway_kit import PASSWORD, PIN, House
from login_kit import BROWSER, try_in
from wall_clock import NOW_S

from dray.gateway.access.keys import KNOWN_S
from dray.gateway.access.principal import Role, Scope

pytestmark = pytest.mark.anyio

AREA = PLANT.areas[0].id

NEW = {"id": "ana", "name": "Ana, North", "role": "operator", "areas": [AREA]}


async def test_somebody_new_comes_in_by_a_link_and_then_by_a_pin(house: House) -> None:
    boss = await house.log_in("boss")
    added = await boss.post("/api/people", json=NEW)
    assert added.status_code == 201, added.text
    assert added.json()["secrets"] == []
    link = (await boss.post("/api/people/ana/link")).json()["url"]
    async with house.visitor() as ana:
        assert (await ana.post(link)).status_code == 303
        assert (await ana.get("/api/me")).json()["areas"] == [AREA]
        given = await boss.put("/api/people/ana/secret", json={"kind": "pin", "secret": PIN})
        assert given.json()["secrets"] == ["pin"]
        # Whoever was in by something else must come in anew.
        problem(await ana.get("/api/me"), 401, "not-logged-in")
        assert (await try_in(ana, "ana", PIN)).status_code == 303
    lines = await house.audit(who="boss")
    assert [row.action for row in lines] == ["user.secret", "user.link", "user.add", "login"]
    assert PIN not in str(lines)


async def test_who_is_disabled_is_out_at_once_and_everywhere_until_they_are_enabled(house: House) -> None:
    boss, ana = await house.log_in("boss"), await house.log_in("ana", Role.OPERATOR, AREA)
    link = (await boss.post("/api/people/ana/link")).json()["url"]
    assert (await boss.post("/api/people/ana/disable")).json()["disabled_at_s"] == house.wall.now_s
    problem(await ana.get("/api/me"), 401, "not-logged-in")
    problem(await boss.post("/api/people/ana/link"), 409, "disabled")
    async with house.visitor() as visitor:
        problem(await visitor.post(link), 410, "login-link-used-up")
        problem(await try_in(visitor, "ana", PIN), 401, "wrong-login")
        assert (await boss.post("/api/people/ana/enable")).json()["disabled_at_s"] is None
        assert (await try_in(visitor, "ana", PIN)).status_code == 303


async def test_an_operator_is_moved_to_another_area(house: House) -> None:
    boss, other = await house.log_in("boss"), PLANT.areas[1].id
    await house.know("ana", Role.OPERATOR, AREA)
    assert (await boss.put("/api/people/ana/areas", json={"areas": [other]})).json()["areas"] == [other]
    people = (await boss.get("/api/people")).json()["items"]
    assert {each["id"]: each["areas"] for each in people} == {"ana": [other], "boss": []}


async def test_nobody_locks_themselves_out(house: House) -> None:
    boss = await house.log_in("boss")
    problem(await boss.post("/api/people/boss/disable"), 409, "yourself")
    assert (await boss.get("/api/me")).status_code == 200


@pytest.mark.parametrize(
    ("change", "field", "code"),
    [
        ({"id": "Ana Weber"}, "id", "login_name"),
        ({"id": "boss"}, "id", "name_taken"),
        ({"areas": []}, "areas", "area_needed"),
        ({"areas": ["NOWHERE"]}, "areas", "area_unknown"),
        ({"role": "manager"}, "areas", "area_none"),
        ({"name": ""}, "name", "missing"),
        ({"role": "king"}, "role", "one_of"),
    ],
)
async def test_what_is_wrong_with_somebody_new_is_told_at_its_field_with_a_code(
    house: House, change: dict[str, object], field: str, code: str
) -> None:
    boss = await house.log_in("boss")
    body = problem(await boss.post("/api/people", json=NEW | change), 422, "unusable-fields")
    assert [(each["field"], each["code"]) for each in body["errors"]] == [(field, code)]


@pytest.mark.parametrize(
    ("person", "kind", "secret", "field", "code"),
    [
        ("ana", "pin", "123456", "secret", "pin_easy"),
        ("ana", "pin", "12", "secret", "pin_digits"),
        ("ana", "badge", "1", "secret", "badge_length"),
        ("ana", "badge", "badge of somebody", "secret", "badge_taken"),
        ("ana", "password", PASSWORD, "kind", "secret_of_other_role"),
        ("boss", "password", "short", "secret", "password_length"),
        ("boss", "password", "boss boss boss", "secret", "password_easy"),
        ("boss", "pin", PIN, "kind", "secret_of_other_role"),
    ],
)
async def test_a_secret_that_is_too_easy_is_refused_with_a_code(
    house: House, person: str, kind: str, secret: str, field: str, code: str
) -> None:
    boss = await house.log_in("boss")
    for operator in ("ana", "ben"):
        await house.know(operator, Role.OPERATOR, AREA)
    badge = {"kind": "badge", "secret": "badge of somebody"}
    assert (await boss.put("/api/people/ben/secret", json=badge)).status_code == 200
    answer = await boss.put(f"/api/people/{person}/secret", json={"kind": kind, "secret": secret})
    body = problem(answer, 422, "unusable-fields")
    assert [(each["field"], each["code"]) for each in body["errors"]] == [(field, code)]


async def test_a_key_is_shown_once_works_and_is_taken_back(house: House) -> None:
    boss = await house.log_in("boss")
    made = await boss.post("/api/keys", json={"name": "ERP", "scopes": ["orders:read"], "days": 30})
    assert made.status_code == 201, made.text
    token, key = made.json()["token"], made.json()["key"]
    listed = (await boss.get("/api/keys")).json()["items"]
    assert [each["id"] for each in listed] == [key["id"]]
    assert token not in str(listed)
    header = {"Authorization": f"Bearer {token}"}
    async with house.visitor() as erp:
        assert (await erp.get("/api/orders", headers=header)).status_code == 200
        taken = (await boss.post(f"/api/keys/{key['id']}/revoke")).json()
        assert taken["revoked_at_s"] == house.wall.now_s
        house.wall.now_s += KNOWN_S
        problem(await erp.get("/api/orders", headers=header), 401, "not-logged-in")
    assert token not in str(await house.audit())


BUTTON = {"name": "Button", "scopes": [Scope.TRANSPORTS_CALL.value]}


async def test_a_key_that_calls_has_limits_and_is_listed_with_them(house: House) -> None:
    boss, machines = await house.log_in("boss"), [each.id for each in PLANT.machines[:2]]
    limits = {"places": machines, "items": ["shaft"], "open_max": 4, "open_each_max": 2, "priority": "high"}
    made = await boss.post("/api/keys", json=BUTTON | limits)
    assert made.status_code == 201, made.text
    [listed] = (await boss.get("/api/keys")).json()["items"]
    assert {name: listed[name] for name in limits} == limits
    line = next(each for each in await house.audit() if each.action == "key.create")
    detail = msgspec.json.decode(msgspec.json.encode(line.detail))
    assert (detail["places"], detail["open"], detail["priority"]) == (machines, 4, "high")


async def test_a_key_for_which_nothing_is_said_is_bounded_and_not_urgent(house: House) -> None:
    boss = await house.log_in("boss")
    key = (await boss.post("/api/keys", json=BUTTON)).json()["key"]
    assert (key["open_max"], key["open_each_max"], key["priority"]) == (50, 20, "normal")
    key = (await boss.post("/api/keys", json=BUTTON | {"open_max": 3})).json()["key"]
    assert (key["open_max"], key["open_each_max"]) == (3, 3)


@pytest.mark.parametrize(
    ("change", "field", "code"),
    [
        ({"places": ["M1", "NOWHERE"]}, "places[1]", "place_unknown"),
        ({"items": ["nothing"]}, "items[0]", "material_unknown"),
        ({"open_max": 5, "open_each_max": 6}, "open_each_max", "bound_above_all"),
        ({"open_each_max": 51}, "open_each_max", "bound_above_all"),
        ({"open_max": 0}, "open_max", "at_least"),
        ({"open_max": 1251}, "open_max", "at_most"),
        ({"priority": "at once"}, "priority", "one_of"),
        ({"scopes": ["orders:read"], "places": ["M1"]}, "places", "calls_only"),
        ({"scopes": ["orders:read"], "priority": "urgent"}, "priority", "calls_only"),
        ({"scopes": []}, "scopes", "scope_needed"),
    ],
)
async def test_limits_that_cannot_be_are_refused(
    house: House, change: dict[str, Any], field: str, code: str
) -> None:
    boss = await house.log_in("boss")
    body = problem(await boss.post("/api/keys", json=BUTTON | change), 422, "unusable-fields")
    assert [(each["field"], each["code"]) for each in body["errors"]] == [(field, code)]
    assert (await boss.get("/api/keys")).json()["items"] == []


async def test_nobody_gives_away_what_they_may_not_do_themselves(house: House) -> None:
    """A key that may only see to people makes neither a manager nor a key that could do more."""
    await house.know("boss")
    _, header = await house.key(Scope.PEOPLE_WRITE)
    async with house.visitor() as program:
        program.headers.update(header)
        manager = {"id": "eve", "name": "Eve", "role": "manager"}
        problem(await program.post("/api/people", json=manager), 403, "not-allowed")
        problem(await program.post("/api/people/boss/link"), 403, "not-allowed")
        secret = {"kind": "password", "secret": "another four words"}
        problem(await program.put("/api/people/boss/secret", json=secret), 403, "not-allowed")
        problem(await program.post("/api/people/boss/disable"), 403, "not-allowed")
        key = {"name": "More", "scopes": ["orders:write"]}
        problem(await program.post("/api/keys", json=key), 403, "not-allowed")


async def test_an_operator_sees_neither_people_nor_keys(house: House) -> None:
    ana = await house.log_in("ana", Role.OPERATOR, AREA)
    for path in ("/api/people", "/api/keys"):
        problem(await ana.get(path), 403, "not-allowed")
    problem(await ana.post("/api/people", json=NEW), 403, "not-allowed")


async def test_who_and_which_key_are_not_there_is_said(house: House) -> None:
    boss = await house.log_in("boss")
    for act in ("link", "disable", "enable"):
        problem(await boss.post(f"/api/people/nobody/{act}"), 404, "unknown-person")
    problem(await boss.post("/api/keys/none/revoke"), 404, "unknown-key")


async def test_a_page_that_somebody_may_not_see_leads_to_the_one_that_they_may(house: House) -> None:
    ana = await house.log_in("ana", Role.OPERATOR, AREA)
    page = await ana.get("/editor", headers=BROWSER)
    assert (page.status_code, page.headers["location"]) == (303, "/")
    problem(await ana.get("/editor"), 403, "not-allowed")


@pytest.mark.parametrize("bound", [{"expires_at_s": NOW_S + 1000.0}, {"places": "M8"}, {"items": "shaft"}])
async def test_a_key_that_is_bound_decides_on_nobody(house: House, bound: dict[str, Any]) -> None:
    """Whoever has stolen it is somebody without end or bounds otherwise."""
    free, bounded = [house.visitor(**(await house.key(*Scope, **each))[1]) for each in ({}, bound)]
    problem(await bounded.post("/api/people", json=NEW), 403, "not-allowed")
    assert (await free.post("/api/people", json=NEW)).status_code == 201
    problem(await bounded.post("/api/people/ana/link"), 403, "not-allowed")
    problem(await bounded.post("/api/people/ana/disable"), 403, "not-allowed")
    assert (await free.post("/api/people/ana/link")).status_code < 300
