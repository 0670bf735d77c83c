"""Manual work of people: repair a vehicle or its WLAN, carry its load, push it to a charger.

Each action happens at one instant; `dray_sim.people.operators` decides when. Pieces that a person carries are
counted, so that material can be balanced meanwhile (invariant 2).
"""

from __future__ import annotations

from math import hypot
from typing import TYPE_CHECKING

from dray_sim.bodies.vehicle.condition import BATTERY_EMPTY

if TYPE_CHECKING:
    from dray_sim.factory.sim_factory import SimFactory


class Hands:
    """The hands of everybody in one factory.

    Args:
        factory: whose things they are.
    """

    def __init__(self, factory: SimFactory) -> None:
        self._factory = factory

    def problem(self, atv: str) -> str:
        """The fault that a person beside the vehicle sees; empty for none, and for an agent without a vehicle."""
        vehicle = self._factory.vehicles.get(atv)
        return "" if vehicle is None else vehicle.problem

    def is_off(self, atv: str) -> bool:
        """Whether it stands there and its lights are out."""
        vehicle = self._factory.vehicles.get(atv)
        return vehicle is not None and vehicle.off and atv not in self._factory.floor.lifted

    def mend(self, atv: str) -> None:
        """Repair a fault; an empty battery is exchanged."""
        vehicle = self._factory.vehicles[atv]
        vehicle.repair()
        if vehicle.problem == BATTERY_EMPTY:
            vehicle.replace_battery()

    def machine_problem(self, machine: str) -> str:
        """The fault of a machine, as long as it is not repaired."""
        state = self._factory.workcells[machine].sense()
        return "" if state.resettable else state.broken

    def mend_machine(self, machine: str) -> None:
        """Put a machine right; it works again when it is told so."""
        self._factory.workcells[machine].mend()

    def plug_in(self, atv: str) -> bool:
        """Put its WLAN right; returns whether it was the vehicle's own that was wrong."""
        return self._factory.bus.plug_in(atv)

    def unload(self, atv: str) -> tuple[str, int]:
        """Take the load off, into one's hands. Returns the item and how many; `("", 0)` for nothing."""
        item, quantity = self._factory.vehicles[atv].recover_load()
        if item:
            self._factory.in_hands[item] += quantity
        return item, quantity

    def hold_out(self, item: str, quantity: int, node: str) -> None:
        """Hold pieces out at a node, for a vehicle to take."""
        self._factory.floor.held_out[node].offer(item, quantity)

    def holds(self, item: str, quantity: int, node: str) -> bool:
        """Whether it is held out still, and no vehicle has taken it."""
        return self._factory.floor.held_out[node].has(item, quantity)

    def take_back(self, item: str, quantity: int, node: str) -> None:
        """Hold it out no more."""
        self._factory.floor.held_out[node].take_back(item, quantity)

    def put_down(self, item: str, quantity: int, near: str, machine: str = "") -> str:
        """Bring pieces in hands to their place.

        Material goes to the nearest storage with room for it, else back to the source warehouse. A
        product goes back to the goods of its machine, else it is set aside at a delivery warehouse.

        Args:
            item: a material or product.
            quantity: pieces.
            near: the node where they were picked up.
            machine: whose product it is, where that is known.

        Returns:
            The place where they are now.
        """
        if item in self._factory.plant.materials:
            place = self._store(item, quantity, near)
        else:
            place = self._bring_back(item, quantity, machine)
        self._factory.in_hands[item] -= quantity
        return place

    def bring_home(self, atv: str) -> str:
        """Push a vehicle to the nearest charger where none stands, mend it and switch it on.

        Returns:
            The charger; empty when all are taken, and it was switched on where it stood.
        """
        vehicle, plant = self._factory.vehicles[atv], self._factory.plant
        taken = {each.sense().node for each in self._factory.vehicles.values() if each is not vehicle}
        free = [charger for charger in plant.chargers if plant.node_of(charger) not in taken]
        nearest = "".join(plant.closest(vehicle.sense().node, free, 1))
        if nearest:
            vehicle.place_at(plant.node_of(nearest))
        self.mend(atv)
        self._factory.power_on(atv)
        return nearest

    def nodes_for(self, atv: str) -> tuple[str, ...]:
        """Nodes where a lifted vehicle could be put down: free chargers and parking places, the nearest first."""
        plant, vehicles = self._factory.plant, self._factory.vehicles
        taken = {vehicles[other].sense().node for other in self._factory.floor.standing}
        nodes = {point: plant.node_of(point) for point in plant.dwell_points}
        free = [point for point, node in nodes.items() if node not in taken]
        return tuple(nodes[point] for point in plant.closest(vehicles[atv].sense().node, free, len(free)))

    def node_beside(self, atv: str) -> str:
        """The nearest node where another vehicle can fetch this one's load; empty for none."""
        plant, vehicles = self._factory.plant, self._factory.vehicles
        taken = {vehicles[other].sense().node for other in self._factory.floor.standing}
        here = plant.nodes[vehicles[atv].sense().node]

        def away_m(node: str) -> float:
            return hypot(plant.nodes[node].x_m - here.x_m, plant.nodes[node].y_m - here.y_m)

        there = (node for node in sorted(self._factory.floor.held_out) if node not in taken)
        return min(there, key=away_m, default="")

    def lift(self, atv: str) -> None:
        """Switch a vehicle off, and take it off the floor."""
        self._factory.power_off(atv)
        self._factory.floor.lift(atv)

    def set_down(self, atv: str, node: str) -> None:
        """Put a vehicle that was lifted on a node, mend it and switch it on."""
        self._factory.floor.put_down(atv, node)
        self.mend(atv)
        self._factory.power_on(atv)

    def _store(self, material: str, quantity: int, near: str) -> str:
        storages = self._factory.plant.storages_of(material)
        for storage in self._factory.plant.closest(near, storages, len(storages)):
            if not self._factory.storages[storage].put("", material, quantity):
                return storage
        self._factory.source.put("", material, quantity)
        return self._factory.source.id

    def _bring_back(self, product: str, quantity: int, machine: str) -> str:
        workcell = self._factory.workcells.get(machine)
        if workcell is not None and not workcell.put_by_hand(product, quantity):
            return machine
        # The goods have no goal, so the gate does not admit them and no customer gets them twice.
        aside = self._factory.plant.delivery_warehouses[0]
        self._factory.delivery[aside].put("", product, quantity)
        return aside
