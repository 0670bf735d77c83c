"""Vehicles whose loads no simulated place sees, at the places of a simulated floor: their words are counted, and liars are disputed."""

from __future__ import annotations

import asyncio
from collections import Counter
from collections.abc import Callable

import pytest

from dray.adapters.remote_body import CountedBody
from dray.adapters.vda5050.profile import load_profile
from dray.body import Drop, Pick
from dray.messages import Event, Message, OrderItem
from dray.messages.fact import HandoverDisputed, TaskClosed
from dray.plant import default_plant
from dray.plant.model import VehicleSpec
from dray.ports import Body
from dray_sim.bodies.stands import Stands
from dray_sim.bodies.vehicle.vehicle import SimVehicle
from dray_sim.checks.invariants import Invariants
from dray_sim.clock.loop import JUMP, clock, run
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.network.listeners import Listeners
from dray_sim.people.demand import Order
from dray_sim.people.order_client import OrderClient
from dray_sim.vda5050.fleet import MemoryFleet

PLANT = default_plant()
PIECES = 4


class Anywhere:
    """A place of the vehicle's own world: gives and takes whatever it is asked for."""

    def take(self, _vehicle: str, _item: str, _quantity: int) -> str:
        return ""

    def put(self, _vehicle: str, _item: str, _quantity: int, _goal: str = "") -> str:
        return ""


class Seen:
    """How transports ended, and which handovers were disputed."""

    def __init__(self) -> None:
        self.outcomes: Counter[str] = Counter()
        self.disputes: Counter[str] = Counter()

    def on_message(self, _at_s: float, _sender: str, _address: str, message: Message) -> None:
        if type(message) is not Event:
            return
        if type(message.fact) is TaskClosed:
            self.outcomes[message.fact.outcome] += 1
        elif type(message.fact) is HandoverDisputed:
            self.disputes[message.fact.task] += 1


Tell = Callable[[SimFactory, str, Pick | Drop], str]


def counted(factory: SimFactory, atv: str, done: Pick | Drop) -> str:
    """The floor is told."""
    return factory.floor.follow(atv, done)


def boasting(factory: SimFactory, atv: str, done: Pick | Drop) -> str:
    """Only drops are told: of loads that no place has given away."""
    return factory.floor.follow(atv, done) if isinstance(done, Drop) else ""


async def shift(span_s: float, tell: Tell | None) -> tuple[Seen, SimFactory, Invariants]:
    """A fleet behind VDA 5050 in a world of its own; one order of each product.

    Args:
        span_s: how long.
        tell: what the floor is told of their transfers; None for nothing.
    """
    seen, listeners, now = Seen(), Listeners(), clock()
    fleet = MemoryFleet(PLANT, now, lambda _: load_profile("dray-sim"))
    places = dict.fromkeys(PLANT.places, Anywhere())
    running: list[asyncio.Task[None]] = []

    def embody(spec: VehicleSpec, _double: SimVehicle, life: int) -> Body:
        kind = PLANT.vehicle_types[spec.type]
        real = SimVehicle(spec, kind, PLANT, now, Stands(PLANT, places))
        body = fleet.embody(spec, real, life)
        if tell is None:
            return body

        async def told(done: Pick | Drop) -> str:
            return tell(factory, spec.id, done)

        body_told = CountedBody(spec.id, body, told)
        running.append(asyncio.create_task(body_told.run()))
        return body_told

    factory = SimFactory(PLANT, now, seed=1, stock_frac=(0.02, 0.15), listener=listeners, embody=embody)
    invariants = Invariants(factory)
    listeners.add(seen, invariants)
    orders = [Order(f"o-{item}", 0.0, 7200.0, (OrderItem(item, PIECES),)) for item in PLANT.products]
    running.append(asyncio.create_task(factory.run()))
    running.append(asyncio.create_task(OrderClient(factory.bus, now).place(orders)))
    await asyncio.sleep(span_s)
    for task in running:
        assert not task.done() or task.exception() is None, task
        task.cancel()
    await asyncio.gather(*running, return_exceptions=True)
    return seen, factory, invariants


def delivered(factory: SimFactory) -> int:
    return sum(sum(warehouse.arrived.values()) for warehouse in factory.delivery.values())


@pytest.mark.slow
def test_a_fleet_whose_transfers_the_floor_is_told_delivers_all_orders() -> None:
    seen, factory, invariants = run(shift(3600.0, counted), JUMP)
    assert seen.disputes == {}
    assert seen.outcomes["delivered"] >= 6
    assert delivered(factory) == PIECES * len(PLANT.products)
    assert invariants.broken is None


@pytest.mark.parametrize("tell", [None, boasting], ids=["untold", "never picked up"])
def test_what_the_floor_is_not_told_or_cannot_be_true_is_disputed(tell: Tell | None) -> None:
    seen, factory, _ = run(shift(900.0, tell), JUMP)
    assert seen.disputes
    assert (seen.outcomes["delivered"], delivered(factory)) == (0, 0)
