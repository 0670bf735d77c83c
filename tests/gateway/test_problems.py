"""A bug of ours is told as a problem, and nothing of our insides with it."""

from __future__ import annotations

import logging
from typing import cast

import pytest
from fastapi import FastAPI
from gateway_kit import House, draft, gateway, problem

from dray.gateway.access.rules import PUBLIC, RULES, Rule
from dray.gateway.problems import FieldError, Problem, unusable
from dray.store.orders import Orders
from dray.store.work import Work

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
    (record,) = [record for record in caplog.records if record.name == "dray.gateway.problems"]
    assert record.levelno == logging.ERROR
    assert record.getMessage() == "bug while answering GET /api/bug"
    assert SECRET in caplog.text


async def test_a_bug_is_shielded_as_every_answer_is(url: str, rule: None) -> None:
    async with gateway(url, change=with_a_bug) as house:
        answer = await house.client.get("/api/bug")
    assert answer.headers["x-content-type-options"] == "nosniff"
    assert answer.headers["content-security-policy"]


async def test_an_order_is_stored_wholly_or_not_at_all(house: House, monkeypatch: pytest.MonkeyPatch) -> None:
    add = Orders.add

    async def fail_after(orders: Orders, order: object) -> None:
        await add(orders, order)  # type: ignore[arg-type]
        raise OSError(f"INSERT INTO orders: {SECRET}: disk I/O error")

    key = {"Idempotency-Key": "4711"}
    with monkeypatch.context() as patch:
        patch.setattr(Orders, "add", fail_after)
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


async def test_it_is_ready_while_orders_can_be_taken(house: House) -> None:
    assert await house.get("/healthz") == {"status": "ok"}
    assert (await house.get("/readyz"))["status"] == "ready"


async def test_it_is_not_ready_while_orders_cannot_be_taken(
    house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def fail(_work: Work) -> None:
        raise OSError("disk I/O error")

    monkeypatch.setattr(Work, "ping", fail)
    house.historian.failing = True
    house.parts.peer.leave()
    answer = await house.client.get("/readyz")
    told = problem(answer, 503, "not-ready")
    assert told["detail"].split("; ") == [
        "the database does not answer",
        "the historian cannot write to the database",
        "the gateway is not on the bus",
    ]
    assert int(answer.headers["retry-after"]) > 0
    assert (await house.client.get("/healthz")).status_code == 200


def test_a_problem_says_all_of_itself_in_a_log_line() -> None:
    assert str(Problem(409, "kind", "What", "where; what to do")) == "What: where; what to do"


def test_the_first_fault_stands_for_the_others() -> None:
    told = unusable(FieldError("a", "it is missing"), FieldError("b", "it is past"))
    assert told.detail == "a: it is missing (and 1 more)"
