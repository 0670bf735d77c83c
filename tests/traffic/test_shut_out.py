"""A vehicle that dies at the dock of a storage: what is kept there is fetched elsewhere, until it is back."""

from __future__ import annotations

import asyncio
from random import Random

import pytest

from dray.messages import Event, Message, ObstacleSeen, Phase, TaskAnnounced, Transport
from dray.messages.fact import PhaseEntered, TaskClosed
from dray.plant import Plant, default_plant
from dray_sim.checks.floor.held_places import HeldPlaces
from dray_sim.checks.floor.overlaps import Overlaps
from dray_sim.checks.invariants import Invariants
from dray_sim.clock.loop import JUMP, clock, run
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.network.listeners import Listeners
from dray_sim.people import demand
from dray_sim.people.order_client import OrderClient

DIES_AFTER_S = 900.0
"""By then storages are left with what was not fetched yet, and all vehicles have worked."""

ARRIVES_WITHIN_S = 270.0
"""From the death of a carrier at a storage until its load has come from another one: it is taken over (4 s), waited for (30 s), given
back, and carried as any other (110 s in most cases)."""

FORGOTTEN_WITHIN_S = 30.0
"""From the moment at which it is switched on again."""


class Heard:
    """What is heard of a vehicle that dies while it stands at a storage, and of its load."""

    def __init__(self, plant: Plant) -> None:
        self._plant = plant
        self._works: dict[str, Transport] = {}
        self._source: dict[str, str] = {}
        """Task -> where it was fetched last."""
        self.at_storage: tuple[str, str, str] | None = None
        """A vehicle that is about to load at a storage, its task, and the storage."""
        self.stands = asyncio.Event()
        self.died_s: float | None = None
        self.came = asyncio.Event()
        self.arrived: list[tuple[float, str]] = []
        """When the same material has come to the same place since, and from where."""
        self.obstacles: list[ObstacleSeen] = []
        self.forgotten = asyncio.Event()
        """Somebody has told that a way is free again."""

    def on_message(self, at_s: float, sender: str, _address: str, message: Message) -> None:
        if type(message) is TaskAnnounced and isinstance(message.work, Transport):
            self._works[message.task] = message.work
        elif type(message) is ObstacleSeen:
            self.obstacles.append(message)
            if not message.there:
                self.forgotten.set()
        elif type(message) is not Event:
            return
        elif type(message.fact) is PhaseEntered and message.fact.phase is Phase.LOADING:
            self._source[message.fact.task] = message.fact.station
            if self.died_s is None and message.fact.station in self._plant.storages:
                self.at_storage = sender, message.fact.task, message.fact.station
                self.stands.set()
        elif type(message.fact) is TaskClosed and message.fact.outcome == "delivered":
            self._note_delivered(at_s, message.fact.task)

    def _note_delivered(self, at_s: float, task: str) -> None:
        if self.died_s is None or self.at_storage is None or task not in self._works:
            return
        wanted, got = self._works[self.at_storage[1]], self._works[task]
        if (got.item, got.destination) == (wanted.item, wanted.destination):
            self.arrived.append((at_s - self.died_s, self._source[task]))
            self.came.set()


async def with_one_dead_at_a_storage(seed: int) -> tuple[Heard, str]:
    plant, listeners = default_plant(), Listeners()
    heard = Heard(plant)
    factory = SimFactory(plant, clock(), seed=seed, listener=listeners, traffic=True)
    invariants = Invariants(factory, HeldPlaces(factory), Overlaps(factory.vehicles))
    listeners.add(heard, invariants)
    orders = list(demand.orders(plant, Random(seed), load=0.9, until_s=3600.0))
    tasks = [
        asyncio.create_task(factory.run()),
        asyncio.create_task(OrderClient(factory.bus, factory.clock).place(orders)),
    ]
    await asyncio.sleep(DIES_AFTER_S)
    heard.at_storage = None
    heard.stands.clear()
    await heard.stands.wait()
    assert heard.at_storage is not None
    dead, _task, storage = heard.at_storage
    heard.died_s = factory.clock.now_s()
    factory.power_off(dead)
    async with asyncio.timeout(ARRIVES_WITHIN_S):
        await heard.came.wait()
    told = [seen for seen in heard.obstacles if seen.there]
    assert told, "who has waited for it has told"
    assert plant.node_of(storage) in {node for seen in told for node in (seen.start, seen.end)}
    heard.obstacles.clear()
    heard.forgotten.clear()
    factory.power_on(dead)
    async with asyncio.timeout(FORGOTTEN_WITHIN_S):
        await heard.forgotten.wait()
    for task in tasks:
        task.cancel()
    await asyncio.gather(*tasks, return_exceptions=True)
    return heard, invariants.broken or ""


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_what_a_dead_vehicle_blocks_comes_from_another_storage_and_it_is_forgotten_when_it_is_back(
    seed: int,
) -> None:
    heard, broken = run(with_one_dead_at_a_storage(seed), JUMP)
    assert broken == ""
    assert heard.at_storage is not None
    assert heard.arrived[0][1] != heard.at_storage[2]
    assert [seen.there for seen in heard.obstacles][:1] == [False]
