"""Sessions: from a login to its end, where it leads, and what outlives it."""

from __future__ import annotations

import re

import httpx
import pytest
from answers import problem
from gateway_kit import PASSWORD, PIN, House
from login_kit import BROWSER, COOKIE, set_cookies, try_in
from wall_clock import NOW_S

from dray.gateway.access.login.redirect import redirect_target
from dray.gateway.access.principal import Over, Role, Scope
from dray.gateway.access.sessions import HOUR_S, IDLE_S, LIFE_S, MAY_STILL_STOP_S

pytestmark = pytest.mark.anyio


# --- sessions ------------------------------------------------------------------------------------


async def test_every_login_has_a_new_token_and_ends_the_one_before(house: House) -> None:
    await house.know("boss")
    async with house.visitor() as browser:
        browser.cookies.set(COOKIE, "chosen-by-an-attacker", domain="dray.test")
        await try_in(browser, "boss", PASSWORD)
        first = browser.cookies.get(COOKIE, domain="dray.test", path="/") or browser.cookies[COOKIE]
        assert first != "chosen-by-an-attacker"
    async with house.visitor() as thief:
        thief.cookies.set(COOKIE, "chosen-by-an-attacker")
        problem(await thief.get("/api/me"), 401, "not-logged-in")
    async with house.visitor() as browser:
        browser.cookies.set(COOKIE, first)
        answer = await browser.post("/login", data={"name": "boss", "secret": PASSWORD})
        second = set_cookies(answer)[COOKIE].partition("=")[2].partition(";")[0]
        assert second != first
    async with house.visitor() as old:
        old.cookies.set(COOKIE, first)
        problem(await old.get("/api/me"), 401, "not-logged-in")


async def test_who_logs_out_is_out_and_may_do_so_twice(house: House) -> None:
    boss = await house.log_in("boss")
    token = boss.cookies[COOKIE]
    answer = await boss.post("/logout")
    assert answer.status_code == 204
    assert 'dray_session=""' in set_cookies(answer)[COOKIE]
    boss.cookies.set(COOKIE, token)
    problem(await boss.get("/api/me"), 401, "not-logged-in")
    assert (await boss.post("/logout")).status_code == 204
    page = await boss.post("/logout", headers=BROWSER)
    assert (page.status_code, page.headers["location"]) == (303, "/login")
    assert [row.action for row in await house.audit(who="boss")] == ["logout", "login"]


async def test_a_session_that_nobody_uses_ends_and_one_in_use_ends_with_the_day(house: House) -> None:
    idle, busy = await house.log_in("idle"), await house.log_in("busy")
    while house.wall.now_s + IDLE_S / 2 < NOW_S + LIFE_S[Role.MANAGER]:
        house.wall.now_s += IDLE_S / 2
        assert (await busy.get("/api/me")).status_code == 200
    problem(await idle.get("/api/me"), 401, "not-logged-in")
    house.wall.now_s = NOW_S + LIFE_S[Role.MANAGER]
    problem(await busy.get("/api/me"), 401, "not-logged-in")


async def test_who_is_disabled_is_out_at_once(house: House) -> None:
    boss = await house.log_in("boss")
    async with house.store.write() as work:
        await work.people.change("boss", disabled_at_s=NOW_S)
    problem(await boss.get("/api/me"), 401, "not-logged-in")


async def test_who_is_given_other_areas_has_them_at_once(house: House) -> None:
    ana = await house.log_in("ana", Role.OPERATOR, "AREA1")
    async with house.store.write() as work:
        await work.people.move("ana", ["AREA2", "AREA3"])
    assert (await ana.get("/api/me")).json()["areas"] == ["AREA2", "AREA3"]


async def test_an_operator_works_at_one_station_at_a_time_and_a_manager_where_he_likes(house: House) -> None:
    first = await house.log_in("ana", Role.OPERATOR, "AREA1")
    desk = await house.log_in("boss")
    async with house.visitor() as second, house.visitor() as laptop:
        await try_in(second, "ana", PIN)
        await try_in(laptop, "boss", PASSWORD)
        problem(await first.get("/api/me"), 401, "session-replaced")
        for browser in (second, desk, laptop):
            assert (await browser.get("/api/me")).status_code == 200


