"""Whoever has a link asks every five seconds, without a login: no question of theirs may read a history."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest
from gateway_kit import gateway
from sqlalchemy import event
from sqlalchemy.engine import Engine
from tracking_kit import GOAL, MACHINE, Story

from dray.messages.fact import PromiseMoved
from dray.store.work import open_store

pytestmark = pytest.mark.anyio


@contextmanager
def listening() -> Iterator[list[tuple[str, Any]]]:
    """What SQL is told, with its parameters, as long as the context lasts."""
    told: list[tuple[str, Any]] = []

    def note(_connection: Any, _cursor: Any, statement: str, parameters: Any, *_: Any) -> None:
        told.append((statement, parameters))

    event.listen(Engine, "before_cursor_execute", note)
    try:
        yield told
    finally:
        event.remove(Engine, "before_cursor_execute", note)


async def plans(url: str, told: list[tuple[str, Any]], *, analyzed: bool) -> dict[str, list[str]]:
    """How SQLite would answer each question about events, by the question."""
    store = await open_store(url)
    found: dict[str, list[str]] = {}
    try:
        async with store.database.write() as connection:
            if analyzed:
                await connection.exec_driver_sql("ANALYZE")
            for statement, parameters in told:
                if statement.startswith("SELECT") and "events" in statement:
                    rows = await connection.exec_driver_sql(f"EXPLAIN QUERY PLAN {statement}", parameters)
                    found[statement] = [row.detail for row in rows]
    finally:
        await store.close()
    return found


@pytest.mark.parametrize("analyzed", [False, True])
async def test_a_customers_page_asks_for_its_own_events_alone(sqlite_url: str, analyzed: bool) -> None:
    async with gateway(sqlite_url) as house:
        story = await Story.begin(house)
        await story.planned()
        await story.making(made=4)
        await story.tell(MACHINE, 160.0, PromiseMoved(GOAL, 900.0, 1))
        with listening() as told:
            await story.state()
            await story.page()
    found = await plans(sqlite_url, told, analyzed=analyzed)
    assert len(found) >= 2
    _no_scan(found)


@pytest.mark.parametrize("analyzed", [False, True])
async def test_the_events_of_an_order_are_found_by_what_they_name(sqlite_url: str, analyzed: bool) -> None:
    async with gateway(sqlite_url) as house:
        with listening() as told:
            answer = await house.client.get("/api/events", params={"order": "O-1"})
    assert answer.status_code == 200
    found = await plans(sqlite_url, told, analyzed=analyzed)
    assert found
    _no_scan(found)


def _no_scan(found: dict[str, list[str]]) -> None:
    """Nothing reads all events, nor all of one kind or agent."""
    for statement, plan in found.items():
        for step in plan:
            if "events" in step or "opened" in step or "named" in step:
                assert step.startswith("SEARCH"), (statement, plan)
                assert "(kind=?" not in step, (statement, plan)
                assert "(agent=?" not in step, (statement, plan)
