"""Who may do what: every route for everybody, and what is said to whoever may not."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from typing import Any

import httpx
import pytest
from gateway_kit import (
    ADMIN_TOKEN,
    BEARER,
    HOME,
    NOW_S,
    PASSWORD,
    PLANT,
    House,
    atv_heartbeat,
    draft,
    gateway,
    problem,
    vehicle,
)
from login_kit import BROWSER, COOKIE
from sqlalchemy.exc import OperationalError

from dray.errors import UnavailableError
from dray.gateway.access.access import STRANGERS_TRIES
from dray.gateway.access.keys import KNOWN_S
from dray.gateway.access.principal import SCOPES, Role, Scope
from dray.gateway.access.rules import RULES
from dray.gateway.access.sessions import LIFE_S
from dray.gateway.access.tokens import new_key
from dray.messages import Pose
from dray.store import Store
from dray.store.access.api_keys import ApiKey, ApiKeys
from dray.store.access.audit import Audit
from dray.store.access.sessions import Sessions
from dray.store.database.database import Database

pytestmark = pytest.mark.anyio

EVERYWHERE = [(method, path) for (method, path), rule in RULES.items() if not rule.public]

PUBLIC = [(method, path) for (method, path), rule in RULES.items() if rule.public]

STREAM = "/api/stream"


def filled(path: str) -> str:
    """An address of this template; nothing has this id."""
    return path.replace("{", "no-").replace("}", "")


async def ask(client: httpx.AsyncClient, method: str, path: str, **more: Any) -> httpx.Response:
    return await client.request(method, filled(path), **more)


@pytest.fixture
async def stranger(calm_house: House) -> AsyncIterator[httpx.AsyncClient]:
    """The browser of somebody who has not logged in, at a gateway that is the same for every route."""
    async with calm_house.visitor() as client:
        yield client


# --- every route ---------------------------------------------------------------------------------


@pytest.mark.parametrize(("method", "path"), EVERYWHERE)
async def test_a_stranger_is_asked_who_it_is(stranger: httpx.AsyncClient, method: str, path: str) -> None:
    answer = await ask(stranger, method, path)
    problem(answer, 401, "not-logged-in")
    assert answer.headers["www-authenticate"] == 'Bearer realm="Dray"'
    assert answer.headers["x-content-type-options"] == "nosniff"


@pytest.mark.parametrize(("method", "path"), [each for each in EVERYWHERE if not each[1].startswith("/api/")])
async def test_a_stranger_with_a_browser_is_led_to_the_login(
    stranger: httpx.AsyncClient, method: str, path: str
) -> None:
    answer = await ask(stranger, method, path, headers=BROWSER)
    assert answer.status_code == 303
    assert answer.headers["location"].startswith("/login")


@pytest.mark.parametrize(("method", "path"), PUBLIC)
async def test_what_is_public_asks_nobody(stranger: httpx.AsyncClient, method: str, path: str) -> None:
    answer = await ask(stranger, method, path)
    if answer.status_code == 401:
        problem(answer, 401, "wrong-login")  # the login itself


@pytest.mark.parametrize(("method", "path"), [each for each in EVERYWHERE if each[1] != STREAM])
async def test_a_key_without_the_scope_is_refused_and_one_with_it_is_not(
    calm_house: House, stranger: httpx.AsyncClient, method: str, path: str
) -> None:
    scope = RULES[method, path].scope
    if scope is None:
        return
    others = set(Scope) - {scope, Scope.VEHICLES_COMMAND if scope is Scope.VEHICLES_STOP else scope}
    _, without = await calm_house.key(*others)
    told = problem(await ask(stranger, method, path, headers=without), 403, "not-allowed")
    assert scope.value in told["detail"]
    _, wanted = await calm_house.key(scope)
    answer = await ask(stranger, method, path, headers=wanted)
    assert answer.status_code not in {401, 403}, answer.text


@pytest.mark.parametrize(("method", "path"), [each for each in EVERYWHERE if each[1] != STREAM])
async def test_an_operator_comes_in_where_the_table_says_so_only(
    house: House, method: str, path: str
) -> None:
    ana = await house.log_in("ana", Role.OPERATOR, "AREA1")
    rule = RULES[method, path]
    answer = await ask(ana, method, path)
    if rule.by_area and (rule.scope is None or rule.scope in SCOPES[Role.OPERATOR]):
        assert answer.status_code not in {401, 403}
    else:
        problem(answer, 403, "not-allowed")


async def test_a_manager_may_do_everything(house: House) -> None:
    boss = await house.log_in("boss")
    for method, path in EVERYWHERE:
        if path != STREAM:
            answer = await ask(boss, method, path)
            assert answer.status_code not in {401, 403}, (method, path)


async def test_nobody_is_let_in_before_its_body_is_read(visitor: httpx.AsyncClient) -> None:
    for content in (b"{", b"x" * 2_000_000):
        answer = await visitor.post(
            "/api/orders", content=content, headers={"Content-Type": "application/json"}
        )
        problem(answer, 401, "not-logged-in")


# --- credentials ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "credentials",
    [
        "Bearer",
        "Bearer ",
        f"Bearer {ADMIN_TOKEN}x",
        f"Bearer {ADMIN_TOKEN[:-1]}",
        f"Basic {ADMIN_TOKEN}",
        ADMIN_TOKEN,
        "Bearer dray_guess",
        "Bearer \xe4",
        "Bearer " + "x" * 10_000,
    ],
)
async def test_what_is_no_token_of_ours_is_refused(visitor: httpx.AsyncClient, credentials: str) -> None:
    header = {"Authorization": credentials.encode("latin-1")}
    answer = await visitor.get("/api/orders", headers=header)  # type: ignore[arg-type]
    problem(answer, 401, "not-logged-in")
    assert ADMIN_TOKEN not in answer.text


async def test_a_token_in_the_address_is_none(visitor: httpx.AsyncClient) -> None:
    for name in ("access_token", "token", "authorization", COOKIE):
        problem(await visitor.get("/api/orders", params={name: ADMIN_TOKEN}), 401, "not-logged-in")


async def test_without_an_administrators_token_there_is_no_administrator(url: str) -> None:
    async with gateway(url, admin_token=None) as house, house.visitor() as visitor:
        for token in ("", "None", "none"):
            answer = await visitor.get("/api/orders", headers={"Authorization": f"Bearer {token}"})
            problem(answer, 401, "not-logged-in")


async def test_credentials_that_are_shown_count_and_not_the_cookie_beside_them(house: House) -> None:
    boss = await house.log_in("boss")
    problem(await boss.get("/api/me", headers={"Authorization": "Bearer guess"}), 401, "not-logged-in")
    assert (await boss.get("/api/me", headers=BEARER)).json()["kind"] == "admin"


async def test_a_session_is_no_bearer_token_and_a_key_is_no_cookie(house: House) -> None:
    boss = await house.log_in("boss")
    token = boss.cookies[COOKIE]
    _, header = await house.key(Scope.ORDERS_READ)
    async with house.visitor() as visitor:
        answer = await visitor.get("/api/orders", headers={"Authorization": f"Bearer {token}"})
        problem(answer, 401, "not-logged-in")
        visitor.cookies.set(COOKIE, header["Authorization"].removeprefix("Bearer "))
        problem(await visitor.get("/api/orders"), 401, "not-logged-in")


async def test_strangers_with_tokens_are_slowed_down_and_others_at_that_address_are_not(
    house: House, visitor: httpx.AsyncClient
) -> None:
    for n in range(STRANGERS_TRIES):
        header = {"Authorization": f"Bearer guess-{n}"}
        problem(await visitor.get("/api/orders", headers=header), 401, "not-logged-in")
    answer = await visitor.get("/api/orders", headers={"Authorization": "Bearer guess"})
    problem(answer, 429, "too-many-tries")
    assert int(answer.headers["retry-after"]) >= 1
    assert (await visitor.get("/api/orders", headers=BEARER)).status_code == 200


# --- keys ----------------------------------------------------------------------------------------


async def test_a_key_ends_with_its_time_or_when_it_is_taken_back(
    house: House, visitor: httpx.AsyncClient
) -> None:
    _, short = await house.key(Scope.ORDERS_READ, expires_at_s=NOW_S + 60)
    key, long = await house.key(Scope.ORDERS_READ)
    for header in (short, long):
        assert (await visitor.get("/api/orders", headers=header)).status_code == 200
    house.wall.now_s += 60
    problem(await visitor.get("/api/orders", headers=short), 401, "not-logged-in")
    async with house.store.write() as work:
        await work.api_keys.revoke(key.id, house.wall.now_s)
    house.wall.now_s += KNOWN_S
    problem(await visitor.get("/api/orders", headers=long), 401, "not-logged-in")


async def test_a_key_that_is_used_all_the_time_is_looked_up_once_a_second(
    house: House, visitor: httpx.AsyncClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    _, header = await house.key(Scope.ORDERS_READ)
    asked: list[str] = []
    find = ApiKeys.find

    async def counting(keys: ApiKeys, token: str) -> ApiKey | None:
        asked.append(token)
        return await find(keys, token)

    monkeypatch.setattr(ApiKeys, "find", counting)
    for _ in range(30):
        assert (await visitor.get("/api/products", headers=header)).status_code == 200
        house.wall.now_s += 0.125
    assert len(asked) == 4
    house.wall.now_s -= 3600.0
    await visitor.get("/api/products", headers=header)
    assert len(asked) == 5, "a clock that was set back makes nothing known for an hour"


async def test_a_key_that_nobody_has_is_looked_up_each_time(house: House, visitor: httpx.AsyncClient) -> None:
    token = new_key()
    header = {"Authorization": f"Bearer {token}"}
    problem(await visitor.get("/api/products", headers=header), 401, "not-logged-in")
    async with house.store.write() as work:
        key = ApiKey(id="k1", name="ERP", scopes="orders:read", created_at_s=NOW_S)
        await work.api_keys.add(token, key)
    assert (await visitor.get("/api/products", headers=header)).status_code == 200


async def test_a_key_tells_what_it_is_and_when_it_was_used(house: House, visitor: httpx.AsyncClient) -> None:
    key, header = await house.key(Scope.ORDERS_READ)
    me = (await visitor.get("/api/me", headers=header)).json()
    assert me == {
        "kind": "key",
        "id": key.id,
        "name": "ERP",
        "role": None,
        "areas": None,
        "station": "",
        "scopes": ["orders:read"],
        "expires_at_s": None,
    }
    house.wall.now_s += 30
    await visitor.get("/api/me", headers=header)
    async with house.store.read() as work:
        kept = await work.api_keys.get(key.id)
    assert kept is not None
    assert kept.used_at_s == NOW_S, "not written for every request"


async def test_a_scope_that_this_dray_does_not_know_allows_nothing(
    house: House, visitor: httpx.AsyncClient
) -> None:
    key, header = await house.key()
    async with house.store.database.write() as connection:
        await connection.exec_driver_sql("UPDATE api_keys SET scopes = 'orders:read teleport'")
    assert (await visitor.get("/api/me", headers=header)).json()["scopes"] == ["orders:read"]
    assert key.scopes == ""


async def test_one_key_asks_so_often_and_no_more(url: str) -> None:
    async with gateway(url, key_burst=3, key_rate_hz=0.5) as house, house.visitor() as visitor:
        _, busy = await house.key(Scope.ORDERS_READ)
        _, other = await house.key(Scope.ORDERS_READ)
        for _ in range(3):
            assert (await visitor.get("/api/orders", headers=busy)).status_code == 200
        answer = await visitor.get("/api/orders", headers=busy)
        problem(answer, 429, "too-many-tries")
        assert answer.headers["retry-after"] == "2"
        assert (await visitor.get("/api/orders", headers=other)).status_code == 200
        house.wall.now_s += 2
        assert (await visitor.get("/api/orders", headers=busy)).status_code == 200


# --- answers -------------------------------------------------------------------------------------


async def test_no_cache_keeps_what_somebody_was_told(house: House) -> None:
    boss = await house.log_in("boss")
    for path in ("/api/orders", "/api/me", "/api/audit", "/api/plant", "/api/nothing-at-all"):
        answer = await boss.get(path)
        assert answer.status_code == 404 or answer.headers["cache-control"] == "no-store"


async def test_a_database_that_is_away_is_said_and_not_taken_for_a_stranger(
    house: House, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    boss = await house.log_in("boss")

    async def fail(_sessions: Sessions, _token: str) -> None:
        raise OperationalError("SELECT", {}, Exception("disk I/O error"))

    monkeypatch.setattr(Sessions, "find", fail)
    for _ in range(5):
        answer = await boss.get("/api/me")
        problem(answer, 503, "not-ready")
        assert answer.headers["retry-after"]
    assert caplog.text.count("disk I/O error") == 1, "an outage has one line, however many ask meanwhile"


async def test_whoever_was_known_may_stop_while_the_database_is_away_and_nothing_else(
    house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    house.bus.say(atv_heartbeat("ATV1"))
    heard = vehicle(house)
    boss = await house.log_in("boss")
    await boss.get("/api/me")
    before = boss.cookies[COOKIE]
    await boss.post("/login", data={"name": "boss", "secret": PASSWORD})
    await boss.get("/api/me")
    gone = await house.log_in("gone")
    await gone.get("/api/me")
    left = gone.cookies[COOKIE]
    await gone.post("/logout")
    commands = "/api/atvs/ATV1/commands"

    def away(*_all: Any) -> None:
        raise UnavailableError("database", "connection refused", "start it")

    monkeypatch.setattr(Store, "read", away)
    monkeypatch.setattr(Store, "write", away)
    assert (await boss.post(commands, json={"kind": "stop"})).status_code == 200
    assert [command.kind.value for command in heard] == ["stop"]
    problem(await boss.post(commands, json={"kind": "resume"}), 503, "not-recorded")
    problem(await boss.get("/api/atvs"), 503, "not-ready")
    for ended in (left, before):
        gone.cookies.set(COOKIE, ended)
        problem(await gone.post(commands, json={"kind": "stop"}), 503, "not-ready")
    async with house.visitor() as stranger:
        stranger.cookies.set(COOKIE, "guess")
        problem(await stranger.post(commands, json={"kind": "stop"}), 503, "not-ready")
    assert len(heard) == 1


async def test_a_database_that_can_only_be_read_keeps_nobody_out(
    house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    boss = await house.log_in("boss")
    _, header = await house.key(Scope.ORDERS_READ)

    def full(*_all: Any) -> None:
        raise UnavailableError("database", "disk full", "make room")

    monkeypatch.setattr(Store, "write", full)
    house.wall.now_s += 120
    assert (await boss.get("/api/me")).status_code == 200
    assert (await boss.get("/api/orders", headers=header)).status_code == 200


# --- the audit log -------------------------------------------------------------------------------


async def test_who_did_what_is_written_down_with_what_came_of_it(house: House) -> None:
    boss = await house.log_in("boss")
    house.bus.say(atv_heartbeat("ATV1"))
    vehicle(house, done=False, reason="acknowledge first")
    placed = (await boss.post("/api/orders", json=draft())).json()
    await boss.post(f"/api/orders/{placed['id']}/cancel")
    await boss.post("/api/orders", json=draft(customer=""))
    await boss.post("/api/atvs/ATV1/commands", json={"kind": "resume"})
    await boss.post("/api/atvs/ATV99/commands", json={"kind": "stop"})
    rows = [row for row in await house.audit(who="boss") if row.action != "login"][::-1]
    assert [(row.action, row.target, row.result) for row in rows] == [
        ("order.place", placed["id"], "done"),
        ("order.cancel", placed["id"], "done"),
        ("order.place", "", "refused"),
        ("vehicle.command", "ATV1", "refused"),
        ("vehicle.command", "ATV99", "refused"),
    ]
    assert len({row.session for row in rows}) == 1
    told = (await boss.get("/api/audit", params={"target": "ATV1"})).json()["items"][0]
    assert told["detail"]["kind"] == "resume"
    assert told["detail"]["reason"] == "acknowledge first"
    assert (told["who"], told["who_kind"], told["from_ip"]) == ("boss", "person", "127.0.0.1")


async def test_what_the_rules_refuse_is_written_down_too(house: House, visitor: httpx.AsyncClient) -> None:
    ana = await house.log_in("ana", Role.OPERATOR, "AREA1")
    await ana.post("/api/orders", json=draft())
    _, header = await house.key(Scope.ORDERS_READ)
    await visitor.post("/api/orders", json=draft(), headers=header)
    await visitor.post("/api/orders", json=draft())
    rows = await house.audit(action="order.place")
    assert [(row.who_kind, row.result) for row in rows] == [("key", "refused"), ("person", "refused")]


async def test_reading_is_not_written_down(house: House) -> None:
    for path in ("/api/orders", "/api/atvs", "/api/audit"):
        await house.get(path)
    assert await house.audit() == []


async def test_a_line_is_on_disk_before_its_answer_leaves(
    house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun, written = asyncio.Event(), asyncio.Event()
    add = Audit.add

    async def slowly(audit: Audit, row: Any) -> int:
        begun.set()
        await written.wait()
        return await add(audit, row)

    order = await house.place()
    monkeypatch.setattr(Audit, "add", slowly)
    asking = asyncio.create_task(house.client.post(f"/api/orders/{order['id']}/cancel"))
    await begun.wait()
    assert not asking.done()
    written.set()
    assert (await asking).status_code == 200
    assert len(await house.audit(action="order.cancel")) == 1


async def test_an_order_and_its_line_are_on_disk_together_before_the_answer_leaves(
    house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun, go_on = asyncio.Event(), asyncio.Event()
    do = Database.do

    async def slowly(database: Database, *work: Any) -> Any:
        begun.set()
        await go_on.wait()
        return await do(database, *work)

    monkeypatch.setattr(Database, "do", slowly)
    asking = asyncio.create_task(house.client.post("/api/orders", json=draft()))
    await begun.wait()
    assert not asking.done()
    assert (await house.orders_kept(), await house.audit(action="order.place")) == (0, [])
    go_on.set()
    placed = await asking
    assert placed.status_code == 201
    lines = await house.audit(action="order.place")
    assert [(line.result, line.target) for line in lines] == [("done", placed.json()["id"])]
    assert await house.orders_kept() == 1


async def test_a_stop_waits_for_no_disk_and_its_line_is_written_when_there_is_one(
    house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    house.bus.say(atv_heartbeat("ATV1"))
    vehicle(house)

    async def fail(_audit: Audit, _row: Any) -> int:
        raise OperationalError("INSERT", {}, Exception("disk full"))

    with monkeypatch.context() as broken:
        broken.setattr(Audit, "add", fail)
        for _ in range(2):
            assert (
                await house.client.post("/api/atvs/ATV1/commands", json={"kind": "stop"})
            ).status_code == 200
            house.wall.now_s += 1.0
        trail = house.access.audit_log
        with pytest.raises(UnavailableError):
            await trail.catch_up()
        assert trail.waiting == 2
    lines = await house.audit(action="vehicle.command")
    assert [(line.target, line.result, line.at_s) for line in lines] == [
        ("ATV1", "done", NOW_S + 1.0),
        ("ATV1", "done", NOW_S),
    ]


async def test_an_action_that_cannot_be_written_down_is_done_and_said_so(
    house: House, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    house.bus.say(atv_heartbeat("ATV1"))
    heard = vehicle(house)

    async def fail(_audit: Audit, _row: Any) -> int:
        raise OperationalError("INSERT", {}, Exception("disk full"))

    monkeypatch.setattr(Audit, "add", fail)
    answer = await house.client.post("/api/atvs/ATV1/commands", json={"kind": "resume"})
    problem(answer, 503, "not-recorded")
    assert len(heard) == 1
    assert "not in the audit log: vehicle.command by admin, about ATV1" in caplog.text


async def test_a_bug_is_written_down_as_failed(house: House, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_all: Any, **_more: Any) -> None:
        raise RuntimeError

    monkeypatch.setattr("dray.gateway.routes.orders.orders.order_answer", broken)
    problem(await house.client.post("/api/orders", json=draft()), 500, "bug")
    (row,) = await house.audit()
    assert (row.action, row.result) == ("order.place", "failed")


async def test_the_log_is_read_in_pages_and_as_a_table_without_formulas(house: House) -> None:
    for _ in range(5):
        await house.client.post("/api/atvs/=HYPERLINK(1)/commands", json={"kind": "stop"})
    first = await house.get("/api/audit", limit=3)
    assert len(first["items"]) == 3
    rest = await house.get("/api/audit", limit=3, cursor=first["next_cursor"])
    assert (len(rest["items"]), rest["next_cursor"]) == (2, None)
    assert await house.get("/api/audit", since=NOW_S + 1) == {"items": [], "next_cursor": None}
    assert len((await house.get("/api/audit", until=NOW_S + 1, result="refused"))["items"]) == 5
    table = await house.client.get("/api/audit", params={"format": "csv"})
    assert table.headers["content-type"].startswith("text/csv")
    lines = table.text.splitlines()
    assert lines[0].startswith("position,at,who,who_kind,from_ip,session,action,target,result,detail")
    assert len(lines) == 6
    assert "'=HYPERLINK(1)" in lines[1]


@pytest.mark.parametrize("query", ["since=-1", "since=x", "until=nan", "result=lost", "who=" + "x" * 129])
async def test_a_question_to_the_log_that_cannot_be_answered_is_refused(house: House, query: str) -> None:
    problem(await house.client.get(f"/api/audit?{query}"), 422, "unusable-fields")


# --- stop ----------------------------------------------------------------------------------------


async def test_a_key_that_may_stop_may_not_let_go_on(house: House, visitor: httpx.AsyncClient) -> None:
    house.bus.say(atv_heartbeat("ATV1"))
    heard = vehicle(house)
    _, header = await house.key(Scope.VEHICLES_STOP)
    commands = "/api/atvs/ATV1/commands"
    for kind in ("acknowledge", "resume"):
        told = problem(await visitor.post(commands, json={"kind": kind}, headers=header), 403, "not-allowed")
        assert "vehicles:command" in told["detail"]
    assert (await visitor.post(commands, json={"kind": "stop"}, headers=header)).status_code == 200
    assert [command.kind.value for command in heard] == ["stop"]
    assert heard[0].issued_by == "ERP"


async def test_an_operator_whose_time_is_over_stops_a_vehicle_nearby_and_that_is_written_down(
    house: House,
) -> None:
    place = next(node for node in PLANT.nodes if node.id == "m1")
    house.bus.say(atv_heartbeat("ATV1", pose=Pose(place.x_m, place.y_m, 0.0)))
    heard = vehicle(house)
    ana = await house.log_in("ana", Role.OPERATOR, "AREA1")
    house.wall.now_s += LIFE_S[Role.OPERATOR] + 1
    commands = "/api/atvs/ATV1/commands"
    problem(await ana.post(commands, json={"kind": "resume"}), 401, "session-run-out")
    assert (await ana.post(commands, json={"kind": "stop"})).status_code == 200
    assert [command.kind.value for command in heard] == ["stop"]
    stop = (await house.audit(who="ana"))[0]
    assert (stop.action, stop.target, stop.result) == ("vehicle.command", "ATV1", "done")
    assert b'"session_over":"run_out"' in bytes(stop.detail)


# --- the stream ----------------------------------------------------------------------------------


class Browser:
    """A browser's end of the stream, spoken to the application as a server does (ASGI)."""

    def __init__(self, house: House, *, query: str = "", **headers: str) -> None:
        self.to_app: asyncio.Queue[dict[str, Any]] = asyncio.Queue()
        self.heard: list[dict[str, Any]] = []
        self.more = asyncio.Event()
        scope = {
            "type": "websocket",
            "asgi": {"version": "3.0"},
            "http_version": "1.1",
            "scheme": "ws",
            "path": STREAM,
            "raw_path": STREAM.encode(),
            "query_string": query.encode(),
            "root_path": "",
            "headers": [
                (name.encode(), value.encode()) for name, value in ({"host": "dray.test"} | headers).items()
            ],
            "client": ("127.0.0.1", 1234),
            "server": ("dray.test", 80),
            "subprotocols": [],
            "state": {},
        }
        self.to_app.put_nowait({"type": "websocket.connect"})
        self.served = asyncio.create_task(house.app(scope, self.to_app.get, self._send))

    async def _send(self, message: Any) -> None:
        self.heard.append(message)
        self.more.set()

    async def hears(self, kind: str) -> dict[str, Any]:
        """The first message of this kind."""
        while True:
            found = [message for message in self.heard if message["type"] == f"websocket.{kind}"]
            if found:
                return found[0]
            self.more.clear()
            await self.more.wait()

    async def leave(self) -> None:
        self.to_app.put_nowait({"type": "websocket.disconnect", "code": 1001})
        await self.served


