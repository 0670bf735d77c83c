"""A manager closes parts of a running factory: nobody drives there, all hear of it, and work goes on by other ways."""

from __future__ import annotations

import asyncio
from collections import Counter
from functools import cache
from random import Random

import pytest

from dray.adapters.security.signing import SigningKey
from dray.messages import AtvHeartbeat, Closure, ClosureKind, Event, Message
from dray.messages.fact import ClosuresKnown, TaskClosed
from dray.plant import load_plant
from dray_sim.checks.floor.closed_lanes import ClosedLanes
from dray_sim.checks.invariants import Invariants
from dray_sim.clock.loop import clock, run
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.network.listeners import Listeners
from dray_sim.people import demand
from dray_sim.people.floor_manager import NAME, Closing, FloorManager
from dray_sim.people.order_client import OrderClient

PLANT = load_plant("single-track")
BEGINS_S, ENDS_S = 600.0, 2400.0
SHUT = ("e2", "e3")
"""Crossings on many ways; every dock is reached without them."""


class Watch:
    """What vehicles know, where they were, and what was delivered while something was closed."""

    def __init__(self) -> None:
        self.knows_s: dict[str, float] = {}
        self.visits: Counter[str] = Counter()
        self.delivered = 0

    def on_message(self, at_s: float, sender: str, _address: str, message: Message) -> None:
        if type(message) is Event and type(message.fact) is ClosuresKnown:
            self.knows_s.setdefault(sender, at_s)
        if not BEGINS_S + 60.0 < at_s < ENDS_S:
            return
        if type(message) is AtvHeartbeat:
            self.visits[message.node] += 1
        elif type(message) is Event and type(message.fact) is TaskClosed:
            self.delivered += message.fact.outcome == "delivered"


async def _shift(*closed: Closure, tells_end: bool = False, authority: SigningKey | None = None) -> Watch:
    listeners, watch = Listeners(), Watch()
    factory = SimFactory(PLANT, clock(), seed=3, listener=listeners)
    checks = Invariants(factory, ClosedLanes(factory))
    listeners.add(checks, watch)
    orders = demand.orders(PLANT, Random(3), load=0.7, until_s=3000.0)
    manager = FloorManager(factory.bus, factory.clock, factory.keys, authority or factory.authority)
    closings = [Closing(each, BEGINS_S, ENDS_S, tells_end) for each in closed]
    async with asyncio.TaskGroup() as group:
        tasks = [
            group.create_task(factory.run()),
            group.create_task(OrderClient(factory.bus, factory.clock).place(orders)),
            group.create_task(manager.close(closings)),
        ]
        await asyncio.sleep(BEGINS_S + 300.0)
        factory.restart("ATV2")
        await asyncio.sleep(2400.0)
        for task in tasks:
            task.cancel()
    assert checks.broken is None, checks.broken
    return watch


def closed(kind: ClosureKind = ClosureKind.CLOSED) -> list[Closure]:
    return [Closure(f"K{node}", kind, NAME, node=node, speed_mps=0.5) for node in SHUT]


@cache
def ordinary() -> Watch:
    """The same shift with nothing closed, which two tests compare with."""
    return run(_shift())


@pytest.mark.slow
@pytest.mark.parametrize("tells_end", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_nobody_is_seen_where_it_is_closed_and_work_goes_on(tells_end: bool) -> None:
    watch = run(_shift(*closed(), tells_end=tells_end))
    assert all(ordinary().visits[node] > 20 for node in SHUT)
    assert [watch.visits[node] for node in SHUT] == [0, 0]
    assert watch.delivered > 0.8 * ordinary().delivered > 20
    assert set(watch.knows_s) == set(PLANT.fleet)
    assert max(watch.knows_s.values()) < BEGINS_S + 1.0


@pytest.mark.slow
def test_a_list_that_is_signed_by_somebody_else_closes_nothing() -> None:
    watch = run(_shift(*closed(), authority=SigningKey(bytes(32))))
    assert watch.knows_s == {}
    assert all(watch.visits[node] > 20 for node in SHUT)
