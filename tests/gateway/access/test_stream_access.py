"""Who may listen to the stream, and how it ends for whoever may no longer."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Any

import httpx
import pytest
from gateway_kit import ADMIN_TOKEN, BEARER, HOME, STREAM, House
from login_kit import COOKIE
from sqlalchemy.exc import OperationalError
from wall_clock import NOW_S

from dray.gateway.access.principal import Role, Scope
from dray.gateway.access.sessions import LIFE_S
from dray.store.access.sessions import Sessions

pytestmark = pytest.mark.anyio


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
