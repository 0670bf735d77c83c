"""A running gateway per test on a database of its own, and what is in `kits`."""

from __future__ import annotations

import asyncio
import sys
from collections.abc import AsyncIterator, Iterator
from pathlib import Path

import httpx
import pytest

sys.path.insert(0, str(Path(__file__).parent / "kits"))

from databases import Files
from facts_kit import SPEED
from fake_bus import PLANT
from fake_injector import FakeInjector
from gateway_kit import House, gateway
from wall_clock import NOW_S

from dray.gateway.factory.carrying import Carrying
from dray.gateway.factory.closings import Closings
from dray.gateway.factory.exclusions import Exclusions
from dray.gateway.http import bounded_process
from dray.gateway.live.projection import Projection
from dray.gateway.live.timescale import TimeScale
from dray.gateway.orders import outbox
from dray.gateway.schedules.scheduler import Scheduler


@pytest.fixture(scope="session")
def anyio_backend() -> str:
    return "asyncio"


@pytest.fixture(scope="module", autouse=True)
def side_work_stands_back_for_nobody() -> Iterator[None]:
    """A nice process gets a tenth of the processor beside other tests, of which no person waits for any."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(bounded_process, "NICE", 0)
        yield


@pytest.fixture(autouse=True)
def nothing_is_repeated(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """What agents do not answer is said once, however slow the machine is; a test of repetitions says its pauses."""
    if "url" in request.fixturenames:
        monkeypatch.setattr(outbox, "PAUSE_S", (3600.0, 3600.0))
        for repeats in (Carrying, Closings, Exclusions):
            monkeypatch.setattr(repeats, "EVERY_S", 3600.0)


@pytest.fixture
def asked_by_the_test_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """The scheduler looks when the test says so, and not when a schedule is new."""
    monkeypatch.setattr(Scheduler, "run", lambda _: asyncio.Event().wait())


@pytest.fixture
async def house(url: str) -> AsyncIterator[House]:
    """A running gateway, with nobody else on the bus."""
    async with gateway(url) as house:
        yield house


@pytest.fixture
async def two_houses(url: str) -> AsyncIterator[tuple[House, House]]:
    """Two gateways of one plant on one database."""
    async with (
        gateway(url) as first,
        gateway(url, bus=first.bus, wall=first.wall, gateway_name="g2") as other,
    ):
        yield first, other


@pytest.fixture(scope="module")
async def quiet_house(files: Files, tmp_path_factory: pytest.TempPathFactory) -> AsyncIterator[House]:
    """One gateway for all tests of a module that leave nothing behind in it, with a fault injector."""
    async with gateway(files.new(tmp_path_factory.mktemp("quiet")), faults=FakeInjector()) as house:
        yield house


@pytest.fixture
async def visitor(house: House) -> AsyncIterator[httpx.AsyncClient]:
    """The browser of somebody who has not logged in."""
    async with house.visitor() as client:
        yield client


@pytest.fixture
def projection() -> Projection:
    """What panels see, before anybody has said anything."""
    return Projection(PLANT, TimeScale(0.0, NOW_S, SPEED))
