"""A factory whose vehicles are behind VDA 5050, of three versions and beside simulated ones: work gets done, nothing is done twice."""

from __future__ import annotations

import asyncio
from collections import Counter
from collections.abc import Callable
from random import Random

import pytest
from msgspec.structs import replace
from variants import in_campaigns

from dray.adapters.vda5050.profile import Profile, load_profile
from dray.messages import Event, Message
from dray.messages.fact import TaskClosed
from dray.plant import default_plant
from dray_sim.checks.floor.held_places import HeldPlaces
from dray_sim.checks.floor.overlaps import Overlaps
from dray_sim.checks.invariants import Invariants
from dray_sim.clock.loop import JUMP, clock, run
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.network.listeners import Listeners
from dray_sim.people import demand
from dray_sim.people.order_client import OrderClient
from dray_sim.vda5050.fleet import MemoryFleet

SHIPPED = load_profile("dray-sim")
STEPS = replace(SHIPPED, version="2.0", updates=False, horizon=0, base_m=0.0)
PROFILES = (None, SHIPPED, STEPS, replace(SHIPPED, version="2.1", horizon=0))
"""None: simulated, as others are."""


def mixed(atv: str) -> Profile | None:
    """By turns, among the light vehicles (ATV1, ATV3, ...) as among the heavy ones, for which there is little work."""
    return PROFILES[int(atv.removeprefix("ATV")) // 2 % len(PROFILES)]


class Closed:
    """How transports ended."""

    def __init__(self) -> None:
        self.outcomes: Counter[str] = Counter()

    def on_message(self, _at_s: float, _sender: str, _address: str, message: Message) -> None:
        if type(message) is Event and type(message.fact) is TaskClosed:
            self.outcomes[message.fact.outcome] += 1


async def played(
    span_s: float,
    *,
    traffic: bool,
    restarts: int = 0,
    profile_of: Callable[[str], Profile | None] = mixed,
) -> tuple[Closed, MemoryFleet, Invariants, Overlaps]:
    """The default plant at its full load; restarts of agents and vehicles, evenly spread, whichever it hits."""
    plant, chance = default_plant(), Random(span_s)
    listeners, closed, fleet = Listeners(), Closed(), MemoryFleet(plant, clock(), profile_of)
    factory = SimFactory(plant, clock(), seed=1, listener=listeners, traffic=traffic, embody=fleet.embody)
    overlaps = Overlaps(factory.vehicles, strict=False)
    invariants = Invariants(factory, *([HeldPlaces(factory)] if traffic else []))
    listeners.add(closed, overlaps, invariants)
    orders = list(demand.orders(plant, Random(1), load=1.0, until_s=span_s))
    running = asyncio.create_task(factory.run())
    customers = asyncio.create_task(OrderClient(factory.bus, factory.clock).place(orders))
    for _ in range(restarts):
        await asyncio.sleep(span_s / (restarts + 1))
        atv = chance.choice(sorted(fleet.vehicles))
        if chance.random() < 0.5:
            fleet.vehicles[atv].restart()
        else:
            factory.crash(atv)
            await asyncio.sleep(chance.uniform(0.0, 2.0))
            factory.restart(atv)
    await asyncio.sleep(span_s / (restarts + 1))
    assert not running.done(), running
    invariants.check_end(factory.clock.now_s())
    for task in (running, customers):
        task.cancel()
    await asyncio.gather(running, customers, return_exceptions=True)
    return closed, fleet, invariants, overlaps


def done_twice(fleet: MemoryFleet) -> list[str]:
    return [
        action
        for vehicle in fleet.vehicles.values()
        for action, count in Counter(vehicle.done).items()
        if count > 1
    ]


@pytest.mark.slow
def test_orders_are_delivered_by_vehicles_of_all_versions_and_simulated_ones() -> None:
    closed, fleet, invariants, _ = run(played(3600.0, traffic=False), JUMP)
    assert {vehicle.words.version for vehicle in fleet.vehicles.values() if vehicle.done} == {
        "2.0",
        "2.1",
        "3.0",
    }
    assert invariants.broken is None
    assert closed.outcomes["delivered"] >= 10
    assert done_twice(fleet) == []
    assert fleet.notes == []


@pytest.mark.slow
@pytest.mark.parametrize("profile", PROFILES[1:], ids=lambda profile: profile.version)
def test_orders_are_delivered_by_a_fleet_of_one_version(profile: Profile) -> None:
    closed, fleet, invariants, _ = run(played(1800.0, traffic=False, profile_of=lambda _: profile), JUMP)
    assert {vehicle.words.version for vehicle in fleet.vehicles.values()} == {profile.version}
    assert invariants.broken is None
    assert closed.outcomes["delivered"] >= 10
    assert done_twice(fleet) == []


@pytest.mark.slow
def test_with_right_of_way_they_never_touch() -> None:
    closed, fleet, invariants, overlaps = run(played(3600.0, traffic=True), JUMP)
    assert (overlaps.count, invariants.broken) == (0, None)
    assert closed.outcomes["delivered"] >= 40
    assert done_twice(fleet) == []


@pytest.mark.parametrize("traffic", in_campaigns([False, True], True))
def test_restarts_of_agents_and_vehicles_lose_nothing_and_do_nothing_twice(traffic: bool) -> None:
    closed, fleet, invariants, overlaps = run(played(3600.0, traffic=traffic, restarts=60), JUMP)
    assert invariants.broken is None
    assert not traffic or overlaps.count == 0
    assert closed.outcomes["delivered"] >= 25
    assert done_twice(fleet) == []
