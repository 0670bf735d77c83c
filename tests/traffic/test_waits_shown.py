"""What the gateway makes of a real run with right of way: waits with their places and ends, and no alert where all goes well."""

from __future__ import annotations

import asyncio
from dataclasses import replace
from itertools import islice
from random import Random

from dray.gateway.live.projection import Projection
from dray.gateway.live.timescale import TimeScale
from dray.gateway.live.views import WaitView
from dray.messages import Message
from dray.plant import default_plant
from dray.plant.model import PlantFile
from dray.protocol.traffic.places import Places
from dray_sim.bodies.floor import NEARLY_EMPTY_FRAC
from dray_sim.clock.loop import JUMP, clock, run
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.network.listeners import Listeners
from dray_sim.people import demand
from dray_sim.people.order_client import OrderClient

SPAN_S = 250.0

ORDERS = 36
"""Three for each machine: all vehicles are at work."""


class Shown:
    """What people at the panels are shown, second by second."""

    def __init__(self, plant: PlantFile) -> None:
        self.projection = Projection(plant, TimeScale(0.0, 0.0))
        self.waits: list[WaitView] = []
        self.alerts: set[str] = set()

    def on_message(self, _at_s: float, _sender: str, _address: str, message: Message) -> None:
        self.projection.fold(message)

    def look(self, now_s: float) -> None:
        self.projection.look(now_s)
        self.waits += self.projection.waits.views()
        self.alerts |= {each.kind for each in self.projection.alerts.views()}


async def play() -> Shown:
    plant, listeners = default_plant(), Listeners()
    shown = Shown(plant.file)
    factory = SimFactory(
        plant, clock(), seed=1, listener=listeners, traffic=True, stock_frac=NEARLY_EMPTY_FRAC
    )
    listeners.add(shown)
    orders = islice(demand.orders(plant, Random(1), load=1.0, until_s=1e6), ORDERS)
    placed = [replace(order, at_s=5.0 + number / 2) for number, order in enumerate(orders)]
    tasks = [
        asyncio.create_task(factory.run()),
        asyncio.create_task(OrderClient(factory.bus, factory.clock).place(placed)),
    ]
    while factory.clock.now_s() < SPAN_S:
        await asyncio.sleep(1.0)
        shown.look(factory.clock.now_s())
    for task in tasks:
        task.cancel()
    await asyncio.gather(*tasks, return_exceptions=True)
    return shown


def test_waits_of_a_run_have_places_and_ends_and_ask_nothing_of_people() -> None:
    shown = run(play(), JUMP)
    plant, fleet = default_plant(), set(default_plant().fleet)
    assert len({wait.id for wait in shown.waits}) >= 3
    assert all(set(wait.cause.chain) <= fleet for wait in shown.waits)
    named = [wait for wait in shown.waits if wait.cause.chain]
    assert len(named) > len(shown.waits) / 2
    assert {wait.place for wait in named} <= Places(plant).district_of.keys()
    assert {"docked", "moving"} <= {wait.cause.kind for wait in named}
    assert all(wait.cause.place in set(plant.places) for wait in named if wait.cause.kind == "docked")
    assert shown.alerts.isdisjoint({"jam", "atv_waits"})
    assert any(len(atv.holds) > 1 for atv in shown.projection.atvs.views())
