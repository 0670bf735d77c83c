"""The pages of the login: in three languages, whole without a script, and closed to other sites."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import httpx
import pytest
from answers import problem
from gateway_kit import PASSWORD, PIN, House, gateway
from login_kit import BROWSER, COOKIE, link_for, set_cookies, try_in

from dray.errors import UnavailableError
from dray.gateway.access.login.login import FREE_FAILURES
from dray.gateway.access.principal import Role
from dray.gateway.access.watch import Watch
from dray.gateway.http.assets import Panels
from dray.store import Store

pytestmark = pytest.mark.anyio


@pytest.mark.parametrize(
    ("language", "words"), [("en", "Log in"), ("de", "Anmelden"), ("es", "Iniciar sesión")]
)
@pytest.mark.parametrize("role", ["manager", "operator"])
async def test_the_login_speaks_the_browsers_language(
    visitor: httpx.AsyncClient, language: str, words: str, role: str
) -> None:
    page = await visitor.get("/login", params={"as": role}, headers={"Accept-Language": language})
    assert page.status_code == 200
    assert f'<html lang="{language}">' in page.text
    assert words in page.text
    assert not re.search(r"<script(?![^>]*\bsrc=)|<style|\son\w+=|\bstyle=", page.text)
    assert page.headers["cache-control"] == "no-store"
    assert page.headers["referrer-policy"] == "same-origin"


async def test_a_language_that_is_chosen_keeps_where_to_go_on(visitor: httpx.AsyncClient) -> None:
    page = await visitor.get("/login", params={"as": "operator", "next": "/operator?x=1", "lang": "de"})
    assert "dray_language=de" in set_cookies(page)["dray_language"]
    assert 'href="?next=%2Foperator%3Fx%3D1&amp;as=operator&amp;lang=es"' in page.text
    assert "Anmelden" in (await visitor.get("/login")).text


async def test_what_was_typed_is_shown_again_without_the_secret_and_without_harm(
    visitor: httpx.AsyncClient,
) -> None:
    name = '"><script>alert(1)</script>'
    answer = await visitor.post(
        "/login", data={"name": name, "secret": "hunter22-hunter22", "next": name}, headers=BROWSER
    )
    assert answer.status_code == 401
    assert answer.headers["content-type"].startswith("text/html")
    assert 'role="alert"' in answer.text
    assert "<script>alert" not in answer.text
    assert "&lt;script&gt;" in answer.text
    assert "hunter22" not in answer.text


async def test_too_many_tries_are_told_in_words_and_in_the_header(visitor: httpx.AsyncClient) -> None:
    for _ in range(FREE_FAILURES):
        await try_in(visitor, "boss", "wrong")
    answer = await visitor.post("/login", data={"name": "boss", "secret": "x"}, headers=BROWSER)
    assert answer.status_code == 429
    assert answer.headers["retry-after"] == "30"
    assert "Try again in 30 s" in answer.text


async def test_a_device_offers_the_operators_that_it_knows_and_no_managers(
    house: House, visitor: httpx.AsyncClient
) -> None:
    await house.know("boss")
    await house.know("ana", Role.OPERATOR, "AREA1")
    for name, secret in (("ana", PIN), ("boss", PASSWORD)):
        await try_in(visitor, name, secret)
        await visitor.post("/logout")
    page = await visitor.get("/login", params={"as": "operator"})
    assert re.findall(r'name="known" value="([^"]*)"', page.text) == ["ana", ""]
    assert (await visitor.post("/login", data={"known": "ana", "secret": PIN})).status_code == 303


async def test_another_sites_form_logs_nobody_in(house: House, visitor: httpx.AsyncClient) -> None:
    await house.know("boss")
    data = {"name": "boss", "secret": PASSWORD}
    for headers in (
        {"Origin": "http://evil.test"},
        {"Origin": "null"},
        {"Sec-Fetch-Site": "cross-site"},
        {"Sec-Fetch-Site": "same-site"},
    ):
        problem(await visitor.post("/login", data=data, headers=headers), 403, "other-origin")
    link = await link_for(house, "boss")
    problem(await visitor.post(link, headers={"Origin": "http://evil.test"}), 403, "other-origin")
    assert (await visitor.post(link, headers=BROWSER)).status_code == 303


@pytest.mark.parametrize("kind", ["application/json", "multipart/form-data; boundary=x", "text/plain", ""])
async def test_a_login_is_a_form_and_nothing_else(visitor: httpx.AsyncClient, kind: str) -> None:
    answer = await visitor.post("/login", content=b"name=a&secret=b", headers={"Content-Type": kind})
    problem(answer, 415, "not-called-form")


async def test_whoever_follows_a_link_of_another_site_is_asked_again_with_the_cookie(
    visitor: httpx.AsyncClient,
) -> None:
    refresh = '<meta http-equiv="refresh" content="0">'
    page = await visitor.get("/login", headers={"Sec-Fetch-Site": "cross-site"})
    assert refresh in page.text
    page = await visitor.get("/login", headers={"Sec-Fetch-Site": "same-origin"})
    assert refresh not in page.text


async def test_pages_that_are_not_built_say_so(url: str, tmp_path: Path) -> None:
    async with gateway(url, panels=Panels(tmp_path)) as house, house.visitor() as visitor:
        answer = await visitor.get("/login")
    assert answer.status_code == 503
    assert "make panels" in answer.text


@pytest.fixture
def away(monkeypatch: pytest.MonkeyPatch) -> Callable[[], None]:
    """Let the database go away."""

    def refuse(*_all: Any) -> None:
        raise UnavailableError("database", "connection refused", "start it")

    def leave() -> None:
        for way in ("read", "write"):
            monkeypatch.setattr(Store, way, refuse)

    return leave


async def test_while_the_database_is_away_a_person_is_told_so_on_a_page_and_a_program_in_json(
    house: House, away: Callable[[], None]
) -> None:
    boss = await house.log_in("boss")
    away()
    filled_in: dict[str, Any] = {"data": {"name": "boss", "secret": PASSWORD}}
    for method, path, form in (
        ("GET", "/login?next=%2F%3Fx%3D1", {}),
        ("POST", "/login", filled_in),
        ("GET", "/login/link", {}),
        ("POST", "/login/link", {}),
        ("POST", "/logout", {}),
    ):
        answer = await boss.request(method, path, headers=BROWSER, **form)
        assert answer.status_code == 503, (method, path)
        assert answer.headers["retry-after"]
        assert "The database does not answer" in answer.text
        assert PASSWORD not in answer.text
        assert answer.headers["content-type"].startswith("text/html")
        problem(await boss.request(method, path, **form), 503, "database-away")
    page = await boss.get("/login", params={"next": "/?x=1"}, headers=BROWSER)
    assert 'name="next" value="/?x=1"' in page.text


async def test_whoever_asks_for_a_panel_while_the_database_is_away_is_led_to_the_page_that_says_so(
    house: House, away: Callable[[], None]
) -> None:
    boss = await house.log_in("boss")
    away()
    answer = await boss.get("/?x=1", headers=BROWSER)
    assert (answer.status_code, answer.headers["location"]) == (303, "/login?next=%2F%3Fx%3D1")
    problem(await boss.get("/"), 503, "not-ready")


async def test_whoever_logs_out_has_no_cookie_any_more_though_streams_cannot_be_looked_at(
    house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    boss = await house.log_in("boss")

    async def fail(_watch: Watch) -> None:
        raise UnavailableError("database", "connection refused", "start it")

    monkeypatch.setattr(Watch, "check", fail)
    answer = await boss.post("/logout", headers=BROWSER)
    assert answer.status_code == 303
    assert "Max-Age=0" in set_cookies(answer)[COOKIE]
