"""The body of a real vehicle, as its agent's process makes it: broker, vehicle and agent in any order."""

from __future__ import annotations

import asyncio
import logging
import sys
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import asynccontextmanager, contextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "simulation/kits"))
sys.path.insert(0, str(Path(__file__).parents[2] / "adapters/vda5050"))
from brokers import TestBroker
from yard import LIGHT, PICK, PLANT, Yard, drive

from dray.adapters.system_clock import SystemClock
from dray.adapters.vda5050.body import VehicleBody
from dray.adapters.vda5050.link import BrokerAddress
from dray.body import (
    ActionDone,
    ActionFailed,
    ProblemCleared,
    ProblemRaised,
    Report,
    WayDone,
)
from dray.cli.runtime.bodies import on_floor
from dray.cli.runtime.bodies.embodied import Embodied
from dray.cli.runtime.bodies.on_floor import counted_on_floor
from dray.cli.runtime.bodies.vda5050 import RealVehicle, by_vda5050
from dray.cli.runtime.surroundings import Surroundings
from dray.errors import SettingsError, UnavailableError
from dray.settings import Settings
from dray_sim.vda5050.on_broker import VehicleOnBroker, on_broker, words_of

SPEED = 20.0
"""Of the plant's clock: a way of 10 m takes half a second."""

PATIENCE_S = 60.0


@pytest.fixture
def broker(tmp_path: Path) -> Any:
    broker = TestBroker(tmp_path)
    yield broker
    broker.stop()


class Hall:
    """One vehicle and one agent's body, on one broker."""

    def __init__(self, folder: Path, broker: TestBroker) -> None:
        self.settings = Settings(
            body="vda5050",
            broker=broker.url,
            manufacturer="Yard",
            serial="4711",
            profile="dray-sim",
            journal_folder=folder / "journals",
            plant_speed=SPEED,
        )
        self.where = Surroundings(self.settings, PLANT)
        self.life = 0
        self.heard: list[Report] = []
        self._changed = asyncio.Event()
        self.clock = SystemClock(asyncio.get_running_loop(), speed=SPEED)
        yard = Yard()
        yard.clock = self.clock  # type: ignore[assignment]
        self.sim = yard.vehicle()

    def vehicle(self) -> Any:
        host, port = "127.0.0.1", int(self.settings.broker.rpartition(":")[2])
        words = words_of("3.0", "Yard", "4711", "hall")
        broker = BrokerAddress(host, port, tls=False)
        return on_broker(VehicleOnBroker(self.sim, LIGHT, PLANT, self.clock, broker, words))

    @asynccontextmanager
    async def agent(self) -> AsyncIterator[VehicleBody]:
        self.life += 1
        embody = by_vda5050(self.where, "ATV1", LIGHT, RealVehicle.of(self.settings))
        async with embody(None, SimpleNamespace(incarnation=self.life)) as embodied:  # type: ignore[arg-type]
            assert isinstance(embodied.body, VehicleBody)
            embodied.body.attach(self._hear)
            yield embodied.body

    def _hear(self, report: Report) -> None:
        self.heard.append(report)
        self._changed.set()

    async def until(self, holds: Callable[[], bool]) -> None:
        async with asyncio.timeout(PATIENCE_S):
            while not holds():
                self._changed.clear()
                await self._changed.wait()


@contextmanager
def logged(words: str) -> Iterator[asyncio.Event]:
    """An event that is set once a warning has these words."""
    told, handler = asyncio.Event(), logging.Handler(logging.WARNING)

    def take(record: logging.LogRecord) -> None:
        if words in record.getMessage():
            told.set()

    handler.emit = take  # type: ignore[method-assign]
    logging.getLogger().addHandler(handler)
    try:
        yield told
    finally:
        logging.getLogger().removeHandler(handler)


