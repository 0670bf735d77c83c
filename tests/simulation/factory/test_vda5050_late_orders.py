"""Agents that die just after they have ordered a vehicle to drive, and orders that come to it when the next life has seen it."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable
from functools import partial
from random import Random

from msgspec.structs import replace

from dray.adapters.vda5050.profile import load_profile
from dray.plant import default_plant
from dray_sim.bodies.floor import NEARLY_EMPTY_FRAC
from dray_sim.checks.floor.held_places import HeldPlaces
from dray_sim.checks.floor.overlaps import Overlaps
from dray_sim.checks.invariants import Invariants
from dray_sim.clock.loop import JUMP, clock, run
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.network.listeners import Listeners
from dray_sim.people import demand
from dray_sim.people.order_client import OrderClient
from dray_sim.vda5050.fleet import DELAY_S, MemoryFleet

PLANT = default_plant()
SHIPPED = load_profile("dray-sim")
PROFILES = (
    SHIPPED,
    replace(SHIPPED, version="2.0", updates=False, horizon=0, base_m=0.0),
    replace(SHIPPED, version="2.1", horizon=0),
)

SPAN_S, EVERY_S, AWAY_S, LATE_S = 120.0, 5.0, 1.0, 6.0
"""Of the run; least time between two kills; longest absence of an agent; longest way of its last order."""


class SlowLinks:
    """Kills an agent that orders its vehicle to drive, now and then, and lets that order come late.

    Attributes:
        kills: how many.
    """

    def __init__(self, seed: int) -> None:
        self.kills = 0
        self._chance = Random(str(seed))
        order = sorted(PLANT.fleet)
        self.fleet = MemoryFleet(PLANT, clock(), lambda atv: PROFILES[order.index(atv) % 3], carry=self.carry)
        self.factory: SimFactory
        self._killed_s = 0.0
        self._away: set[str] = set()
        self._slow_until_s: dict[str, float] = {}

    def carry(self, atv: str, data: bytes, hand: Callable[[bytes], None]) -> None:
        said, now_s, late_s = json.loads(data), clock().now_s(), DELAY_S
        if "nodeStates" not in said:  # It is no state: it is for the vehicle.
            if said.get("edges"):
                self._perhaps_kill(atv, now_s)
            late_s = max(late_s, self._slow_until_s.get(atv, now_s) - now_s)
        clock().call_at(now_s + late_s, partial(hand, data))

    def _perhaps_kill(self, atv: str, now_s: float) -> None:
        if atv in self._away or now_s <= self._killed_s + EVERY_S or self._chance.random() >= 0.2:
            return
        self.kills += 1
        self._killed_s = now_s
        self._slow_until_s[atv] = now_s + self._chance.uniform(0.5, LATE_S)
        self._away.add(atv)
        clock().call_at(now_s + 0.001, partial(self._crash, atv))

    def _crash(self, atv: str) -> None:
        self.factory.crash(atv)
        clock().call_at(clock().now_s() + self._chance.uniform(0.0, AWAY_S), partial(self._restart, atv))

    def _restart(self, atv: str) -> None:
        self._away.discard(atv)
        self.factory.restart(atv)


async def played(seed: int) -> tuple[SlowLinks, Invariants, Overlaps]:
    links, listeners = SlowLinks(seed), Listeners()
    factory = links.factory = SimFactory(
        PLANT,
        clock(),
        seed=seed,
        listener=listeners,
        traffic=True,
        stock_frac=NEARLY_EMPTY_FRAC,
        embody=links.fleet.embody,
    )
    overlaps = Overlaps(factory.vehicles, strict=False)
    invariants = Invariants(factory, HeldPlaces(factory))
    listeners.add(overlaps, invariants)
    orders = list(demand.orders(PLANT, Random(seed), load=2.0, until_s=SPAN_S))
    running = asyncio.create_task(factory.run())
    customers = asyncio.create_task(OrderClient(factory.bus, clock()).place(orders))
    await asyncio.sleep(SPAN_S)
    assert not running.done(), running
    for task in (running, customers):
        task.cancel()
    await asyncio.gather(running, customers, return_exceptions=True)
    return links, invariants, overlaps


def test_an_order_that_comes_after_its_life_leads_into_no_other_vehicle() -> None:
    # Seed 5: another vehicle was granted the lanes of the late order, and was touched after 24 s.
    links, invariants, overlaps = run(played(5), JUMP)
    assert links.kills >= 5
    assert invariants.broken is None
    assert overlaps.count == 0
