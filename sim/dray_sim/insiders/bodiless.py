"""A vehicle's software without a vehicle: it drives through a plant in which every place gives and takes any load.

The case is a body's driver that answers from a table, or a vehicle's computer that runs in an office. Every message
is that of an honest vehicle, and nothing moves.
"""

from __future__ import annotations

from collections.abc import Callable

from dray.plant import Plant
from dray.plant.model import VehicleSpec
from dray.ports import Body, Clock
from dray_sim.bodies.stands import Stands
from dray_sim.bodies.vehicle.vehicle import SimVehicle


class _Nowhere:
    """A place that is in no plant (see `dray_sim.bodies.stores.Place`): it accepts every request."""

    def take(self, vehicle: str, item: str, quantity: int) -> str:
        return ""

    def put(self, vehicle: str, item: str, quantity: int, goal: str = "") -> str:
        return ""

    def wait_for(self, item: str, quantity: int, then: Callable[[], None]) -> bool:
        return False


def body_of(spec: VehicleSpec, plant: Plant, clock: Clock) -> Body:
    """The simulated body that such software believes to have.

    Args:
        spec: its supposed position.
        plant: its supposed plant, with chargers of its own.
        clock: the plant's clock.
    """
    places = (*plant.storages, *plant.machines, *plant.warehouses)
    kind = plant.vehicle_types[spec.type]
    return SimVehicle(spec, kind, plant, clock, Stands(plant, dict.fromkeys(places, _Nowhere())))