def cookie(client: httpx.AsyncClient) -> dict[str, str]:
    return {"cookie": f"{COOKIE}={client.cookies[COOKIE]}", "origin": HOME}


@pytest.mark.parametrize(
    "headers",
    [{}, {"cookie": f"{COOKIE}=guess"}, {"authorization": "Bearer guess"}, {"authorization": "Basic x"}],
    ids=["nothing", "a guessed cookie", "a guessed token", "no token"],
)
async def test_a_stranger_may_not_watch_and_is_told_by_the_code(
    house: House, headers: dict[str, str]
) -> None:
    browser = Browser(house, query=f"access_token={ADMIN_TOKEN}", **headers)
    await browser.served
    assert [message["type"] for message in browser.heard] == ["websocket.accept", "websocket.close"]
    assert browser.heard[1]["code"] == 4401
    assert house.hub.joined == 0


async def test_who_lacks_the_scope_may_not_watch(house: House) -> None:
    _, header = await house.key(Scope.ORDERS_READ)
    browser = Browser(house, authorization=header["Authorization"])
    await browser.served
    assert browser.heard[-1]["code"] == 4403


async def test_a_stream_with_a_parameter_that_nobody_knows_is_refused_by_the_code(house: House) -> None:
    browser = Browser(house, query="area=AREA1", authorization=BEARER["Authorization"])
    await browser.served
    assert [message["type"] for message in browser.heard] == ["websocket.accept", "websocket.close"]
    assert browser.heard[1]["code"] == 4422
    assert house.hub.joined == 0


