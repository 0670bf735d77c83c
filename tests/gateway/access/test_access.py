"""Who may do what: every route for everybody, and what is said to whoever may not."""

from __future__ import annotations

from collections.abc import AsyncIterator
from typing import Any

import httpx
import pytest
from answers import problem, vehicle
from fake_bus import PLANT
from gateway_kit import ADMIN_TOKEN, BEARER, PASSWORD, STREAM, House, gateway
from heartbeats import atv_heartbeat
from login_kit import BROWSER, COOKIE
from sqlalchemy.exc import OperationalError

from dray.errors import UnavailableError
from dray.gateway.access.access import STRANGERS_TRIES
from dray.gateway.access.principal import SCOPES, Role, Scope
from dray.gateway.access.rules import RULES
from dray.gateway.access.sessions import LIFE_S
from dray.messages import Pose
from dray.store import Database, Store
from dray.store.access.sessions import Sessions

pytestmark = pytest.mark.anyio

EVERYWHERE = [(method, path) for (method, path), rule in RULES.items() if not rule.public]

PUBLIC = [(method, path) for (method, path), rule in RULES.items() if rule.public]


def filled(path: str) -> str:
    """An address of this template; nothing has this id."""
    return path.replace("{", "no-").replace("}", "")


async def ask(client: httpx.AsyncClient, method: str, path: str, **more: Any) -> httpx.Response:
    return await client.request(method, filled(path), **more)


@pytest.fixture
async def stranger(quiet_house: House) -> AsyncIterator[httpx.AsyncClient]:
    """The browser of somebody who has not logged in, at a gateway that is the same for every route."""
    async with quiet_house.visitor() as client:
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
    quiet_house: House, stranger: httpx.AsyncClient, method: str, path: str
) -> None:
    scope = RULES[method, path].scope
    if scope is None:
        return
    others = set(Scope) - {scope, Scope.VEHICLES_COMMAND if scope is Scope.VEHICLES_STOP else scope}
    _, without = await quiet_house.key(*others)
    told = problem(await ask(stranger, method, path, headers=without), 403, "not-allowed")
    assert scope.value in told["detail"]
    _, wanted = await quiet_house.key(scope)
    answer = await ask(stranger, method, path, headers=wanted)
    assert answer.status_code not in {401, 403}, answer.text


@pytest.mark.parametrize(("method", "path"), [each for each in EVERYWHERE if each[1] != STREAM])
async def test_an_operator_comes_in_where_the_table_says_so_only(
    quiet_house: House, method: str, path: str
) -> None:
    name = f"ana{EVERYWHERE.index((method, path))}"  # one of the routes logs out
    ana = await quiet_house.log_in(name, Role.OPERATOR, "AREA1")
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


# --- credentials ------------------------------------------------------------------------------------


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


# --- answers ----------------------------------------------------------------------------------------


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
    monkeypatch.setattr(Database, "do", away)
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
    monkeypatch.setattr(Database, "do", full)
    house.wall.now_s += 120
    assert (await boss.get("/api/me")).status_code == 200
    assert (await boss.get("/api/orders", headers=header)).status_code == 200


# --- stop -------------------------------------------------------------------------------------------


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
