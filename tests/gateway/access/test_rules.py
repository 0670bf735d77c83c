"""Every route says who may use it, and none is let through without."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from inspect import iscoroutinefunction
from typing import cast

import pytest
from answers import problem
from fake_bus import PLANT, FakeBus
from fastapi import FastAPI
from fastapi.dependencies.models import Dependant
from fastapi.routing import iter_route_contexts
from gateway_kit import AUTHORITY, House, gateway
from starlette.routing import Mount

from dray.gateway.access.rules import QUESTIONS, RULES, find
from dray.gateway.app import create_app
from dray.gateway.live.timescale import TimeScale
from dray.settings import Settings
from dray.store import Store

SAFE = {"GET", "HEAD", "OPTIONS"}

NO_STORE = cast(Store, None)
"""Routes are known before anything is opened."""


@pytest.fixture(scope="module")
def app() -> FastAPI:
    return create_app(
        settings=Settings(),
        plant=PLANT,
        bus=FakeBus(),
        store=NO_STORE,
        time=TimeScale(0.0, 0.0),
        authority=AUTHORITY,
    )


@pytest.fixture(scope="module")
def routes(app: FastAPI) -> set[tuple[str, str]]:
    """Method and path template of all that the gateway answers."""
    found = set()
    for context in iter_route_contexts(app.routes):
        if isinstance(context.original_route, Mount):
            # The panels' files: anybody may have them.
            assert context.path == "/static"
            continue
        for method in context.methods or {"GET"}:
            assert context.path is not None
            if method != "HEAD":
                found.add((method, context.path))
    return found


def test_every_route_has_a_row_and_every_row_a_route(routes: set[tuple[str, str]]) -> None:
    assert set(RULES) == routes


def functions(dependant: Dependant) -> Iterator[object]:
    """A route's own function, and those of all that it depends on."""
    yield dependant.call
    for each in dependant.dependencies:
        yield from functions(each)


def test_no_request_waits_for_a_thread(app: FastAPI) -> None:
    """FastAPI calls what is no coroutine function in a thread of a pool: two switches each."""
    asked = set()
    for context in iter_route_contexts(app.routes):
        dependant = getattr(context, "dependant", None)
        if isinstance(dependant, Dependant):
            asked |= set(functions(dependant))
    assert len(asked) > len(RULES) / 2
    assert [call for call in asked if not iscoroutinefunction(call)] == []


def test_whatever_changes_something_has_a_name_in_the_audit_log() -> None:
    for (method, path), rule in RULES.items():
        assert bool(rule.action) == (method not in SAFE and (method, path) not in QUESTIONS), path


def test_a_row_is_found_by_its_own_route_only(routes: set[tuple[str, str]]) -> None:
    for method, template in routes:
        found = find(method, template.replace("{", "").replace("}", ""))
        assert found is not None
        assert found.template == template


@pytest.mark.anyio
async def test_a_route_without_a_row_is_refused_and_told_in_the_log(
    url: str, caplog: pytest.LogCaptureFixture
) -> None:
    answered = []

    def with_a_new_route(app: FastAPI) -> None:
        @app.post("/api/new")
        async def new() -> None:
            answered.append("new")

    async with gateway(url, change=with_a_new_route) as house:
        problem(await house.client.post("/api/new"), 403, "no-rule")
    assert answered == []
    assert [record.levelno for record in caplog.records if "/api/new" in record.getMessage()] == [
        logging.ERROR
    ]


@pytest.mark.anyio
async def test_a_route_that_another_ones_row_lets_pass_is_refused(url: str) -> None:
    def with_a_new_route(app: FastAPI) -> None:
        # Comes before the router's own, and has the address of a tracking page.
        @app.get("/api/{noun}/{name}")
        async def new() -> None:
            raise AssertionError

        app.router.routes.insert(0, app.router.routes.pop())

    async with gateway(url, change=with_a_new_route) as house:
        problem(await house.client.get("/api/track/x"), 403, "no-rule")


@pytest.mark.anyio
async def test_a_wrong_bearer_token_is_refused(house: House) -> None:
    answer = await house.client.get("/api/orders", headers={"Authorization": "Bearer guess"})
    problem(answer, 401, "not-logged-in")
    assert answer.headers["www-authenticate"].startswith("Bearer")
