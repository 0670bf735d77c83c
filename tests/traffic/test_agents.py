"""The real agents with right of way: a factory whose vehicles take up room."""

from __future__ import annotations

import asyncio
from random import Random

import pytest
from variants import in_campaigns, variants

from dray.messages import Event, Message
from dray.messages.fact import TaskClosed
from dray.plant import Plant, default_plant, load_plant
from dray_sim.checks.floor.held_places import HeldPlaces
from dray_sim.checks.floor.overlaps import Overlaps
from dray_sim.checks.invariants import Invariants
from dray_sim.clock.loop import JUMP, clock, run
from dray_sim.explore.play import play
from dray_sim.explore.run import draw
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.network.listeners import Listeners
from dray_sim.people import demand
from dray_sim.people.order_client import OrderClient

SPAN_S = 3600.0

COSTS_AT_MOST = 0.8
"""Of what vehicles carry that drive through one another: one that stands still carries nothing. What it costs is measured by `dray bench traffic`."""


class Delivered:
    """Counts transports that came to their good end."""

    def __init__(self) -> None:
        self.count = 0

    def on_message(self, _at_s: float, _sender: str, _address: str, message: Message) -> None:
        if type(message) is Event and type(message.fact) is TaskClosed:
            self.count += message.fact.outcome == "delivered"


async def played(plant: Plant, seed: int, *, traffic: bool) -> tuple[int, Invariants, Overlaps]:
    """An hour of a plant at its full load: transports, what was broken, and vehicles in one spot."""
    listeners, delivered = Listeners(), Delivered()
    factory = SimFactory(plant, clock(), seed=seed, listener=listeners, traffic=traffic)
    overlaps = Overlaps(factory.vehicles, strict=False)
    invariants = Invariants(factory, HeldPlaces(factory))
    listeners.add(delivered, overlaps, invariants)
    orders = list(demand.orders(plant, Random(seed), load=1.0, until_s=SPAN_S))
    tasks = [
        asyncio.create_task(factory.run()),
        asyncio.create_task(OrderClient(factory.bus, factory.clock).place(orders)),
    ]
    await asyncio.sleep(SPAN_S)
    invariants.check_end(factory.clock.now_s())
    overlaps.check_end(factory.clock.now_s())
    for task in tasks:
        task.cancel()
    await asyncio.gather(*tasks, return_exceptions=True)
    return delivered.count, invariants, overlaps


TOUCHING = {"single track": load_plant("single-track"), "two lanes": default_plant()}


@pytest.mark.parametrize("name", in_campaigns(TOUCHING, "single track"))
def test_vehicles_with_right_of_way_carry_on_and_never_touch(name: str) -> None:
    plant = TOUCHING[name]
    alone = carried = 0
    for seed in (1, 2):
        by_ghosts, _, ghosts = run(played(plant, seed, traffic=False), JUMP)
        by_vehicles, invariants, overlaps = run(played(plant, seed, traffic=True), JUMP)
        assert ghosts.count > 0, "else nothing is shown"
        assert (overlaps.count, invariants.broken) == (0, None)
        alone, carried = alone + by_ghosts, carried + by_vehicles
    assert carried >= COSTS_AT_MOST * alone


@pytest.mark.parametrize("seed", variants(range(3)))
def test_runs_without_faults_come_to_their_end(seed: int) -> None:
    assert play(draw(seed, "faultless", traffic=True)).broken == ""


@pytest.mark.slow
def test_a_run_with_right_of_way_is_repeatable() -> None:
    first, second = (play(draw(3, "faultless", traffic=True), listen=True).trace for _ in range(2))
    assert first == second != play(draw(3, "faultless"), listen=True).trace
