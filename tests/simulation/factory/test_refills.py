"""Vehicles refill storages, whatever is lost: every order is delivered, and every piece is where it is told to be."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from contextlib import suppress

import pytest
from msgspec.structs import replace
from variants import later

from dray.messages import AtvHeartbeat, Closure, ClosureKind, Event, Message
from dray.messages.fact import TaskOpened
from dray.plant import Plant, Warehouse
from dray.plant.file.file import shipped_plant
from dray_sim.people.floor_manager import Closing, FloorManager
from dray_sim.plants.supplied import refilled_by_vehicles, straight_from_the_warehouse
from dray_sim.run.evidence import HELD
from dray_sim.run.stage import Played, Shift, Stage, play

ORDERS = 6

Meddle = Callable[[Stage], Awaitable[None]]

REFILLED = refilled_by_vehicles(shipped_plant("workshop").file)

SHORT = replace(
    REFILLED,
    storages=tuple(
        replace(
            storage,
            stocks=tuple(
                replace(kept, capacity=2 * {item.id: item.lot for item in REFILLED.materials}[kept.material])
                for kept in storage.stocks
            ),
        )
        for storage in REFILLED.storages
    ),
)
"""With so little room that storages order all the time."""


class Refills:
    """What storages order for themselves."""

    def __init__(self) -> None:
        self.tasks: dict[str, str] = {}
        """Its storage, by task."""
        self.more = asyncio.Event()

    def on_message(self, _at_s: float, sender: str, _address: str, message: Message) -> None:
        if type(message) is Event and type(message.fact) is TaskOpened and "-refill-" in message.fact.task:
            self.tasks[message.fact.task] = sender
            self.more.set()


class Coming:
    """Whether a vehicle is on its way to RACK for its station."""

    def __init__(self) -> None:
        self._heard = asyncio.Event()

    def on_message(self, _at_s: float, _sender: str, _address: str, message: Message) -> None:
        if type(message) is AtvHeartbeat and message.task is not None and message.task.coordinator == "RACK":
            self._heard.set()

    async def wait(self) -> None:
        """Wait until one says so from now on."""
        self._heard.clear()
        await self._heard.wait()


def played(plant: Plant, meddle: Meddle | None = None, orders: int = ORDERS) -> tuple[Played[int], Refills]:
    """Orders of a lot of each product in turn, while something is done to the factory."""
    refills = Refills()

    async def script(stage: Stage) -> int:
        stage.listeners.add(refills)
        meddling = None if meddle is None else asyncio.create_task(meddle(stage))
        for number in range(orders):
            product = plant.ordered[number % len(plant.ordered)]
            stage.order(product, 3 * plant.products[product].lot, 7200.0)
            await asyncio.sleep(120.0)
        if meddling is not None:
            await meddling
        await stage.settle(6 * 3600.0)
        await asyncio.sleep(600.0)
        return len(stage.undelivered())

    return play(Shift(name="refills", duration_s=3600.0, stock_frac=(0.0, 0.2)), plant, 1, script), refills


def all_is_well(run: Played[int]) -> None:
    assert run.invariants == HELD
    assert run.result == 0


def test_storages_order_and_vehicles_bring() -> None:
    run, refills = played(Plant(SHORT))
    all_is_well(run)
    assert len(refills.tasks) >= 5
    assert set(refills.tasks.values()) == {"RACK", "PAINT"}


def test_straight_from_the_warehouse_nothing_is_refilled() -> None:
    run, refills = played(Plant(straight_from_the_warehouse(shipped_plant("workshop").file)))
    all_is_well(run)
    assert not refills.tasks


async def _killed_as_it_gives(stage: Stage) -> None:
    """Kill the warehouse's station at the moment when a vehicle has taken a load, before it has noted that."""
    factory, warehouse = stage.factory, stage.factory.storages["IN"]
    taken = asyncio.Event()
    take = warehouse.take

    def kill(vehicle: str, item: str, quantity: int) -> str:
        refused = take(vehicle, item, quantity)
        if not refused:
            factory.crash("IN")
            taken.set()
        return refused

    for _ in range(3):
        warehouse.take = kill  # type: ignore[method-assign]
        await taken.wait()
        warehouse.take = take  # type: ignore[method-assign]
        taken.clear()
        await asyncio.sleep(20.0)
        factory.restart("IN")


async def _forgets_what_it_has_ordered(stage: Stage) -> None:
    """Let a storage lose its journal while a vehicle is on its way to it, and begin again at once."""
    coming = Coming()
    stage.listeners.add(coming)
    for _ in range(4):
        await coming.wait()
        stage.factory.lose_journal("RACK")
        stage.factory.restart("RACK")
        await asyncio.sleep(120.0)


async def _loses_power_over_and_over(stage: Stage) -> None:
    """Kill a storage, and then the warehouse, for half a minute each, all the time."""
    for number in range(20):
        agent = ("RACK", "IN", "PAINT")[number % 3]
        stage.factory.crash(agent)
        await asyncio.sleep(30.0)
        stage.factory.restart(agent)
        await asyncio.sleep(30.0)


async def _closed_dock(stage: Stage) -> None:
    """A person closes the dock of a storage for ten minutes."""
    factory = stage.factory
    manager = FloorManager(factory.bus, factory.clock, factory.keys, factory.authority)
    await asyncio.sleep(100.0)
    closure = Closure("rack", ClosureKind.CLOSED, "manager", node=stage.plant.node_of("RACK"))
    begins_s = stage.now_s()
    with suppress(TimeoutError):
        async with asyncio.timeout(900.0):
            await manager.close([Closing(closure, begins_s, begins_s + 600.0, tells_end=True)])


@pytest.mark.parametrize(
    "meddle",
    [
        _killed_as_it_gives,
        _forgets_what_it_has_ordered,
        *later((_loses_power_over_and_over,), (_closed_dock,)),
    ],
)
def test_nothing_is_lost_nor_brought_twice(meddle: Meddle) -> None:
    run, refills = played(Plant(SHORT), meddle)
    all_is_well(run)
    assert refills.tasks


def test_of_two_warehouses_one_may_be_lost() -> None:
    file = SHORT
    first = next(each for each in file.warehouses if each.kind == "source")
    second = Warehouse("IN2", "Goods in 2", "source", first.node, first.box, stocks=first.stocks)
    plant = Plant(replace(file, warehouses=(*file.warehouses, second)))

    async def lost(stage: Stage) -> None:
        await asyncio.sleep(60.0)
        stage.factory.crash("IN")

    run, refills = played(plant, lost)
    all_is_well(run)
    assert refills.tasks
