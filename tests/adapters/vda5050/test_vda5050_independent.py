"""Orders of the default plant, delivered by vehicles that we have not written, alone and beside simulated ones of all versions."""

from __future__ import annotations

import asyncio
from collections import Counter
from dataclasses import dataclass, field

import pytest
from foreign import ForeignBody, vehicles

from dray.adapters.vda5050.link import BrokerAddress
from dray.messages import Event, Message, OrderItem
from dray.messages.fact import TaskClosed
from dray.plant import Plant, default_plant
from dray.plant.model import VehicleSpec
from dray.ports import Body
from dray_sim.bodies.vehicle.vehicle import SimVehicle
from dray_sim.checks.invariants import Invariants
from dray_sim.clock.loop import clock, paced, run
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.network.listeners import Listeners
from dray_sim.people.demand import Order
from dray_sim.people.order_client import OrderClient
from dray_sim.vda5050.broker_fleet import BrokerFleet
from dray_sim.vda5050.local_broker import local_broker

SPEED = 15.0
PIECES = 4
"""Of each order."""

PATIENCE_S = 2000.0
"""Of the plant's time."""

LOOK_S = 5.0


@dataclass
class Shift:
    """What came of it."""

    outcomes: Counter[str] = field(default_factory=Counter)
    foreign: dict[str, ForeignBody] = field(default_factory=dict)
    ours: dict[str, int] = field(default_factory=dict)
    """Actions of simulated vehicles, by version."""
    delivered: int = 0
    broken: object = None

    def on_message(self, _at_s: float, _sender: str, _address: str, message: Message) -> None:
        if type(message) is Event and type(message.fact) is TaskClosed:
            self.outcomes[message.fact.outcome] += 1


async def worked(plant: Plant, foreign: tuple[str, ...], broker: BrokerAddress, orders: int) -> Shift:
    """Some orders, until all are delivered."""
    shift, now = Shift(), clock()
    fleet = BrokerFleet(plant, now, broker, lambda plant_s: plant_s)

    def embody(spec: VehicleSpec, sim: SimVehicle, life: int) -> Body:
        if spec.id not in foreign:
            return fleet.embody(spec, sim, life)
        body = shift.foreign[spec.id] = ForeignBody(spec, sim, plant, now, broker, life)
        return body

    listeners = Listeners()
    specs = [plant.fleet[atv] for atv in foreign]
    async with vehicles(broker, plant, specs, SPEED):
        factory = SimFactory(plant, now, seed=1, stock_frac=(0.02, 0.15), listener=listeners, embody=embody)
        invariants = Invariants(factory)
        listeners.add(shift, invariants)
        products = list(plant.products)
        wanted = [
            Order(f"o{number}", 0.0, 7200.0, (OrderItem(products[number % len(products)], PIECES),))
            for number in range(orders)
        ]
        async with asyncio.timeout(PATIENCE_S):
            # Nobody sets an event for the last of several.
            while not all(  # noqa: ASYNC110
                body.driver.control.is_known for body in shift.foreign.values()
            ):
                await asyncio.sleep(1.0)
            await fleet.ready()
            running = asyncio.create_task(factory.run())
            customers = asyncio.create_task(OrderClient(factory.bus, now).place(wanted))
            while sum(sum(place.arrived.values()) for place in factory.delivery.values()) < orders * PIECES:
                assert not running.done(), running
                assert not (customers.done() and customers.exception()), customers
                await asyncio.sleep(LOOK_S)
        shift.delivered = sum(sum(place.arrived.values()) for place in factory.delivery.values())
        shift.broken = invariants.broken
        for vehicle in fleet._vehicles.values():
            if vehicle.vehicle is not None:
                version = vehicle.vehicle.words.version
                shift.ours[version] = shift.ours.get(version, 0) + len(vehicle.vehicle.done)
        tasks = [running, customers, *(body.link for body in shift.foreign.values())]
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        await fleet.end()
    return shift


@pytest.mark.slow
def test_a_fleet_that_we_have_not_written_delivers_orders() -> None:
    plant = default_plant()
    with local_broker() as broker:
        shift = run(worked(plant, tuple(plant.fleet), broker, 2), paced(SPEED))
    assert shift.broken is None
    assert set(shift.outcomes) <= {"delivered"}
    assert sum(len(body.did) for body in shift.foreign.values()) >= 4


@pytest.mark.slow
def test_it_works_beside_simulated_vehicles_of_all_versions() -> None:
    plant = default_plant()
    foreign = tuple(plant.fleet)[::4]
    with local_broker() as broker:
        shift = run(worked(plant, foreign, broker, 24), paced(SPEED))
    assert shift.broken is None
    assert set(shift.outcomes) <= {"delivered"}
    assert shift.ours.keys() == {"2.0", "2.1", "3.0"}
    assert all(shift.ours.values()), shift.ours
    assert any(body.did for body in shift.foreign.values())
