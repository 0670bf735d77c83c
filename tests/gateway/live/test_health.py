"""Health tells of every part how it is, and calls a gateway ready only when it can take orders."""

from __future__ import annotations

import asyncio
from typing import Any

import pytest
from answers import problem
from fake_bus import FakeBus
from gateway_kit import House, draft, gateway
from heartbeats import events
from postgres_databases import Postgres

from dray.errors import UnavailableError
from dray.gateway.live import health, strategist_probe
from dray.messages import EventsAsked, EventsKept, Message, StrategistHeartbeat
from dray.messages.fact import LinkChanged
from dray.messages.link import Link
from dray.store.history.events import Events
from dray.store.work import Work

pytestmark = pytest.mark.anyio


async def parts(house: House) -> dict[str, dict[str, Any]]:
    """Of a gateway that is ready."""
    answer = await house.get("/readyz")
    assert answer["status"] == "ready"
    told: dict[str, dict[str, Any]] = answer["parts"]
    return told


def answering_strategist(bus: FakeBus) -> None:
    """Let a strategist join that only tells that it is there."""

    def receive(sender: str, message: Message) -> None:
        if isinstance(message, EventsAsked):
            bus.tell("strategist", sender, EventsKept(incarnation=1, first=1, last=0, life=1))

    bus.join("strategist", receive)


async def test_a_gateway_with_all_its_parts_is_ready(url: str) -> None:
    bus = FakeBus()
    answering_strategist(bus)
    async with gateway(url, bus=bus) as house:
        await asyncio.sleep(0)
        told = await parts(house)
    assert {name: part["ok"] for name, part in told.items()} == {
        "database": True,
        "bus": True,
        "strategist": True,
        "historian": True,
    }
    assert told["historian"] == {"ok": True, "behind_s": 0.0, "waiting": 0}


async def test_the_process_lives_whatever_else_is_gone(house: House, monkeypatch: pytest.MonkeyPatch) -> None:
    house.peer.leave()
    monkeypatch.setattr(Work, "ping", away)
    assert await house.get("/healthz") == {"status": "ok"}


async def away(_work: Work) -> None:
    raise UnavailableError("database", "disk I/O error", "wait")


async def refused(house: House) -> dict[str, str]:
    """Why a gateway is not ready, by part."""
    answer = await house.client.get("/readyz")
    told = problem(answer, 503, "not-ready")
    assert int(answer.headers["retry-after"]) > 0
    return {error["field"]: error["reason"] for error in told["errors"]}


async def test_a_database_that_does_not_answer_is_named(
    house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Work, "ping", away)
    assert await refused(house) == {"database": "it does not answer"}


async def test_a_database_that_says_nothing_is_not_waited_for(
    house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def hang(_work: Work) -> None:
        await asyncio.Event().wait()

    monkeypatch.setattr(Work, "ping", hang)
    monkeypatch.setattr(health, "PATIENCE_S", 0.001)
    assert await refused(house) == {"database": "it has not answered within 0.001 s"}


async def test_a_database_that_cannot_be_written_is_named(house: House) -> None:
    house.historian.failing = True
    assert await refused(house) == {"database": "it cannot be written"}


async def test_a_server_that_is_stopped_is_told_and_forgiven(postgres: Postgres, postgresql_url: str) -> None:
    async with gateway(postgresql_url) as house:
        postgres.stop()
        try:
            assert set(await refused(house)) == {"database"}
            answer = await house.client.post("/api/orders", json=draft())
            problem(answer, 503, "database-away")
        finally:
            postgres.start()
        assert (await parts(house))["database"] == {"ok": True}
        assert (await house.client.post("/api/orders", json=draft())).status_code == 201


async def test_a_bus_that_was_left_is_named(house: House) -> None:
    house.peer.leave()
    assert await refused(house) == {"bus": "the gateway is not on it"}


async def test_an_absent_strategist_is_told_and_keeps_nobody_from_ordering(house: House) -> None:
    assert (await parts(house))["strategist"] == {"ok": False, "reason": "nothing was heard of it yet"}


async def test_a_strategist_that_falls_silent_is_told(house: House, monkeypatch: pytest.MonkeyPatch) -> None:
    house.bus.tell("strategist", "gateway", EventsKept(incarnation=1, first=1, last=0, life=1))
    assert (await parts(house))["strategist"]["ok"]
    monkeypatch.setattr(strategist_probe, "SILENCE_S", -1.0)
    told = (await parts(house))["strategist"]
    assert not told["ok"]
    assert told["silent_s"] >= 0.0


async def test_of_several_strategists_one_that_is_away_is_told_and_orders_wait_when_all_are(
    url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    now_s = 0.0
    monkeypatch.setattr(strategist_probe, "_now_s", lambda: now_s)
    async with gateway(url, strategists=2) as house:
        for each in ("strategist", "strategist2", "strategist3"):
            house.bus.tell(each, "gateway", StrategistHeartbeat(each, 1, 1, 0.0, 0))
        assert (await parts(house))["strategist"] == {"ok": True, "silent_s": 0.0}
        now_s = strategist_probe.SILENCE_S
        house.bus.tell("strategist2", "gateway", StrategistHeartbeat("strategist2", 1, 2, 9.0, 0))
        now_s += 1.0
        told = (await parts(house))["strategist"]
        assert told == {
            "ok": True,
            "reason": "nothing is heard of strategist; the others go on with its orders",
            "silent_s": 1.0,
        }
        now_s += strategist_probe.SILENCE_S
        assert not (await parts(house))["strategist"]["ok"]


async def test_a_historian_that_does_not_keep_up_says_by_how_much(
    house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    held = asyncio.Event()
    add = Events.add

    async def slow(self: Events, *args: Any) -> None:
        await held.wait()
        await add(self, *args)

    monkeypatch.setattr(Events, "add", slow)
    monkeypatch.setattr(health, "BEHIND_S", -1.0)
    house.bus.say(*events("ATV1", LinkChanged(link=Link.MESH)))
    await asyncio.sleep(0)
    await asyncio.sleep(0)
    house.bus.say(*events("ATV1", LinkChanged(link=Link.WLAN), first=2))
    told = (await parts(house))["historian"]
    assert not told["ok"]
    assert told["reason"] == "it does not keep up"
    assert told["behind_s"] >= 0.0
    assert told["waiting"] >= 1
    held.set()
    await house.historian.written()
    assert house.historian.behind_s == 0.0
    assert house.historian.kept == 2