async def test_a_page_of_another_site_may_not_watch_with_our_cookie(house: House) -> None:
    boss = await house.log_in("boss")
    for forged in ({"origin": "http://evil.test"}, {"sec-fetch-site": "cross-site"}):
        browser = Browser(house, **cookie(boss) | forged)
        await browser.served
        assert [message["type"] for message in browser.heard] == ["websocket.close"]


async def log_out(house: House, boss: httpx.AsyncClient) -> None:
    await boss.post("/logout")


async def disable(house: House, boss: httpx.AsyncClient) -> None:
    async with house.store.write() as work:
        await work.people.change("boss", disabled_at_s=NOW_S)
    await house.access.watch.check()


async def revoke(house: House, boss: httpx.AsyncClient) -> None:
    async with house.store.write() as work:
        await work.sessions.end_all("boss", NOW_S)
    await house.access.watch.check()


async def let_time_pass(house: House, boss: httpx.AsyncClient) -> None:
    house.wall.now_s += LIFE_S[Role.MANAGER]
    await house.access.watch.check()


@pytest.mark.parametrize("end", [log_out, disable, revoke, let_time_pass])
async def test_a_stream_ends_with_its_session(house: House, end: Callable[..., Any]) -> None:
    boss, other = await house.log_in("boss"), await house.log_in("other")
    browser, bystander = Browser(house, **cookie(boss)), Browser(house, authorization=BEARER["Authorization"])
    await browser.hears("send")
    await bystander.hears("send")
    await end(house, boss)
    assert (await browser.hears("close"))["code"] == 4401
    await browser.served
    assert house.hub.joined == 1
    await bystander.leave()
    assert (await other.post("/logout")).status_code == 204