async def test_an_old_session_is_forgotten_in_the_end(house: House) -> None:
    await house.log_in("boss")
    house.wall.now_s += 60 * 24 * HOUR_S
    async with house.visitor() as browser:
        await try_in(browser, "boss", PASSWORD)
    async with house.store.database.read() as connection:
        assert (await connection.exec_driver_sql("SELECT count(*) FROM sessions")).scalar() == 1


# --- stop outlives the session -------------------------------------------------------------------


async def test_a_session_that_ran_out_of_time_may_stop_and_nothing_else(house: House) -> None:
    ana = await house.log_in("ana", Role.OPERATOR, "AREA1")
    token = ana.cookies[COOKIE]
    house.wall.now_s += LIFE_S[Role.OPERATOR]
    principal = await house.access.sessions.recognise(token)
    assert principal is not None
    assert principal.over
    assert {scope.value for scope in principal.scopes} == {"vehicles:stop"}
    assert principal.areas == {"AREA1"}
    for path in ("/api/me", "/api/atvs", "/api/stream", "/api/orders"):
        assert (await ana.get(path)).status_code in {401, 404}, path
    house.wall.now_s += MAY_STILL_STOP_S
    assert await house.access.sessions.recognise(token) is None


@pytest.mark.parametrize("away", [False, True], ids=["", "the database is away"])
async def test_a_session_that_was_replaced_may_stop_and_nothing_else(house: House, away: bool) -> None:
    ana = await house.log_in("ana", Role.OPERATOR, "AREA1")
    await ana.get("/api/me")
    async with house.visitor() as other:
        await try_in(other, "ana", PIN)
    sessions, token = house.access.sessions, ana.cookies[COOKIE]
    principal = sessions.remembered(token, house.wall.now_s) if away else await sessions.recognise(token)
    assert principal is not None
    assert (principal.over, principal.areas) == (Over.REPLACED, {"AREA1"})
    assert principal.scopes == {Scope.VEHICLES_STOP}
    house.wall.now_s += MAY_STILL_STOP_S
    assert await sessions.recognise(token) is None
    assert sessions.remembered(token, house.wall.now_s) is None


@pytest.mark.parametrize("then", ["disabled", "logged out there"])
async def test_what_ends_a_person_ends_the_replaced_session_too_and_a_logout_elsewhere_does_not(
    house: House, then: str
) -> None:
    ana = await house.log_in("ana", Role.OPERATOR, "AREA1")
    async with house.visitor() as other:
        await try_in(other, "ana", PIN)
        house.wall.now_s += 60.0
        if then == "disabled":
            async with house.store.write() as work:
                await work.people.change("ana", disabled_at_s=NOW_S)
        else:
            await other.post("/logout")
    principal = await house.access.sessions.recognise(ana.cookies[COOKIE])
    assert (principal is None) == (then == "disabled")


@pytest.mark.parametrize("how", ["logged out", "disabled", "a manager"])
async def test_a_session_that_ended_otherwise_may_not_even_stop(house: House, how: str) -> None:
    role = Role.MANAGER if how == "a manager" else Role.OPERATOR
    ana = await house.log_in("ana", role, *([] if role is Role.MANAGER else ["AREA1"]))
    token = ana.cookies[COOKIE]
    match how:
        case "logged out":
            await ana.post("/logout")
        case "disabled":
            async with house.store.write() as work:
                await work.people.change("ana", disabled_at_s=NOW_S)
    house.wall.now_s += LIFE_S[role] + 1
    assert await house.access.sessions.recognise(token) is None


# --- redirect_target --------------------------------------------------------------------------------------


@pytest.mark.parametrize("path", ["/", "/operator", "/?lang=de", "/#orders", "/operator?x=1&y=%2F"])
def test_the_login_leads_on_to_our_own_pages(path: str) -> None:
    assert redirect_target(path, Role.OPERATOR) == path


