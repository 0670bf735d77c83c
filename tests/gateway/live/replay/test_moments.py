"""The picture of a moment of the past is the one that panels had then: with faults, at moments by chance, and for whoever sees less."""

from __future__ import annotations

import asyncio
import json
from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import Path
from random import Random
from typing import Any

import msgspec
import pytest
from databases import Files
from wall_clock import NOW_S, Wall

from dray.gateway.access.principal import ADMIN, SCOPES, Principal, Role, Scope
from dray.gateway.live.frames import COLLECTIONS
from dray.gateway.live.projection import Projection
from dray.gateway.live.replay.reader import ReplayReader
from dray.gateway.live.replay.recorder import Recorder
from dray.gateway.live.stream import Hub, scope_of
from dray.gateway.live.timescale import TimeScale
from dray.messages.keys import Keys
from dray.plant import Plant, default_plant
from dray.store import Store
from dray.store.database.database import Database
from dray_sim.clock.loop import clock, run
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.people import demand
from dray_sim.people.order_client import OrderClient

OPERATOR = Principal(
    kind="person",
    id="operator",
    name="Operator",
    role=Role.OPERATOR,
    scopes=SCOPES[Role.OPERATOR],
    areas=frozenset({"area1"}),
)
NO_ORDERS = Principal(kind="key", id="k", name="Screen", scopes=frozenset({Scope.FACTORY_READ}))
CALLERS = (ADMIN, NO_ORDERS, OPERATOR)

STEP_S = 1.0
"""Of the factory's clock, which jumps: nothing waits for it."""

PIECE_S = 30
FAULT_EVERY_S = 45
"""A vehicle or a machine's agent fails so often, and is back half a minute later."""

Shown = dict[str, str]


def shown(frame: Any) -> Shown:
    """By kind, the digest of all that is told of it: thousands of pictures are more than memory holds."""
    told = msgspec.to_builtins(frame)
    digests: Shown = {}
    for kind, name in COLLECTIONS.items():
        views = sorted(told[name], key=lambda each: str(each["id"]))
        digests[kind] = sha256(json.dumps(views, sort_keys=True).encode()).hexdigest()
    return digests


@dataclass
class Day:
    """A recorded time, and what panels had at some of its moments."""

    projection: Projection
    recorder: Recorder
    hub: Hub
    moments: dict[float, tuple[Any, dict[str, Shown]]] = field(default_factory=dict)
    """Wall clock -> the figures, and per caller what it saw."""
    faults: int = 0


def recorded(store: Store, length_s: int, moments: int) -> Day:
    plant, wall, chance = default_plant(), Wall(), Random(18)
    projection = Projection(plant.file, TimeScale(0.0, NOW_S))
    recorder = Recorder(projection, store, wall, name="g.1", kept_s=1e6)
    hub = Hub(
        projection,
        wall_s=wall,
        steady_s=wall,
        rate_hz=10.0,
        queue_frames=4,
        clients=2,
        each=2,
        record=recorder.note,
    )
    day = Day(projection, recorder, hub)
    chosen = set(chance.sample(range(10, length_s), moments))

    async def main() -> None:
        factory = SimFactory(plant, clock(), seed=18)
        session = factory.bus.join("panel", lambda _sender, message: projection.fold(message))
        session.subscribe(Keys(plant.id).all_heartbeats)
        session.subscribe(Keys(plant.id).all_events)
        orders = demand.orders(plant, Random(18), load=0.85, until_s=float(length_s))
        async with asyncio.TaskGroup() as group:
            tasks = [
                group.create_task(factory.run()),
                group.create_task(OrderClient(factory.bus, factory.clock).place(orders)),
            ]
            for step in range(length_s):
                await asyncio.sleep(STEP_S)
                wall.now_s += STEP_S
                day.faults += trouble(factory, plant, step, chance)
                projection.look(wall.now_s)
                hub.tick()
                if step % PIECE_S == PIECE_S - 1:
                    recorder.cut()
                if step in chosen:
                    seen = {
                        who.id: shown(scope_of(projection, who).snapshot(0, wall.now_s)) for who in CALLERS
                    }
                    day.moments[wall.now_s] = hub._factory, seen
            for task in tasks:
                task.cancel()

    run(main())
    return day


def trouble(factory: SimFactory, plant: Plant, step: int, chance: Random) -> int:
    """Agents crash and are started again, each in its turn."""
    agents = [*sorted(spec.id for spec in plant.file.fleet), *sorted(plant.machines)]
    turn, at = divmod(step, FAULT_EVERY_S)
    agent = agents[(turn * 7) % len(agents)]
    if at == 15 and factory.running(agent):
        factory.crash(agent)
        return 1
    if at == 40 and not factory.running(agent):
        factory.restart(agent)
    return 0


async def compare(store: Store, day: Day, chance: Random) -> None:
    reader = ReplayReader(store, None, day.projection)
    for wall_s, (figures, seen) in day.moments.items():
        # Between this second's frame and the next one nothing else was shown.
        asked_s = wall_s + chance.uniform(0.0, 0.99)
        for who in CALLERS:
            film = await reader.film(who, asked_s, asked_s, 0.0, lambda film: film)
            assert film is not None
            assert film.snapshot.at_s <= asked_s
            assert shown(film.snapshot) == seen[who.id], (who.id, wall_s)
            if who is ADMIN:
                assert film.snapshot.factory == figures


def play(files: Files, tmp_path: Path, length_s: int, moments: int) -> Day:
    async def opened() -> Store:
        return Store(await Database.open(files.new(tmp_path)))

    async def read(day: Day) -> None:
        store = await opened()
        day.recorder._store = store
        await day.recorder.write()
        await compare(store, day, Random(1))
        await store.close()

    day = recorded(None, length_s, moments)  # type: ignore[arg-type]
    asyncio.run(read(day))
    return day


def test_a_moment_that_is_shown_again_is_what_panels_showed_then(files: Files, tmp_path: Path) -> None:
    day = play(files, tmp_path, 700, 60)
    assert len(day.moments) == 60
    assert day.faults >= 10


@pytest.mark.campaign
@pytest.mark.timeout(1800)
def test_at_1000_moments_of_an_hour_with_faults_it_is_what_panels_showed_then(
    files: Files, tmp_path: Path
) -> None:
    day = play(files, tmp_path, 3600, 1000)
    assert len(day.moments) == 1000
    assert day.faults > 30
