"""The login: who comes in, by name, badge or link, and what is written down of it."""

from __future__ import annotations

import asyncio
from contextlib import ExitStack
from typing import Any

import httpx
import pytest
from answers import problem
from argon2 import PasswordHasher
from gateway_kit import PASSWORD, PIN, QUICK, House
from login_kit import BROWSER, COOKIE, link_for, set_cookies, try_in
from wall_clock import NOW_S

from dray.gateway.access.login.hasher import AT_ONCE, WAITING, Hasher
from dray.gateway.access.login.login import BADGE_SALT, TRIES
from dray.gateway.access.principal import Role
from dray.gateway.access.sessions import LIFE_S
from dray.gateway.http.problems import Problem
from dray.store.access.audit import AuditRow

pytestmark = pytest.mark.anyio


# --- by name ----------------------------------------------------------------------------------------


async def test_a_manager_logs_in_by_password_and_an_operator_by_pin(house: House) -> None:
    manager = await house.log_in("boss")
    me = (await manager.get("/api/me")).json()
    assert (me["id"], me["name"], me["role"], me["areas"]) == ("boss", "Boss", "manager", None)
    assert "orders:write" in me["scopes"]
    assert me["expires_at_s"] == NOW_S + LIFE_S[Role.MANAGER]
    operator = await house.log_in("ana", Role.OPERATOR, "AREA1")
    me = (await operator.get("/api/me")).json()
    assert (me["id"], me["role"], me["areas"]) == ("ana", "operator", ["AREA1"])
    assert "orders:read" not in me["scopes"]


async def test_the_cookie_is_kept_from_scripts_and_other_sites(
    house: House, visitor: httpx.AsyncClient
) -> None:
    await house.know("boss")
    line = set_cookies(await try_in(visitor, "boss", PASSWORD))[COOKIE]
    parts = {part.strip().lower() for part in line.split(";")[1:]}
    assert {"httponly", "samesite=strict", "path=/"} <= parts
    assert "secure" not in parts
    assert not any(part.startswith("domain") for part in parts)
    assert len(line.partition("=")[2].partition(";")[0]) >= 43, "256 bits"


async def test_the_cookie_is_for_tls_only_where_there_is_tls(house: House) -> None:
    await house.know("boss")
    async with httpx.AsyncClient(transport=house.client._transport, base_url="https://dray.test") as client:
        answer = await try_in(client, "boss", PASSWORD)
    assert all("secure" in line.lower() for line in set_cookies(answer).values())


async def test_a_forged_header_does_not_make_it_tls(house: House, visitor: httpx.AsyncClient) -> None:
    await house.know("boss")
    visitor.headers["X-Forwarded-Proto"] = "https"
    assert "secure" not in set_cookies(await try_in(visitor, "boss", PASSWORD))[COOKIE].lower()


@pytest.mark.parametrize("name", ["boss", " Boss ", "BOSS"])
async def test_a_name_is_known_however_it_is_typed(
    house: House, visitor: httpx.AsyncClient, name: str
) -> None:
    await house.know("boss")
    assert (await try_in(visitor, name, PASSWORD)).status_code == 303


@pytest.mark.parametrize(
    ("name", "secret"),
    [
        ("boss", PASSWORD + " "),
        ("boss", PASSWORD[:-1]),
        ("boss", ""),
        ("boss", "x" * 30_000),
        ("boss", "\u0000"),
        ("ana", PASSWORD),
        ("nobody", PASSWORD),
        ("", ""),
        ("boss' OR '1'='1", PASSWORD),
        ("x" * 30_000, PASSWORD),
        ("\U0001f600", PASSWORD),
    ],
)
async def test_whoever_does_not_know_the_secret_learns_nothing(
    house: House, visitor: httpx.AsyncClient, name: str, secret: str
) -> None:
    await house.know("boss")
    await house.know("ana", Role.OPERATOR, "AREA1")
    answer = await try_in(visitor, name, secret)
    told = problem(answer, 401, "wrong-login")
    assert told["detail"] == problem(await try_in(visitor, "somebody", "else"), 401, "wrong-login")["detail"]
    assert COOKIE not in set_cookies(answer)
    problem(await visitor.get("/api/me"), 401, "not-logged-in")


