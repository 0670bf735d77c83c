"""What one message makes of a task of the gateway ends nothing for others."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Sequence

import pytest
from gateway_kit import House, gateway
from heartbeats import events
from sqlalchemy import select

from dray import supervision
from dray.gateway.live.stream import Hub
from dray.messages import Event, Heartbeat
from dray.messages.fact import PieceMade
from dray.store.historian import Historian
from dray.store.tables import events as kept_events

pytestmark = pytest.mark.anyio


async def test_a_stream_that_has_failed_goes_on(
    url: str, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    tick, again, failed = Hub.tick, asyncio.Event(), list[bool]()

    def fails_once(self: Hub) -> None:
        if not failed:
            failed.append(True)
            raise UnicodeEncodeError("utf-8", "\ud800", 0, 1, "surrogates not allowed")
        tick(self)
        again.set()

    monkeypatch.setattr(Hub, "tick", fails_once)
    monkeypatch.setattr(supervision, "FIRST_S", 0.0)
    async with gateway(url, fails=True) as house:
        async with asyncio.timeout(10.0):
            await again.wait()
        metrics = (await house.client.get("/metrics")).text
    assert 'dray_gateway_task_restarts_total{task="Hub"} 1.0' in metrics
    assert 'dray_gateway_task_restarts_total{task="Outbox"} 0.0' in metrics
    assert "Hub has failed" in "".join(
        record.message for record in caplog.records if record.levelno == logging.ERROR
    )


EVENTS = events("M1", *(PieceMade(goal="O-1/1", product="gear-unit-g1", made=made) for made in (1, 2, 3)))


async def test_an_event_that_cannot_be_written_is_counted_and_the_others_are_kept(
    house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    write = Historian._write

    async def writes_all_but_one(
        self: Historian, told: Sequence[Event], samples: Sequence[Heartbeat]
    ) -> None:
        if any(event.number == 2 for event in told):
            raise ValueError("a value that no database holds")
        await write(self, told, samples)

    monkeypatch.setattr(Historian, "_write", writes_all_but_one)
    await house.say(EVENTS)
    async with house.store.database.read() as connection:
        kept = (await connection.execute(select(kept_events.c.number).order_by(kept_events.c.number))).all()
    assert [number for (number,) in kept] == [1, 3]
    assert (house.historian.kept, house.historian.lost) == (2, 1)
    assert not house.historian.supervisor.restarts["writes"]
