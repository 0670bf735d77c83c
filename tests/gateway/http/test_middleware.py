"""What every answer tells browsers that they may not do, whatever kind of answer it is."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, cast

import pytest
from fastapi import FastAPI
from gateway_kit import House, draft, gateway

from dray.gateway.access.rules import PUBLIC, RULES, Rule
from dray.gateway.http.middleware import CONTENT_POLICY, HEADERS, whole_characters

NOBODY = {"Authorization": ""}

ANSWERS: dict[str, tuple[int, str, str, dict[str, Any]]] = {
    "a page": (200, "GET", "/login", {"headers": NOBODY}),
    "a page that leads to the login": (303, "GET", "/", {"headers": NOBODY | {"Accept": "text/html"}}),
    "a customer's page of no order": (404, "GET", "/track/x", {"headers": NOBODY}),
    "data": (200, "GET", "/api/products", {}),
    "the head of data": (405, "HEAD", "/api/products", {}),
    "a table for a spreadsheet": (200, "GET", "/api/promises?format=csv", {}),
    "the description of the API": (200, "GET", "/api/openapi.json", {"headers": NOBODY}),
    "the state of the gateway": (200, "GET", "/healthz", {"headers": NOBODY}),
    "a built file": (200, "GET", "/static/icon.svg", {"headers": NOBODY}),
    "a built file that is not there": (404, "GET", "/static/nothing.js", {"headers": NOBODY}),
    "a refusal of nobody": (401, "GET", "/api/orders", {"headers": NOBODY}),
    "a refusal of a wrong token": (401, "GET", "/api/orders", {"headers": {"Authorization": "Bearer x"}}),
    "a refusal of another site": (403, "POST", "/api/orders", {"headers": {"Origin": "http://evil.test"}}),
    "nothing there": (404, "GET", "/api/nothing", {}),
    "a method that is not": (405, "DELETE", "/api/products", {}),
    "a body that is too large": (413, "POST", "/api/orders", {"content": b" " * (2**20 + 1)}),
    "a body that is wrong": (422, "POST", "/api/orders", {"json": draft(items=[])}),
    "a bug": (500, "GET", "/api/bug", {}),
}


def with_a_bug(app: FastAPI) -> None:
    @app.get("/api/bug")
    async def bug() -> None:
        raise RuntimeError


@pytest.fixture
def built(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """One built file, and templates that are rendered without any."""
    (tmp_path / "icon.svg").write_text("<svg/>")
    monkeypatch.setattr("dray.gateway.app.STATIC", tmp_path)
    monkeypatch.setattr("dray.gateway.http.assets.Panels.asset", lambda _panels, entry: f"/static/{entry}")
    monkeypatch.setattr("dray.gateway.http.assets.Panels.styles", lambda _panels, _entry: [])
    monkeypatch.setitem(cast(dict[tuple[str, str], Rule], RULES), ("GET", "/api/bug"), PUBLIC)


@pytest.mark.anyio
@pytest.mark.parametrize("kind", ANSWERS)
async def test_every_kind_of_answer_is_shielded(url: str, built: None, kind: str) -> None:
    status, method, path, more = ANSWERS[kind]
    async with gateway(url, change=with_a_bug) as house:
        answer = await house.client.request(method, path, **more)
    assert answer.status_code == status, answer.text
    for name, value in HEADERS.items():
        # The login's form must tell where it comes from.
        if (name, path) != ("Referrer-Policy", "/login"):
            assert answer.headers.get_list(name) == [value]


def test_nothing_but_our_own_is_allowed_and_nothing_within_a_page() -> None:
    rules = dict(rule.split(" ", 1) for rule in CONTENT_POLICY.split("; "))
    assert rules == {
        "default-src": "'self'",
        "object-src": "'none'",
        "base-uri": "'none'",
        "form-action": "'self'",
        "frame-ancestors": "'none'",
    }


@pytest.mark.anyio
async def test_the_documentation_alone_has_a_style_within_its_page_and_names_its_content(
    house: House,
) -> None:
    policy = (await house.client.get("/api/docs")).headers["content-security-policy"]
    assert policy.startswith(f"{CONTENT_POLICY}; style-src 'sha256-")
    assert "unsafe" not in policy


@pytest.mark.parametrize(
    ("body", "taken"),
    [
        (rb'{"a": "\ud83d\ude00"}', {"a": "\U0001f600"}),
        (rb'{"a": "\ud83d"}', {"a": "\0"}),
        (rb'{"\ude00": 1}', {"\0": 1}),
        (rb'["\ude00\ud83d\ud83d\ude00"]', ["\0\0\U0001f600"]),
        (rb'["\\ud800", "\\\ud800", "\n\u00fc"]', ["\\ud800", "\\\0", "\n\xfc"]),
        ('["\ud800", "ü"]'.encode("utf-8", "surrogatepass"), ["\0", "ü"]),
        (r'["\ud800", "ü"]'.encode("utf-16"), ["\0", "ü"]),
        (b'["plain"]', ["plain"]),
    ],
)
def test_no_half_of_a_character_comes_in_with_json(body: bytes, taken: object) -> None:
    assert json.loads(whole_characters(body)) == taken
