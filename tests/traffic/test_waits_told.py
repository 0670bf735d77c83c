"""A vehicle that is dead on a lane: others go round it, or wait and say for whom."""

from __future__ import annotations

import asyncio
from random import Random

import pytest

from dray.messages import AtvHeartbeat, Event, Message
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

DIES_S, SPAN_S = 1800.0, 5400.0


class Told:
    """What vehicles tell after one of them has died."""

    def __init__(self) -> None:
        self.dead = ""
        self.delivered = 0
        self.named: set[str] = set()
        """Vehicles that have told that they wait for the dead one."""
        self.longest_s = 0.0
        """That anybody has told without a break to wait for one that lives."""
        self._since_s: dict[str, float] = {}

    def on_message(self, at_s: float, _sender: str, _address: str, message: Message) -> None:
        if not self.dead:
            return
        if type(message) is Event and type(message.fact) is TaskClosed:
            self.delivered += message.fact.outcome == "delivered"
        elif type(message) is AtvHeartbeat and message.floor:
            if message.floor.waits_for in ("", self.dead):
                self._since_s.pop(message.atv, None)
            else:
                since_s = self._since_s.setdefault(message.atv, at_s)
                self.longest_s = max(self.longest_s, at_s - since_s)
            if message.floor.waits_for == self.dead:
                self.named.add(message.atv)


async def with_one_dead() -> tuple[Told, Invariants]:
    plant, listeners, told = default_plant(), Listeners(), Told()
    factory = SimFactory(plant, clock(), seed=1, listener=listeners, traffic=True)
    invariants = Invariants(factory, HeldPlaces(factory), Overlaps(factory.vehicles))
    listeners.add(told, invariants)
    orders = list(demand.orders(plant, Random(1), load=0.9, until_s=SPAN_S))
    tasks = [
        asyncio.create_task(factory.run()),
        asyncio.create_task(OrderClient(factory.bus, factory.clock).place(orders)),
    ]
    await asyncio.sleep(DIES_S)
    while not told.dead:
        await asyncio.sleep(1.0)
        moving = [name for name, body in factory.vehicles.items() if body.sense().speed_mps > 1.0]
        if moving:
            told.dead = moving[0]
            factory.power_off(told.dead)
    await asyncio.sleep(SPAN_S - DIES_S)
    invariants.check_end(factory.clock.now_s())
    for task in tasks:
        task.cancel()
    await asyncio.gather(*tasks, return_exceptions=True)
    return told, invariants


@pytest.mark.slow
def test_a_dead_vehicle_on_a_lane_is_gone_round_and_named_by_who_waits() -> None:
    told, invariants = run(with_one_dead(), JUMP)
    assert invariants.broken is None
    assert told.delivered >= 50, "the others go on"
    assert told.named
    assert told.longest_s < 300.0, "who waits for one at a dock waits for its work there, too"
