"""An order of the default plant where every machine and storage, and the gate, is behind OPC UA, and every vehicle behind VDA 5050."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from dray.adapters.mapping_file import load_mapping
from dray.adapters.opcua.mapping_file import OpcUaMapping
from dray.adapters.vda5050.link import BrokerAddress
from dray.messages import OrderItem
from dray.messages.keys import GATE
from dray.plant import default_plant
from dray.ports import Body
from dray_sim.checks.invariants import Invariants
from dray_sim.clock.loop import clock, paced, run
from dray_sim.controllers.local_server import local_server
from dray_sim.controllers.machine import COUNTERS
from dray_sim.controllers.opcua_bodies import OpcUaBodies
from dray_sim.controllers.opcua_server import ControllerServer
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.network.listeners import Listeners
from dray_sim.people.demand import Order
from dray_sim.people.order_client import OrderClient
from dray_sim.vda5050.broker_fleet import BrokerFleet
from dray_sim.vda5050.local_broker import local_broker

SPEED = 5.0
PIECES = 2
PATIENCE_S = 2400.0
"""Of the plant's time: eight minutes of a busy computer."""

LOOK_S = 5.0


@dataclass
class Shift:
    """What came of it."""

    delivered: dict[str, int] = field(default_factory=dict)
    made: dict[str, int] = field(default_factory=dict)
    counted: dict[str, int] = field(default_factory=dict)
    believed: dict[str, dict[str, int]] = field(default_factory=dict)
    there: dict[str, dict[str, int]] = field(default_factory=dict)
    problems: dict[str, str] = field(default_factory=dict)
    restarted: bool = False
    """Whether the agents of machines and storages have begun another life."""
    at_the_gate: dict[str, int] = field(default_factory=dict)
    """Pieces by goal, as the gate has counted them."""
    broken: object = None


async def worked(broker: BrokerAddress, server: ControllerServer) -> Shift:
    """One order, and what each side believes when it is delivered; meanwhile the agent of each machine and storage begins another life."""
    plant, now, shift, listeners = default_plant(), clock(), Shift(), Listeners()
    fleet = BrokerFleet(plant, now, broker, lambda plant_s: plant_s)
    bodies = OpcUaBodies(plant, now, server, speed=SPEED)
    factory = SimFactory(
        plant,
        now,
        seed=1,
        stock_frac=(0.02, 0.15),
        listener=listeners,
        embody=fleet.embody,
        bodies=bodies,
    )
    invariants = Invariants(factory)
    listeners.add(invariants)
    there: dict[str, Body] = {**factory.workcells, **factory.storages}
    wanted = tuple(OrderItem(product, PIECES) for product in (*plant.products,)[:2])

    def arrived() -> dict[str, int]:
        places = factory.delivery.values()
        return {line.product: sum(place.arrived[line.product] for place in places) for line in wanted}

    def rests() -> bool:
        gate = bodies.gate
        return (
            gate is not None
            and gate.sense().arrived == factory.gate.sense().arrived
            and all(
                body.sense().stock == there[name].sense().stock
                for name, body in (*bodies.machines.items(), *bodies.stores.items())
            )
        )

    await fleet.ready()
    await bodies.ready()
    running = asyncio.create_task(factory.run())
    customers = asyncio.create_task(OrderClient(factory.bus, now).place([Order("o1", 0.0, 7200.0, wanted)]))
    try:
        async with asyncio.timeout(PATIENCE_S):
            while any(pieces < PIECES for pieces in arrived().values()):
                assert not running.done(), running
                assert not (customers.done() and customers.exception()), customers
                if not shift.restarted and any(
                    each.made[COUNTERS[0]] for each in bodies.controllers.values()
                ):
                    shift.restarted = True
                    for agent in (*plant.machines, *plant.stores, GATE):
                        factory.restart(agent)
                await asyncio.sleep(LOOK_S)
            # What is on its way between the two sides comes to rest, and what stands before the gate comes in.
            while not rests():  # noqa: ASYNC110 - nobody tells when
                await asyncio.sleep(LOOK_S)
    finally:
        for machine, body in bodies.machines.items():
            workcell, controller = factory.workcells[machine], bodies.controllers[machine]
            shift.made[machine] = sum(workcell.made.values()) + sum(workcell.scrapped.values())
            shift.counted[machine] = sum(controller.made.values())
            shift.believed[machine], shift.there[machine] = body.sense().stock, workcell.sense().stock
            shift.problems[machine] = body.sense().broken
        if bodies.gate is not None:
            shift.at_the_gate = bodies.gate.sense().arrived
            shift.problems[GATE] = bodies.gate.away
        for store, place in bodies.stores.items():
            shift.believed[store], shift.there[store] = place.sense().stock, factory.storages[store].stock
        for task in (running, customers):
            task.cancel()
        await asyncio.gather(running, customers, return_exceptions=True)
        bodies.end()
        await fleet.end()
    shift.delivered, shift.broken = arrived(), invariants.broken
    return shift


@pytest.mark.slow
def test_an_order_is_delivered_and_every_piece_is_counted_once(tmp_path: Path) -> None:
    plant = default_plant()
    with (
        local_broker() as broker,
        local_server(plant.machines, tmp_path, plant.stores.values(), gate=True) as server,
    ):
        shift = run(worked(broker, server), paced(SPEED))
        url = server.url
    assert shift.broken is None
    assert shift.restarted
    assert all(pieces >= PIECES for pieces in shift.delivered.values()), shift
    assert sum(shift.at_the_gate.values()) == sum(shift.delivered.values())
    assert sum(shift.made.values()) >= 2 * PIECES
    assert shift.counted == shift.made
    assert shift.believed == shift.there
    assert set(shift.problems.values()) == {""}
    for machine in plant.machines:
        mapping = load_mapping(tmp_path / f"{machine}.yaml", OpcUaMapping)
        mapping.check_machine()
        assert mapping.url == url
    for store in plant.stores.values():
        mapping = load_mapping(tmp_path / f"{store.id}.yaml", OpcUaMapping)
        mapping.check_store({line.material: line.capacity for line in store.stocks})
        assert {*mapping.levels} == {line.material for line in store.stocks}
    load_mapping(tmp_path / "gate.yaml", OpcUaMapping).check_gate()
