"""The floor of a plant: bodies and places, with no agent in it.

Vehicles, workcells, storages and the gate of the delivery warehouses act on one another here as physical things do: a
load that a vehicle puts down is there. The module takes no decisions; instructions come from agents or people.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from functools import partial
from random import Random

import msgspec

from dray.body import Drop, Pick
from dray.errors import PlantError
from dray.messages import THING
from dray.messages.keys import GATE
from dray.plant import Plant, with_machine
from dray.plant.floor.rectangles import Rectangle
from dray.plant.model import MachineSpec, VehicleSpec
from dray.ports import Body, Clock
from dray_sim.bodies.doors import Doors
from dray_sim.bodies.gate import Gate
from dray_sim.bodies.held_out import HeldOut
from dray_sim.bodies.obstacles import Ends, Obstacles, behind
from dray_sim.bodies.stands import Stands
from dray_sim.bodies.stores import DeliveryWarehouse, Place, SourceWarehouse, Storage
from dray_sim.bodies.vehicle.condition import LOAD_DROPPED, SHIFTED
from dray_sim.bodies.vehicle.vehicle import SimVehicle
from dray_sim.bodies.workcell import SimWorkcell

FIRST_STOCK_FRAC = (0.4, 1.0)
"""Buffers at the start of a run: a shift begins where the one before it ended."""

NEARLY_EMPTY_FRAC = (0.02, 0.15)
"""Buffer levels of a plant to look at: vehicles get work with the first orders. With full buffers none would move in
the first minutes of real time."""


TAKEN_UP_WITHIN_S = 1.0
"""Longest time until a lost load that a person has taken up is off the floor."""


class Pieces(msgspec.Struct, frozen=True):
    """All pieces of a floor, counted at one moment.

    Attributes:
        balance: pieces in sight less pieces that came in, plus those used up, by item: constant for ever.
        delivered: pieces in the delivery warehouses, by product.
        arrived: pieces that the gate has let in, by goal.
    """

    balance: dict[str, int]
    delivered: dict[str, int]
    arrived: dict[str, int]


class Floor:
    """All bodies and places of a plant.

    Args:
        plant: the layout.
        clock: the plant's clock.
        seed: of everything random: how full buffers are, and durations that vary.
        stock_frac: how full buffers are at the start, as a range of fractions of their capacity.

    Attributes:
        vehicles, workcells, storages, delivery: the bodies and places by id.
        doors: those of the plant file.
        obstacles: on the lanes.
        source: where material comes from.
        gate: of all delivery warehouses.
        in_hands: pieces that people carry, by item.
        held_out: pieces in hands that vehicles may take, by node.
        lifted: vehicles that people have taken off the floor.
        carried: lifted vehicles, and those that were put down and not switched on since: the places that their last
            life held are void.
    """

    def __init__(
        self,
        plant: Plant,
        clock: Clock,
        *,
        seed: int,
        stock_frac: tuple[float, float] = FIRST_STOCK_FRAC,
    ) -> None:
        self._plant, self._clock, self._seed = plant, clock, seed
        self.source = SourceWarehouse(plant.source_warehouses[0], plant.materials)
        self.gate = Gate(clock)
        self.delivery: Mapping[str, DeliveryWarehouse] = {
            warehouse: DeliveryWarehouse(warehouse, plant.materials, self.gate)
            for warehouse in plant.delivery_warehouses
        }
        self.storages: dict[str, Storage] = {
            spec.id: Storage(
                spec, clock, self.source, parts=plant.parts, takes_all=spec.id in plant.warehouses
            )
            for spec in plant.stores.values()
        }
        stock = Random(f"{seed} stock")
        self.workcells: dict[str, SimWorkcell] = {
            spec.id: SimWorkcell(
                spec, plant, clock, stock=_first_stock(plant, spec.id, stock_frac, stock), seed=seed
            )
            for spec in plant.machines.values()
        }
        self.in_hands: Counter[str] = Counter()
        self.held_out = {node: HeldOut(self.in_hands) for node in plant.stops if not plant.has_place(node)}
        self.vehicles: dict[str, SimVehicle] = {}
        self.doors = Doors(plant, clock, self.vehicles)
        self.obstacles = Obstacles(plant, self.doors if plant.doors else None)
        self.lifted: set[str] = set()
        self.carried: set[str] = set()
        places: dict[str, Place] = {
            **dict.fromkeys(plant.source_warehouses, self.source),
            **self.storages,
            **self.workcells,
            **self.delivery,
        }
        self._stands = Stands(plant, places)
        for node, held_out in self.held_out.items():
            self._stands.add(node, held_out, node)
        for spec in plant.fleet.values():
            self.add_vehicle(spec)

    @property
    def standing(self) -> tuple[str, ...]:
        """The vehicles that stand on the floor."""
        return tuple(atv for atv in self.vehicles if atv not in self.lifted)

    def lift(self, atv: str) -> None:
        """Take a vehicle that is switched off away from the floor; harmless when it is.

        Raises:
            KeyError: there is no such vehicle.
        """
        self.vehicles[atv].place_at("")
        self.lifted.add(atv)
        self.carried.add(atv)

    def put_down(self, atv: str, node: str) -> None:
        """Put a lifted vehicle on a node, switched off as it is; harmless when it is on the floor.

        Raises:
            KeyError: there is no such vehicle.
        """
        if atv in self.lifted:
            self.lifted.remove(atv)
            self.vehicles[atv].place_at(node)

    def follow(self, atv: str, action: Pick | Drop) -> str:
        """Repeat a pick or drop of a vehicle that is not simulated here: its double does it, and the place counts it.

        A load that the place refuses is not counted. Pieces that were put down past it, or that the vehicle no longer
        has, are in people's hands.

        Returns:
            "" when it is counted, else why not.

        Raises:
            KeyError: there is no such vehicle.
        """
        double = self.vehicles[atv]
        if isinstance(action, Pick):
            self._take_off(double)
        reason = double.follow(action)
        if reason and isinstance(action, Drop):
            self._take_off(double)
        return reason

    def _take_off(self, double: SimVehicle) -> None:
        item, quantity = double.recover_load()
        if item:
            self.in_hands[item] += quantity

    def obstruct(self, lane: Ends, thing: str) -> bool:
        """Put something in the middle of a lane.

        Returns:
            False when it would lie under a vehicle, or so near before one that this cannot stop in time; then nothing
                has changed.

        Raises:
            KeyError: there is no such lane.
        """
        return self._put(lane, self.obstacles.shape(lane, thing), self.standing)

    def drop_load(self, atv: str) -> bool:
        """Let a vehicle that carries something on a lane lose it: it lies behind it there, and the vehicle stands.

        Either ends when a person has mended that, or taken the load away.

        Returns:
            False when it carries nothing, is on no lane, or another one would be hit or cannot stop; nothing has changed then.

        Raises:
            KeyError: there is no such vehicle.
        """
        vehicle = self.vehicles[atv]
        state = vehicle.sense()
        lane = (state.node, state.next_node)
        if not state.load or not state.speed_mps or lane[0] == lane[1] or vehicle.problem:
            return False
        longest_m = max(kind.length_m for kind in self._plant.vehicle_types.values())
        others = tuple(other for other in self.standing if other != atv)
        if not self._put(lane, behind(state.pose, longest_m), others):
            return False
        vehicle.break_down(LOAD_DROPPED, SHIFTED)
        self._clock.call_at(self._clock.now_s() + TAKEN_UP_WITHIN_S, partial(self._take_up, atv, lane))
        return True

    def _take_up(self, atv: str, lane: Ends) -> None:
        """Clear the lost load once a person has repaired the vehicle or taken the load."""
        vehicle = self.vehicles[atv]
        if vehicle.problem and vehicle.sense().load:
            self._clock.call_at(self._clock.now_s() + TAKEN_UP_WITHIN_S, partial(self._take_up, atv, lane))
        else:
            self.clear(lane)

    def _put(self, lane: Ends, shape: Rectangle, near: Iterable[str]) -> bool:
        """Put something on a lane; False when it would lie under one of these vehicles, or so near before one that this cannot stop."""
        standing = [self.vehicles[atv] for atv in near]
        poses = [each.sense().pose for each in standing]
        if lane in self.obstacles.shapes or any(
            self.obstacles.touches(shape, pose.x_m, pose.y_m) for pose in poses
        ):
            return False
        self.obstacles.lay(lane, shape)
        if not all(each.can_stop for each in standing):
            self.obstacles.take_away(lane)
            return False
        self._look()
        return True

    def clear(self, lane: Ends) -> None:
        """Take away what is on a lane; harmless where nothing is."""
        self.obstacles.take_away(lane)
        self._look()

    def _look(self) -> None:
        for vehicle in self.vehicles.values():
            vehicle.look()

    def add_vehicle(self, spec: VehicleSpec) -> SimVehicle:
        """Put one more vehicle down.

        Args:
            spec: its id, its type in the plant, and where it stands.

        Raises:
            PlantError: there is no such type or place in this plant.
        """
        for field, name, there in (
            ("type", spec.type, self._plant.vehicle_types),
            ("node", spec.node, self._plant.nodes),
        ):
            if name not in there:
                raise PlantError(spec.id, field, f"the plant has no {field} {name!r}")
        vehicle_type = self._plant.vehicle_types[spec.type]
        vehicle = SimVehicle(
            spec,
            vehicle_type,
            self._plant,
            self._clock,
            self._stands,
            self._seed,
            self.obstacles,
        )
        self.vehicles[spec.id] = vehicle
        return vehicle

    def add_machine(self, spec: MachineSpec) -> SimWorkcell:
        """Set one more machine up, with empty buffers.

        Args:
            spec: the machine.

        Raises:
            PlantError: it does not fit into this plant.
        """
        plant = with_machine(self._plant, spec, spec.id)
        workcell = SimWorkcell(spec, plant, self._clock, seed=self._seed)
        self.workcells[spec.id] = workcell
        self._stands.add(spec.id, workcell, spec.node)
        return workcell

    def add(self, spec: VehicleSpec | MachineSpec) -> Body:
        """Put down or set up one more; see above."""
        return self.add_vehicle(spec) if isinstance(spec, VehicleSpec) else self.add_machine(spec)

    @property
    def bodies(self) -> dict[str, Body]:
        """The bodies by the names of their agents."""
        return {**self.workcells, **self.storages, **self.vehicles, GATE: self.gate}

    def lying(self) -> Counter[str]:
        """All visible pieces by item, except delivered ones; those on dead vehicles and in people's hands count."""
        lies: Counter[str] = Counter(self.in_hands)
        for storage in self.storages.values():
            lies.update(storage.stock)
            lies[THING] += storage.things
        for workcell in self.workcells.values():
            lies.update(workcell.sense().stock)
            lies[THING] += workcell.things
        for warehouse in self.delivery.values():
            lies.update(warehouse.aside)
        for vehicle in self.vehicles.values():
            state = vehicle.sense()
            if state.load:
                lies[state.load] += state.load_quantity
        return lies

    def count(self) -> Pieces:
        """Count all pieces.

        Pieces on dead vehicles count as on board; goods set aside and pieces in people's hands count as seen.
        """
        balance: Counter[str] = Counter(dict.fromkeys((*self._plant.materials, *self._plant.products), 0))
        balance.update(self.lying())
        delivered: Counter[str] = Counter()
        for workcell in self.workcells.values():
            balance.update(workcell.consumed)
            balance.subtract(workcell.made)
        for warehouse in self.delivery.values():
            delivered.update(warehouse.arrived)
        balance.update(delivered)
        for material in self._plant.materials:
            balance[material] -= self.source.supplied(material)
        return Pieces(dict(balance), dict(delivered), self.gate.sense().arrived)


def _first_stock(plant: Plant, machine: str, frac: tuple[float, float], random: Random) -> dict[str, int]:
    return {
        material: round(plant.materials[material].buffer * random.uniform(*frac))
        for material in plant.materials_of(machine)
        if material not in plant.parts
    }
