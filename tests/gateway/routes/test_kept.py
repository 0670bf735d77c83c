"""What is kept for how long is told, with the oldest that there is and before when nothing is any more."""

from __future__ import annotations

from typing import Any

import pytest
from gateway_kit import House, draft, gateway
from heartbeats import machine_heartbeat
from wall_clock import NOW_S

from dray.messages import Event, MachineStatus
from dray.messages.fact import MemoryLost

pytestmark = pytest.mark.anyio

DAY_S = 86_400.0


async def kept(house: House) -> dict[str, dict[str, Any]]:
    return {each["kind"]: each for each in (await house.get("/api/kept"))["items"]}


async def test_each_kind_has_its_days_and_orders_have_none(house: House) -> None:
    found = await kept(house)
    assert [each["days"] for each in found.values()] == [None, 14, 14, 3, 400, 35, 400, 400, 400, 400]
    assert found["orders"]["gone_before_at_s"] is None
    assert found["events"]["gone_before_at_s"] == NOW_S - 14 * DAY_S
    assert found["tasks"]["since_at_s"] is None


async def test_the_oldest_of_each_kind_is_told(house: House) -> None:
    await house.client.post("/api/orders", json=draft())
    house.bus.say(machine_heartbeat("M8", 1, at_s=0.0, status=MachineStatus.ERROR, problem="spindle"))
    await house.alerts.look()
    async with house.store.write() as work:
        await work.events.add(
            [Event(agent="M8", incarnation=1, number=1, at_s=5.0, fact=MemoryLost(reason=""))],
            lambda s: NOW_S + s,
        )
    found = await kept(house)
    assert found["orders"]["since_at_s"] == NOW_S
    assert found["alerts"]["since_at_s"] == NOW_S
    assert found["events"]["since_at_s"] == NOW_S + 5
    assert not found["events"]["is_full"]


async def test_a_log_with_as_many_rows_as_may_be_says_that_it_forgets_early(url: str) -> None:
    async with gateway(url, events_most=1000, replay_days=0) as house:
        events = [
            Event(agent="M8", incarnation=1, number=n, at_s=n, fact=MemoryLost(reason=""))
            for n in range(1, 1001)
        ]
        async with house.store.write() as work:
            await work.events.add(events, lambda s: NOW_S - 2000 + s)
        found = await kept(house)
    assert found["events"]["is_full"]
    assert found["events"]["gone_before_at_s"] == found["events"]["since_at_s"] == NOW_S - 1999
    assert (found["replay"]["days"], found["replay"]["gone_before_at_s"]) == (0, None)