async def test_who_was_disabled_is_told_what_a_stranger_is_told(
    house: House, visitor: httpx.AsyncClient
) -> None:
    await house.know("boss")
    async with house.store.write() as work:
        await work.people.change("boss", disabled_at_s=NOW_S)
    problem(await try_in(visitor, "boss", PASSWORD), 401, "wrong-login")


async def test_an_unknown_name_costs_one_hash_as_a_known_one_does(
    house: House, visitor: httpx.AsyncClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    await house.know("boss")
    verified: list[str] = []
    verify = PasswordHasher.verify

    def counted(hasher: PasswordHasher, kept: str | bytes, secret: str | bytes) -> bool:
        verified.append(str(kept))
        return bool(verify(hasher, kept, secret))

    monkeypatch.setattr(PasswordHasher, "verify", counted)
    for name in ("boss", "nobody"):
        await try_in(visitor, name, "wrong")
    assert len(verified) == 2
    costs = [kept.rpartition("$")[0].rpartition("$")[0] for kept in verified]
    assert costs[0] == costs[1], "the same memory, passes and lanes"


async def test_the_secret_of_nobody_lets_nobody_in() -> None:
    assert not QUICK.matches(None, "nobody's secret")
    assert not QUICK.matches("no hash at all", "secret")
    assert QUICK.matches(QUICK.hash("secret"), "secret")


async def test_hashing_leaves_the_event_loop_free() -> None:
    slow = Hasher(PasswordHasher(time_cost=8, memory_cost=32_768, parallelism=1))
    kept = slow.hash("secret")
    turns = 0
    with slow.place() as place:
        checking = asyncio.create_task(place.matches(kept, "secret"))
        while not checking.done():
            await asyncio.sleep(0)
            turns += 1
    assert await checking
    assert turns > 10


async def test_only_so_many_wait_for_their_hash() -> None:
    with ExitStack() as queue:
        for _ in range(WAITING):
            queue.enter_context(QUICK.place())
        with pytest.raises(Problem) as refused, QUICK.place():
            pass
    assert refused.value.status == 503
    assert refused.value.headers["Retry-After"]
    assert AT_ONCE < WAITING
    with QUICK.place() as place:
        assert not await place.matches(None, "x"), "and it goes on"


async def test_whoever_finds_no_place_in_the_queue_has_not_tried(
    house: House, visitor: httpx.AsyncClient
) -> None:
    await house.know("boss")
    await house.know("ana", Role.OPERATOR, "AREA1")
    with ExitStack() as queue:
        for _ in range(WAITING):
            queue.enter_context(QUICK.place())
        for _ in range(TRIES + 1):
            problem(await try_in(visitor, "boss", PASSWORD), 503, "too-many-logins")
            problem(await visitor.post("/login", data={"badge": "B"}), 503, "too-many-logins")
    for name, secret in (("boss", PASSWORD), ("ana", PIN)):
        assert (await try_in(visitor, name, secret)).status_code == 303
    async with house.store.read() as work:
        assert await work.lockouts.count() == 0


# --- by badge ---------------------------------------------------------------------------------------


async def test_an_operator_logs_in_by_badge(house: House, visitor: httpx.AsyncClient) -> None:
    await house.know("ana", Role.OPERATOR, "AREA1")
    async with house.store.write() as work:
        salt = await work.secrets.get(BADGE_SALT)
        await work.people.change("ana", badge_hash=QUICK.badge_hash("0012345678", salt))
    problem(await visitor.post("/login", data={"badge": "0012345679"}), 401, "wrong-login")
    assert (await visitor.post("/login", data={"badge": "0012345678\n"})).status_code == 303
    assert (await visitor.get("/api/me")).json()["id"] == "ana"
    async with house.store.write() as work:
        await work.people.change("ana", disabled_at_s=NOW_S)
    problem(await visitor.post("/login", data={"badge": "0012345678"}), 401, "wrong-login")


# --- by link ----------------------------------------------------------------------------------------


async def test_a_link_logs_in_once_and_looking_at_it_uses_nothing_up(
    house: House, visitor: httpx.AsyncClient
) -> None:
    await house.know("boss")
    link = await link_for(house, "boss")
    for _ in range(3):
        page = await visitor.get(link, headers=BROWSER)
        assert page.status_code == 200
        assert "Hello, Boss" in page.text
        assert COOKIE not in set_cookies(page)
    assert (await visitor.post(link)).headers["location"] == "/"
    assert (await visitor.get("/api/me")).json()["id"] == "boss"
    async with house.visitor() as thief:
        problem(await thief.post(link), 410, "login-link-used-up")
        problem(await thief.get(link), 410, "login-link-used-up")
        assert "does not log in any more" in (await thief.get(link, headers=BROWSER)).text


async def test_of_two_who_use_a_link_at_once_one_comes_in(house: House) -> None:
    await house.know("boss")
    link = await link_for(house, "boss")
    browsers = [house.visitor() for _ in range(4)]
    answers = await asyncio.gather(*(browser.post(link) for browser in browsers))
    assert sorted(answer.status_code for answer in answers) == [303, 410, 410, 410]


async def test_a_link_ends_with_its_time_with_a_newer_one_and_with_its_person(
    house: House, visitor: httpx.AsyncClient
) -> None:
    await house.know("boss")
    old = await link_for(house, "boss")
    new = await link_for(house, "boss", life_s=60.0)
    problem(await visitor.post(old), 410, "login-link-used-up")
    house.wall.now_s += 60.0
    problem(await visitor.post(new), 410, "login-link-used-up")
    last = await link_for(house, "boss")
    async with house.store.write() as work:
        await work.people.change("boss", disabled_at_s=house.wall.now_s)
    problem(await visitor.post(last), 410, "login-link-used-up")


async def test_what_is_kept_of_a_link_logs_nobody_in(house: House, visitor: httpx.AsyncClient) -> None:
    await house.know("boss")
    await link_for(house, "boss")
    async with house.store.database.read() as connection:
        rows = (await connection.exec_driver_sql("SELECT token_hash FROM login_links")).all()
    problem(await visitor.post(f"/login/{rows[0][0]}"), 410, "login-link-used-up")


# --- what is written down ---------------------------------------------------------------------------


def told(row: AuditRow) -> tuple[Any, ...]:
    return row.action, row.who, row.who_kind, row.target, row.result


async def test_logins_are_written_down_and_failures_with_whom_they_were_aimed_at(
    house: House, visitor: httpx.AsyncClient
) -> None:
    await house.know("boss")
    await try_in(visitor, "boss", "wrong")
    await try_in(visitor, "my-password-in-the-wrong-field", "wrong")
    await try_in(visitor, "boss", PASSWORD)
    await visitor.post("/login/guess")
    rows = list(reversed(await house.audit()))
    assert [told(row) for row in rows] == [
        ("login", "", "nobody", "boss", "refused"),
        ("login", "", "nobody", "", "refused"),
        ("login", "boss", "person", "", "done"),
        ("login", "", "nobody", "", "refused"),
    ]
    assert rows[2].session
    assert {row.from_ip for row in rows} == {"127.0.0.1"}
    everything = str([(row, bytes(row.detail)) for row in rows])
    assert "wrong-field" not in everything
    assert PASSWORD not in everything


async def test_a_name_that_no_database_can_hold_is_nobodys(house: House, visitor: httpx.AsyncClient) -> None:
    problem(await try_in(visitor, "boss\0", "wrong"), 401, "wrong-login")
    problem(await house.client.post("/api/alerts/a%00b/acknowledge"), 404, "unknown-alert")
    assert [row.target for row in await house.audit()] == ["a\ufffdb", ""]


async def test_whoever_is_slowed_down_fills_no_log(house: House, visitor: httpx.AsyncClient) -> None:
    for _ in range(3 * TRIES):
        await try_in(visitor, "boss", "wrong")
        await visitor.post("/login", content=b"x", headers={"Content-Type": "text/plain"})
        await visitor.post("/login", headers={"Origin": "http://evil.test"})
    assert len(await house.audit()) <= TRIES
