"""How an insider joins a factory: beside the fleet, under a name of its own."""

from __future__ import annotations

from itertools import count

from dray.messages.kinds import Kind
from dray.plant import Plant
from dray.plant.model import VehicleSpec
from dray.ports import Bus
from dray.protocol.traffic.places import Places
from dray.protocol.vehicle.atv import Atv
from dray.worker.worker import Worker
from dray_sim.factory.journal import HeldJournal
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.insiders.behaviour import Behaviour
from dray_sim.insiders.bodiless import body_of
from dray_sim.insiders.double import Double
from dray_sim.insiders.impostor import Impostor, StolenPlace
from dray_sim.insiders.liar import Liar
from dray_sim.insiders.turncoat import Turncoat
from dray_sim.insiders.usurper import Usurper

INSIDER = "ATV9"
"""The ninth of nine: the default plant has eight."""


def name_in(plant: Plant) -> str:
    """The name of an insider in a plant, whose own agents have other names."""
    taken = plant.fleet.keys() | plant.machines.keys()
    others = (f"{INSIDER}-{number}" for number in count(2))
    return INSIDER if INSIDER not in taken else next(name for name in others if name not in taken)


def owner_in(plant: Plant) -> str:
    """The vehicle whose name a thief takes."""
    return next(iter(plant.fleet))


def bring_in(factory: SimFactory, behaviour: Behaviour, bus: Bus | None = None) -> Worker:
    """Let an insider join. A thief takes the name of the first vehicle, or of the last replica of the first table; one that leads, of the first.

    Args:
        factory: one that runs.
        behaviour: how it lies.
        bus: where it joins; by default the simulated network. One that drives joins where all vehicles do.

    Returns:
        The insider's worker. That of one that drives runs already; the caller runs any other (`Worker.run`).
    """
    plant = factory.plant
    if behaviour.takes_name:
        owner = owner_in(plant)
        keys = factory.request_keys
        thief: Double | Impostor
        if behaviour.has_key:
            thief = Double(owner, plant, keys.of(owner))
        else:
            thief = Impostor(owner, plant, keys.of("an impostor", owner))
        return Worker(
            thief,
            bus=bus or StolenPlace(factory.bus),
            clock=factory.clock,
            keys=factory.keys,
            body=None,
            journal=HeldJournal(incarnation=1),
        )
    if behaviour.takes_replica or behaviour.leads_falsely:
        replicas = next(iter(Places(plant).replicas_of.values()))
        leads = behaviour.leads_falsely
        return Worker(
            Usurper(replicas[0 if leads else -1], plant, leads=leads),
            bus=bus or StolenPlace(factory.bus),
            clock=factory.clock,
            keys=factory.keys,
            body=None,
            journal=HeldJournal(incarnation=1),
        )
    name = name_in(plant)
    factory.bus.kinds[name] = Kind.ATV
    kind = list(plant.vehicle_types)[-1]
    spec = VehicleSpec(name, kind, plant.stops[0], 1.0)

    def make(life: int, software: str, probation: int) -> Turncoat:
        atv = Atv(
            name,
            plant,
            vehicle_type=kind,
            incarnation=life,
            software=software,
            probation=probation,
            traffic=factory.traffic,
            trusts=factory.trusts,
        )
        return Turncoat(atv, behaviour)

    if behaviour.bodiless:
        return Worker(
            make(1, "", 0),
            bus=bus or factory.bus,
            clock=factory.clock,
            keys=factory.keys,
            body=body_of(spec, plant, factory.clock),
            journal=HeldJournal(incarnation=1),
        )
    if not behaviour.drives:
        return Worker(
            Liar(name, plant, behaviour),
            bus=bus or factory.bus,
            clock=factory.clock,
            keys=factory.keys,
            body=None,
            journal=HeldJournal(incarnation=1),
        )
    factory.add_vehicle(spec, make)
    if behaviour.clock_ahead_s:
        # A new process begins with the time that its computer shows.
        factory.set_clock(name, behaviour.clock_ahead_s)
        factory.restart(name)
    return factory.workers[name]
