"""Several gateways on one database keep the history of alerts once: no row twice, and none lost, whoever sees what first."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from typing import Any

import pytest
from fake_bus import FakeBus
from gateway_kit import House, gateway
from heartbeats import machine_heartbeat
from wall_clock import NOW_S, Wall

from dray.messages import MachineStatus
from dray.store.work import Work

pytestmark = pytest.mark.anyio


class Pair:
    """Two gateways that hear the same, on one database."""

    def __init__(self, first: House, second: House) -> None:
        self.first, self.second = first, second
        self._seq = 0

    def say(self, status: MachineStatus) -> None:
        """M8 tells both how it is."""
        self._seq += 1
        at_s = self.first.wall.now_s - NOW_S
        self.first.bus.say(machine_heartbeat("M8", self._seq, at_s=at_s, status=status, problem="spindle"))

    def later(self, seconds_s: float) -> None:
        self.first.wall.now_s += seconds_s

    async def history(self) -> list[tuple[float, float | None]]:
        """From when to when, newest first, counted from the beginning; both tell the same."""
        found: list[dict[str, Any]] = (await self.first.get("/api/alerts/history"))["items"]
        assert (await self.second.get("/api/alerts/history"))["items"] == found
        return [
            (each["since_at_s"] - NOW_S, each["ended_at_s"] and each["ended_at_s"] - NOW_S) for each in found
        ]


@pytest.fixture
async def pair(url: str) -> AsyncIterator[Pair]:
    bus, wall = FakeBus(), Wall()
    async with (
        gateway(url, bus=bus, wall=wall, gateway_name="gateway-1") as first,
        gateway(url, bus=bus, wall=wall, gateway_name="gateway-2", incarnation=2) as second,
    ):
        yield Pair(first, second)


async def test_what_both_see_is_written_once_from_its_beginning_to_its_end(pair: Pair) -> None:
    pair.say(MachineStatus.ERROR)
    await asyncio.gather(pair.first.alerts.look(), pair.second.alerts.look())
    assert await pair.history() == [(0, None)]
    pair.later(60)
    pair.say(MachineStatus.IDLE)
    await asyncio.gather(pair.first.alerts.look(), pair.second.alerts.look())
    assert await pair.history() == [(0, 60)]


async def test_what_comes_again_is_another_row_though_one_gateway_is_behind(pair: Pair) -> None:
    pair.say(MachineStatus.ERROR)
    await pair.first.alerts.look()
    await pair.second.alerts.look()
    pair.later(60)
    pair.say(MachineStatus.IDLE)
    await pair.first.alerts.look()
    pair.later(60)
    pair.say(MachineStatus.ERROR)
    await pair.first.alerts.look()
    # The second one was busy meanwhile: the end of the first alert is no end of the second.
    await pair.second.alerts.look()
    await pair.second.alerts.look()
    assert await pair.history() == [(120, None), (0, 60)]
    pair.later(60)
    pair.say(MachineStatus.IDLE)
    await pair.second.alerts.look()
    await pair.first.alerts.look()
    assert await pair.history() == [(120, 180), (0, 60)]


async def test_what_one_gateway_writes_down_late_is_not_there_twice(
    pair: Pair, monkeypatch: pytest.MonkeyPatch
) -> None:
    store = pair.second.store
    monkeypatch.setattr(pair.second.alerts, "_store", slow := _Slow(store.write))
    pair.say(MachineStatus.ERROR)
    await pair.first.alerts.look()
    late = asyncio.create_task(pair.second.alerts.look())
    await slow.waits.wait()
    pair.later(5)
    pair.say(MachineStatus.IDLE)
    await pair.first.alerts.look()
    slow.goes_on.set()
    await late
    await pair.second.alerts.look()
    assert await pair.history() == [(0, 5)]


async def test_the_one_that_goes_on_ends_what_the_other_has_begun(url: str) -> None:
    bus, wall = FakeBus(), Wall()
    async with gateway(url, bus=bus, wall=wall, gateway_name="gateway-2", incarnation=2) as second:
        async with gateway(url, bus=bus, wall=wall, gateway_name="gateway-1") as first:
            pair = Pair(first, second)
            pair.say(MachineStatus.ERROR)
            await first.alerts.look()
            await second.alerts.look()
        pair = Pair(second, second)
        pair._seq = 1
        pair.later(30)
        pair.say(MachineStatus.IDLE)
        await second.alerts.look()
        assert await pair.history() == [(0, 30)]


class _Slow:
    """A store to which one waits."""

    def __init__(self, write: Any) -> None:
        self._write = write
        self.waits, self.goes_on = asyncio.Event(), asyncio.Event()

    @asynccontextmanager
    async def _later(self) -> AsyncIterator[Work]:
        self.waits.set()
        await self.goes_on.wait()
        transaction: AbstractAsyncContextManager[Work] = self._write()
        async with transaction as work:
            yield work

    def write(self) -> AbstractAsyncContextManager[Work]:
        return self._later()