@pytest.mark.parametrize(
    "path",
    [
        "",
        "https://evil.test",
        "//evil.test",
        "///evil.test",
        "/\\evil.test",
        "\\\\evil.test",
        "/\t/evil.test",
        "/ok\r\nSet-Cookie: x=1",
        "/ok\\..\\",
        "javascript:alert(1)",
        "evil.test",
        "@evil.test",
        "/login",
        "/login/station",
        "/api/orders",
        "/\u2215evil.test",
        " //evil.test",
    ],
)
def test_the_login_leads_nowhere_else(path: str) -> None:
    assert redirect_target(path, Role.MANAGER) == "/"
    assert redirect_target(path, Role.OPERATOR) == "/operator"


async def test_a_header_cannot_be_smuggled_in(house: House, visitor: httpx.AsyncClient) -> None:
    await house.know("boss")
    answer = await try_in(visitor, "boss", PASSWORD, next="/a\r\nX-Evil: 1")
    assert answer.headers["location"] == "/"
    assert "x-evil" not in answer.headers


async def test_who_is_logged_in_is_sent_on_at_once(house: House) -> None:
    boss = await house.log_in("boss")
    answer = await boss.get("/login", params={"next": "/?x=1"})
    assert (answer.status_code, answer.headers["location"]) == (303, "/?x=1")
    answer = await boss.get("/login", params={"next": "//evil.test"})
    assert answer.headers["location"] == "/"


async def test_a_page_leads_to_the_login_and_back(house: House, visitor: httpx.AsyncClient) -> None:
    answer = await visitor.get("/?x=a%26b", headers=BROWSER)
    assert answer.status_code == 303
    page = await visitor.get(answer.headers["location"], headers=BROWSER)
    (wanted, *_) = re.findall(r'name="next" value="([^"]*)"', page.text)
    await house.know("boss")
    assert (await try_in(visitor, "boss", PASSWORD, next=wanted)).headers["location"] == "/?x=a%26b"


# --- stations ------------------------------------------------------------------------------------


async def test_an_operator_chooses_a_station_once_per_device(
    house: House, visitor: httpx.AsyncClient
) -> None:
    await house.know("ana", Role.OPERATOR, "AREA1")
    answer = await try_in(visitor, "ana", PIN)
    assert answer.headers["location"] == "/login/station?next=%2Foperator"
    page = await visitor.get("/login/station", headers=BROWSER)
    assert set(re.findall(r'name="station" value="([^"]*)"', page.text)) == {"M1", "M2", "M3"}
    problem(await visitor.post("/login/station", data={"station": "M8"}), 422, "unusable-fields")
    answer = await visitor.post("/login/station", data={"station": "M2"})
    assert answer.headers["location"] == "/operator"
    assert (await visitor.get("/api/me")).json()["station"] == "M2"
    await visitor.post("/logout")
    assert (await try_in(visitor, "ana", PIN)).headers["location"] == "/operator"
    assert (await visitor.get("/api/me")).json()["station"] == "M2"


async def test_a_device_that_stands_elsewhere_asks_again(house: House, visitor: httpx.AsyncClient) -> None:
    await house.know("ana", Role.OPERATOR, "AREA1")
    visitor.cookies.set("dray_station", "M8")
    answer = await try_in(visitor, "ana", PIN, next="/operator?x=1")
    assert answer.headers["location"] == "/login/station?next=%2Foperator%3Fx%3D1"


async def test_a_manager_has_no_station(house: House) -> None:
    boss = await house.log_in("boss")
    problem(await boss.post("/login/station", data={"station": "M1"}), 422, "unusable-fields")


async def test_an_operator_has_no_place_in_the_management_panel(house: House) -> None:
    ana = await house.log_in("ana", Role.OPERATOR, "AREA1")
    answer = await ana.get("/")
    assert (answer.status_code, answer.headers["location"]) == (303, "/operator")