async def test_a_stream_ends_in_another_way_when_its_session_goes_on_at_another_station(house: House) -> None:
    ana = await house.log_in("ana", Role.OPERATOR, "AREA1")
    browser = Browser(house, **cookie(ana))
    await browser.hears("send")
    assert (await ana.post("/login/station", data={"station": "M2"})).status_code == 303
    await house.access.watch.check()
    assert (await browser.hears("close"))["code"] == 4409
    assert (await ana.get("/api/me")).json()["station"] == "M2"


async def test_a_stream_of_a_key_ends_with_the_key(house: House) -> None:
    key, header = await house.key(Scope.FACTORY_READ)
    browser = Browser(house, authorization=header["Authorization"])
    await browser.hears("send")
    await house.access.watch.check()
    assert browser.heard[-1]["type"] != "websocket.close"
    async with house.store.write() as work:
        await work.api_keys.revoke(key.id, NOW_S)
    await house.access.watch.check()
    assert (await browser.hears("close"))["code"] == 4401


async def test_a_panel_that_is_watched_is_not_idle(house: House) -> None:
    boss = await house.log_in("boss")
    browser = Browser(house, **cookie(boss))
    await browser.hears("send")
    for _ in range(5):
        house.wall.now_s += 3600
        await house.access.watch.check()
    assert (await boss.get("/api/me")).status_code == 200
    await browser.leave()


async def test_a_database_that_is_away_ends_no_stream(
    house: House, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    asked = asyncio.Event()

    async def fail(_sessions: Sessions, _ids: Any) -> None:
        asked.set()
        raise OperationalError("SELECT", {}, Exception("disk I/O error"))

    boss = await house.log_in("boss")
    browser = Browser(house, **cookie(boss))
    await browser.hears("send")
    monkeypatch.setattr(Sessions, "some", fail)
    monkeypatch.setattr("dray.gateway.access.watch.CHECK_S", 0.0)
    watching = asyncio.create_task(house.access.watch.run())
    for _ in range(2):
        asked.clear()
        await asked.wait()
    assert "could not be checked" in caplog.text
    assert not watching.done()
    watching.cancel()
    assert browser.heard[-1]["type"] != "websocket.close"
    await browser.leave()
