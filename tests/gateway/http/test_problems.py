"""A bug of ours is told as a problem, and nothing of our insides with it."""

from __future__ import annotations

import logging
from typing import Any, cast

import pytest
from answers import problem
from fastapi import FastAPI
from gateway_kit import House, draft, gateway

from dray.gateway.access.rules import PUBLIC, RULES, Rule
from dray.store.database.insertion import Insertion
from dray.store.orders.placing import Placing

pytestmark = pytest.mark.anyio

SECRET = "postgresql://dray:hunter2@db/dray"


@pytest.fixture
def rule(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(cast(dict[tuple[str, str], Rule], RULES), ("GET", "/api/bug"), PUBLIC)


def with_a_bug(app: FastAPI) -> None:
    @app.get("/api/bug")
    async def bug() -> None:
        raise RuntimeError(SECRET)


async def test_a_bug_is_told_without_insides_and_logged_with_them(
    url: str, rule: None, caplog: pytest.LogCaptureFixture
) -> None:
    async with gateway(url, change=with_a_bug) as house:
        answer = await house.client.get("/api/bug")
    told = problem(answer, 500, "bug")
    assert "try again" in told["detail"]
    for word in ("RuntimeError", "hunter2", "Traceback", ".py"):
        assert word not in answer.text
    (record,) = [record for record in caplog.records if record.name == "dray.gateway.http.problems"]
    assert record.levelno == logging.ERROR
    assert record.getMessage() == "bug while answering GET /api/bug"
    assert SECRET in caplog.text


async def test_a_bug_is_shielded_as_every_answer_is(url: str, rule: None) -> None:
    async with gateway(url, change=with_a_bug) as house:
        answer = await house.client.get("/api/bug")
    assert answer.headers["x-content-type-options"] == "nosniff"
    assert answer.headers["content-security-policy"]


async def test_an_order_is_stored_wholly_or_not_at_all(house: House, monkeypatch: pytest.MonkeyPatch) -> None:
    write = Insertion.write

    def fail_after(*rows: Any) -> None:
        write(*rows)
        raise OSError(f"INSERT INTO orders: {SECRET}: disk I/O error")

    key = {"Idempotency-Key": "4711"}
    with monkeypatch.context() as patch:
        # One statement cannot be done by half; what PostgreSQL does where that way is not open is tried here.
        patch.setattr(Placing, "_at_once", lambda *_: None)
        patch.setattr(Insertion, "write", fail_after)
        answer = await house.client.post("/api/orders", json=draft(), headers=key)
    problem(answer, 503, "database-away")
    assert int(answer.headers["retry-after"]) > 0
    assert "INSERT" not in answer.text
    assert SECRET not in answer.text
    assert await house.orders_kept() == 0
    assert house.bus.sent == []
    assert (await house.get("/api/kpis"))["orders_open"] == 0
    again = await house.client.post("/api/orders", json=draft(), headers=key)
    assert again.status_code == 201