def test_a_real_vehicle_is_driven_over_a_broker_by_one_life_of_its_agent_after_the_other(
    tmp_path: Path, broker: TestBroker
) -> None:
    async def play() -> None:
        hall = Hall(tmp_path, broker)
        starting = hall.agent()
        with logged("the broker is away: mqtt://127.0.0.1") as told:
            begun = asyncio.create_task(starting.__aenter__())
            await told.wait()
        await asyncio.to_thread(broker.start)
        async with hall.vehicle():
            body = await begun
            await body.placed.wait()
            body.instruct(PICK)
            await hall.until(lambda: ActionDone(order=5) in hall.heard)
            await starting.__aexit__(None, None, None)
            async with hall.agent() as body:
                await body.placed.wait()
                assert body.sense().load == "shaft"  # type: ignore[union-attr]
                body.instruct(drive("west", "middle", "east", order=1006))
                await hall.until(lambda: WayDone(order=1006, node="east") in hall.heard)
                await asyncio.to_thread(broker.stop)
                await hall.until(lambda: any(isinstance(report, ProblemRaised) for report in hall.heard))
                assert "the broker is away: mqtt://127.0.0.1" in next(
                    report.reason for report in hall.heard if isinstance(report, ProblemRaised)
                )
                await asyncio.to_thread(broker.start)
                await hall.until(lambda: isinstance(hall.heard[-1], ProblemCleared))
                body.instruct(drive("east", "middle", order=1007))
                await hall.until(lambda: WayDone(order=1007, node="middle") in hall.heard)
        assert not any(isinstance(report, ActionFailed) for report in hall.heard)

    async def bounded() -> None:
        async with asyncio.timeout(5 * PATIENCE_S):
            await play()

    asyncio.run(bounded())


def test_a_real_vehicle_at_simulated_places_is_lost_when_the_floor_counts_no_more(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    yard, told = Yard(), []

    async def tell(_session: Any, plant: str, vehicle: str, life: int, done: Any = None) -> str:
        told.append((plant, vehicle, life, done))
        if done is not None:
            raise UnavailableError("the floor", "nobody answers", "start it")
        return ""

    @asynccontextmanager
    async def embody(_bus: Any, _journal: Any) -> AsyncIterator[Embodied]:
        yield Embodied(yard.vehicle(), asyncio.Event().wait)

    async def play() -> None:
        monkeypatch.setattr(on_floor, "tell_moved", tell)
        where = Surroundings(Settings(), PLANT)
        make = counted_on_floor(where, "ATV1", embody)
        async with make(SimpleNamespace(inner=None), SimpleNamespace(incarnation=3)) as embodied:  # type: ignore[arg-type]
            assert told == [(PLANT.id, "ATV1", 3, None)]
            embodied.body.instruct(PICK)  # type: ignore[union-attr]
            embodied.body._on_report(ActionDone(order=PICK.order))  # type: ignore[union-attr]
            with pytest.raises(UnavailableError, match="nobody answers"):
                await embodied.lost()
        assert told[1:] == [(PLANT.id, "ATV1", 3, PICK)]

    asyncio.run(play())


@pytest.mark.parametrize("missing", ["broker", "manufacturer", "serial"])
def test_what_is_missing_of_a_real_vehicle_is_said(missing: str) -> None:
    given = {"broker": "mqtt://b", "manufacturer": "M", "serial": "1"} | {missing: ""}
    with pytest.raises(
        SettingsError, match=f"--{missing}: a body by VDA 5050 needs it; or DRAY_{missing.upper()}"
    ):
        RealVehicle.of(Settings(**given))


def test_a_profile_that_is_none_is_said_by_its_place(tmp_path: Path) -> None:
    given = {"broker": "mqtt://b", "manufacturer": "M", "serial": "1"}
    with pytest.raises(SettingsError, match="no profile of that name among default, dray-sim, flowing"):
        RealVehicle.of(Settings(**given, profile="nobody"))
    file = tmp_path / "p.yaml"
    for text, words in (
        ("base: 3", "unknown field `base`"),
        ("version: '4.0'", "Invalid enum value '4.0'"),
        ("horizon: 3", "horizon: a vehicle without updates never drives it"),
        ("pick: {type: x, parameters: {a: '{who}'}}", "x: no parameter can be 'who'"),
        ("- 1", "Expected `object`"),
        ("{", "p.yaml"),
    ):
        file.write_text(text, encoding="utf-8")
        with pytest.raises(SettingsError, match=words):
            RealVehicle.of(Settings(**given, profile=str(file)))


@pytest.mark.parametrize("text", ["b:1883", "http://b", "mqtt://u:p@b"])
def test_a_broker_that_is_no_address_is_refused(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(SettingsError, match=r"--broker: .*write it as mqtt://HOST:1883") as refused:
        Settings.load(broker=text)
    assert (text in str(refused.value)) is ("@" not in text), "a password is not shown"
