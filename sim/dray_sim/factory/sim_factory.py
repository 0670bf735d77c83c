"""One whole simulated factory: bodies, network and one worker per agent, from a plant and a seed.

Everything is built here and nothing starts by itself: `run` starts it, and ends with it. While it runs, agents may be
crashed, asked to leave, and restarted one by one. A crash ends an agent's process between two effects. Its body and
its journal stay, and the next life starts from them. Without power the body stands too.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterator
from functools import partial
from hashlib import sha256
from math import hypot
from random import Random

from msgspec.structs import replace

from dray import __version__
from dray.adapters.security.signing import SigningKey, TrustedKeys
from dray.messages.keys import GATE, Keys, strategists_of
from dray.messages.kinds import Kind
from dray.plant import Plant, with_machine
from dray.plant.model import MachineSpec, VehicleSpec
from dray.ports import Bus, Clock
from dray.protocol.gate.gate import DeliveryGate
from dray.protocol.machine.machine import Machine
from dray.protocol.runtime.running import Running
from dray.protocol.runtime.trust import Trusts
from dray.protocol.station.station import Station
from dray.protocol.strategist.gated import GatedStrategist
from dray.protocol.traffic.driving.place_requests import unsigned
from dray.protocol.traffic.traffic_map import TrafficMap
from dray.protocol.vehicle.atv import Atv
from dray.worker.worker import Worker
from dray_sim.bodies.floor import FIRST_STOCK_FRAC, Floor
from dray_sim.bodies.gate import Gate
from dray_sim.bodies.vehicle.vehicle import SimVehicle
from dray_sim.bodies.workcell import SimWorkcell
from dray_sim.clock.computer import ComputerClock
from dray_sim.clock.loop import VirtualClock
from dray_sim.factory.installation import (
    Bodies,
    Embody,
    Installation,
    MakeAgent,
    MakeBody,
    always,
    directly,
)
from dray_sim.factory.journal import HeldJournal
from dray_sim.factory.request_keys import RequestKeys
from dray_sim.network.coverage import Coverage
from dray_sim.network.latency import WLAN, Latency
from dray_sim.network.listeners import Listener
from dray_sim.network.sim_network import SimNetwork


def with_gate(
    plant: Plant, gate: Gate, strategists: tuple[str, ...], bodies: Bodies
) -> Iterator[tuple[str, Kind, MakeAgent, MakeBody]]:
    """The gate and each strategist: how its agent is made, and its body. Strategists have none."""
    yield (
        GATE,
        Kind.GATE,
        lambda life, software, _probation: DeliveryGate(plant, incarnation=life, software=software),
        partial(bodies.embody_gate, gate),
    )
    for strategist in strategists:
        yield strategist, Kind.STRATEGIST, _maker(plant, strategist, strategists), always(None)


def _maker(plant: Plant, agent: str, strategists: tuple[str, ...]) -> MakeAgent:
    others = tuple(other for other in strategists if other != agent)
    return lambda life, _software, _probation: GatedStrategist(
        plant, agent=agent, incarnation=life, others=others
    )


class SimFactory:
    """A factory that is ready to run.

    Args:
        plant: the layout.
        clock: the virtual clock of the loop that it will run on.
        seed: of everything random in the factory.
        incarnation: of every agent's first life; names tasks and goals apart.
        stock_frac: how full buffers are at the start, as a range of fractions of their capacity.
        latency: of the network.
        codec: pass every message through the wire format.
        listener: hears everything that is said.
        meet: makes the agents' bus out of the simulated network.
        authority: grants the commands of simulated people, and is the one that vehicles believe; follows from the seed by default.
        traffic: whether vehicles drive with right of way; else as if each were alone.
        embody: makes an adapter between a vehicle and each life of its agent; none by default.
        bodies: likewise for machines, storages and the gate.
        strategists: how many there are.

    Attributes:
        authority: grants the commands of simulated people.
        trusts: whose grants vehicles believe.
        request_keys: with which vehicles sign their messages to replicas of reservation tables.
        bus: the simulated network; join it to take part.
        floor: all bodies and places.
        vehicles, workcells, storages, delivery, source: those of the floor.
        workers: by agent id; of a crashed agent, that of its last life.
        journals: by agent id.
        gate, strategists: the gate of all delivery warehouses, and the ids of the strategists that share it.
        in_hands: pieces that people carry, by item.
        arrived: how many pieces of a goal are in: by default those that the gate has; with a controller before it, others may wait there.
        has_levels: whether stations learn by the levels of controllers what lies in their storages.
    """

    def __init__(
        self,
        plant: Plant,
        clock: VirtualClock,
        *,
        seed: int,
        incarnation: int = 1,
        stock_frac: tuple[float, float] = FIRST_STOCK_FRAC,
        latency: Latency = WLAN,
        codec: bool = False,
        listener: Listener | None = None,
        meet: Callable[[Bus], Bus] = lambda network: network,
        authority: SigningKey | None = None,
        traffic: bool = False,
        embody: Embody = directly,
        bodies: Bodies | None = None,
        strategists: int = 1,
    ) -> None:
        self._embody = embody
        bodies = bodies or Bodies()
        self.has_levels = bodies.has_levels
        self.plant = plant
        self.clock = clock
        self.keys = Keys(plant.id)
        self.authority = authority or SigningKey(sha256(f"{seed} authority".encode()).digest())
        self.trusts: Trusts = TrustedKeys(self.authority.public)
        # Each concern has its own generator, so that a change to one does not shift the chances of another.
        self.bus = SimNetwork(
            clock,
            Random(f"{seed} network"),
            latency,
            codec=codec,
            trace=listener,
            chance=Random(f"{seed} network faults"),
            coverage=Coverage.of_plant(plant),
        )
        self._meet = meet(self.bus)
        self.request_keys = RequestKeys(seed)
        self.traffic = TrafficMap(plant, self.request_keys.is_signed) if traffic else None
        self.floor = floor = Floor(plant, clock, seed=seed, stock_frac=stock_frac)
        self.source, self.gate, self.delivery = floor.source, floor.gate, floor.delivery
        self.arrived: Callable[[str], int] = self.gate.arrived
        self.storages, self.workcells, self.vehicles = floor.storages, floor.workcells, floor.vehicles
        self.in_hands = floor.in_hands
        self.workers: dict[str, Worker] = {}
        self.journals: dict[str, HeldJournal] = {}
        self._installations: dict[str, Installation] = {}
        self._lives: dict[str, asyncio.Task[None]] = {}
        """Tasks that run the workers, by agent id."""
        self._incarnation = incarnation
        self._group: asyncio.TaskGroup | None = None
        for machine, workcell in self.workcells.items():
            body = partial(bodies.embody_machine, workcell)
            self._employ(machine, Kind.MACHINE, self._machine(machine, plant), body)
        for storage, place in self.storages.items():
            self._employ(storage, Kind.STATION, self._station(storage), partial(bodies.embody_store, place))
        for spec in plant.fleet.values():
            self._man(spec)
        self.strategists = strategists_of(strategists)
        for agent, kind, make, embodied in with_gate(plant, self.gate, self.strategists, bodies):
            self._employ(agent, kind, make, embodied)

    async def run(self) -> None:
        """Run all agents until cancelled.

        Raises:
            ExceptionGroup: an agent ended by an exception (invariant 8).
        """
        try:
            async with asyncio.TaskGroup() as self._group:
                for agent in self.workers:
                    self._start(agent)
                # A factory whose agents have all crashed is still there: they may be restarted.
                await asyncio.Event().wait()
        finally:
            self._group = None

    # --- lives -----------------------------------------------------------------------------------

    def running(self, agent: str) -> bool:
        """Whether the agent's process is there.

        Raises:
            KeyError: there is no such agent.
        """
        return not self.workers[agent].ended

    def ask_to_leave(self, agent: str) -> None:
        """Let an agent shut down gracefully, in its own time; its body and its journal stay. Twice is harmless.

        Raises:
            KeyError: there is no such agent.
        """
        self.workers[agent].leave()

    async def leave(self, agent: str) -> None:
        """Let an agent shut down gracefully, and wait until it has left.

        Raises:
            KeyError: there is no such agent, or it was never started.
        """
        self.ask_to_leave(agent)
        await asyncio.wait({self._lives[agent]})

    def crash(self, agent: str) -> None:
        """End an agent's process now; its body goes on without it, as bodies do. Twice is harmless.

        Raises:
            KeyError: there is no such agent.
        """
        self.workers[agent].kill()

    def restart(self, agent: str, software: str = "", *, probation: int = 0) -> None:
        """Begin an agent's next life; one that still lives ends first, one without power waits for it.

        Args:
            agent: a machine, a vehicle, a storage, the gate or the strategist.
            software: the version that it runs from now on; empty for the one that it has.
            probation: transports that this life has to do well before it takes long tasks.

        Raises:
            KeyError: there is no such agent.
        """
        installed = self._installations[agent]
        installed.software = software or installed.software
        self.workers[agent].kill()
        if agent in (*self.strategists, GATE) or agent in self.storages or not self._powered(agent).off:
            installed.journal.begin_life()
            installed.clock.begin_life()
            self.floor.carried.discard(agent)
            self._enliven(agent, probation)
            self._start(agent)

    def uncounted(self, place: str, item: str) -> int:
        """Pieces of an item that lie at a machine or storage unknown to its body."""
        return self.workcells[place].uncounted(item) if place in self.workcells else 0

    def prepare_software(self, agent: str, software: str) -> None:
        """Newer software lies ready for an agent: it runs from its next update on."""
        self._installations[agent].newest = software

    def lose_journal(self, agent: str) -> None:
        """End an agent's process now, and let its next life find an empty journal.

        Raises:
            KeyError: there is no such agent.
        """
        self.crash(agent)
        self._installations[agent].journal.lose("the disk has failed")

    def set_clock(self, agent: str, by_s: float) -> None:
        """Set the clock of an agent's computer forward, or back if negative.

        Raises:
            KeyError: there is no such agent.
        """
        self._installations[agent].clock.step(by_s)

    def clock_error_s(self) -> float:
        """Largest error of any agent's clock (s)."""
        return max((abs(installed.clock.ahead_s) for installed in self._installations.values()), default=0.0)

    def clock_of(self, agent: str) -> Clock:
        """The clock of an agent.

        Raises:
            KeyError: there is no such agent.
        """
        return self._installations[agent].clock

    def power_off(self, agent: str) -> None:
        """Switch a vehicle or a machine off, its agent with it. Twice is harmless.

        Raises:
            KeyError: there is no vehicle or machine of this id.
        """
        self._powered(agent).power_off()
        self.crash(agent)

    def power_on(self, agent: str) -> None:
        """Switch it on again: its agent begins another life. Harmless when it has power.

        A vehicle off the floor is not switched on.

        Raises:
            KeyError: there is no vehicle or machine of this id.
        """
        body = self._powered(agent)
        if body.off and agent not in self.floor.lifted:
            body.power_on()
            self.restart(agent)

    def add_vehicle(self, spec: VehicleSpec, make: MakeAgent | None = None) -> SimVehicle:
        """Let a vehicle join; in a factory that runs, at once.

        Args:
            spec: its id, its type in the plant, and its node; with right of way, that node or the nearest free place.
            make: makes its agent, where that is not the honest one.

        Raises:
            ValueError: there is an agent of this id.
        """
        if spec.id in self._installations:
            raise ValueError(f"{spec.id} is there already; give the new vehicle another id")
        if self.traffic is not None:
            spec = replace(spec, node=self._free_near(spec.node))
        vehicle = self.floor.add_vehicle(spec)
        self._man(spec, make)
        self._start(spec.id)
        return vehicle

    def held_places(self) -> dict[str, str]:
        """Place -> holder, by the vehicles' own state; for a vehicle whose process has ended, by its last state.

        Empty without right of way.

        A vehicle that was lifted off the floor holds none before it is switched on.
        """
        holders: dict[str, str] = {}
        for atv in self.vehicles:
            if atv in self.floor.carried:
                continue
            agent = self.workers[atv].agent
            right_of_way = agent.right_of_way if isinstance(agent, Atv) else None
            holders |= dict.fromkeys(right_of_way.holds if right_of_way is not None else (), atv)
        return holders

    @property
    def lanes(self) -> frozenset[tuple[str, str]]:
        """All lanes, by their ends."""
        return frozenset((lane.start, lane.end) for lane in self.plant.roads.lanes)

    def obstruct(self, lane: tuple[str, str], thing: str) -> bool:
        """See `Floor.obstruct`."""
        return self.floor.obstruct(lane, thing)

    def clear(self, lane: tuple[str, str]) -> None:
        """See `Floor.clear`."""
        self.floor.clear(lane)

    def add_machine(self, spec: MachineSpec) -> SimWorkcell:
        """Let a machine join that no plant file has; in a factory that runs, at once.

        Args:
            spec: the machine.

        Raises:
            PlantError: it does not fit into this plant.
        """
        workcell = self.floor.add_machine(spec)
        plant = with_machine(self.plant, spec, spec.id)
        self._employ(spec.id, Kind.MACHINE, self._machine(spec.id, plant, joining=True), always(workcell))
        self._start(spec.id)
        return workcell

    # --- how it is done --------------------------------------------------------------------------

    def _free_near(self, node: str) -> str:
        """A node where people put a vehicle down: free and not about to be taken, rather a dwell point than on a road."""
        nodes, plant = self.plant.nodes, self.plant
        taken = {*self.held_places(), *(self.vehicles[atv].sense().node for atv in self.floor.standing)}
        places = [plant.node_of(point) for point in plant.dwell_points], plant.stops
        free = next(found for some in places if (found := [stop for stop in some if stop not in taken]))
        here = nodes[node]
        return min(free, key=lambda one: hypot(nodes[one].x_m - here.x_m, nodes[one].y_m - here.y_m))

    def _man(self, spec: VehicleSpec, make: MakeAgent | None = None) -> None:
        """Give a vehicle that is on the floor its modem and its agent."""
        vehicle = self.vehicles[spec.id]
        self.bus.equip(spec.id, lambda: vehicle.pose, vehicle.notice_link)
        self._employ(
            spec.id, Kind.ATV, make or self._atv(spec), lambda life: self._embody(spec, vehicle, life)
        )

    def _powered(self, agent: str) -> SimVehicle | SimWorkcell:
        return self.vehicles[agent] if agent in self.vehicles else self.workcells[agent]

    def _machine(self, machine: str, plant: Plant, *, joining: bool = False) -> MakeAgent:
        return lambda life, software, probation: Machine(
            machine,
            plant,
            incarnation=life,
            software=software,
            joining=joining,
            probation=probation,
            traffic=self.traffic,
            trusts=self.trusts,
            running=Running(starts_again=True, updates=True),
        )

    def _station(self, storage: str) -> MakeAgent:
        return lambda life, software, _probation: Station(
            storage, self.plant, incarnation=life, software=software, traffic=self.traffic, trusts=self.trusts
        )

    def _atv(self, spec: VehicleSpec) -> MakeAgent:
        return lambda life, software, probation: Atv(
            spec.id,
            self.plant,
            vehicle_type=spec.type,
            incarnation=life,
            software=software,
            probation=probation,
            trusts=self.trusts,
            traffic=self.traffic,
            sign_request=self.request_keys.of(spec.id) if self.traffic is not None else unsigned,
        )

    def _employ(self, agent: str, kind: Kind, make: MakeAgent, body: MakeBody) -> None:
        self.bus.kinds[agent] = kind
        journal = self.journals[agent] = HeldJournal(incarnation=self._incarnation)
        self._installations[agent] = Installation(make, body, journal, ComputerClock(self.clock), __version__)
        self._enliven(agent)

    def _enliven(self, agent: str, probation: int = 0) -> None:
        """Give an agent its worker, which is not started yet."""
        installed = self._installations[agent]
        self.workers[agent] = Worker(
            installed.make(installed.journal.incarnation, installed.software, probation),
            bus=self._meet,
            clock=installed.clock,
            keys=self.keys,
            body=installed.body(installed.journal.incarnation),
            journal=installed.journal,
        )

    def _start(self, agent: str) -> None:
        """Let an agent's worker run, in a factory that does."""
        if self._group is not None:
            # The worker is bound here: another one may have taken its place before the task begins.
            self._lives[agent] = self._group.create_task(self._live(agent, self.workers[agent]), name=agent)

    async def _live(self, agent: str, worker: Worker) -> None:
        """Run one life of an agent; start the next one when the agent has left for that."""
        await worker.run()
        if worker.left is not None and worker.left.again and self.workers[agent] is worker:
            self.restart(agent, self._installations[agent].newest if worker.left.update else "")
