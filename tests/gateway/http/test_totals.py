"""How many there are on all pages of a list, where that is cheap: orders, transports, tasks, alerts and the audit log."""

from __future__ import annotations

from typing import Any

import pytest
from gateway_kit import House
from heartbeats import events, machine_heartbeat
from sqlalchemy import select

from dray.messages import MachineStatus, Role, Transport
from dray.messages.fact import TaskOpened
from dray.store.database.counting import total_of
from dray.store.tables import orders

pytestmark = pytest.mark.anyio

DRAFT = {"from": "S3", "to": "M8", "item": "shaft", "quantity": 4}


async def fill(house: House) -> None:
    """Three orders, three transports, three tasks and three alerts; six lines of the audit log."""
    work = Transport("shaft", 4, ("S3",), "M8", "tote")
    for number in range(3):
        await house.place(reference=f"PO-{number}")
        assert (await house.client.post("/api/transports", json=DRAFT)).status_code == 201
        opened = TaskOpened(f"M8.1-{number}", 1, Role.PRIMARY, 1, work, 20.0, 300.0, 5.0)
        await house.say(events("M8", opened, first=number + 1))
        house.bus.say(
            machine_heartbeat(f"M{number + 1}", 1, at_s=0.0, status=MachineStatus.ERROR, problem="spindle")
        )
    await house.alerts.look()


LISTS = ("/api/orders", "/api/transports", "/api/tasks/history", "/api/alerts/history", "/api/audit")


@pytest.mark.parametrize("path", LISTS)
async def test_a_list_says_how_many_there_are_on_all_pages(house: House, path: str) -> None:
    await fill(house)
    all_of_it = await house.get(path)
    expected = len(all_of_it["items"])
    assert (all_of_it["total"], expected) == (expected, 6 if path == "/api/audit" else 3)
    first = await house.get(path, limit=2)
    assert (len(first["items"]), first["total"]) == (2, expected)
    second = await house.get(path, limit=2, cursor=first["next_cursor"])
    assert second["total"] == expected
    nothing = await house.get(path, q="nothing-is-called-this")
    assert (nothing["items"], nothing["total"]) == ([], 0)


@pytest.mark.parametrize("path", LISTS[:4])
async def test_words_on_several_pages_are_not_counted(house: House, path: str) -> None:
    await fill(house)
    words = {"/api/orders": "po", "/api/alerts/history": "spindle"}
    word: dict[str, Any] = {"q": words.get(path, "m8")}
    assert (await house.get(path, **word))["total"] == 3
    assert (await house.get(path, limit=2, **word))["total"] is None


async def test_very_many_are_not_counted_to_the_last_one(house: House) -> None:
    for _ in range(3):
        await house.place()
    async with house.store.database.read() as connection:
        assert await total_of(connection, select(orders.c.id), most=3) == 3
        assert await total_of(connection, select(orders.c.id), most=2) is None
