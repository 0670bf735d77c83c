"""A vehicle's software without a vehicle: it drives through a plant in which every place gives and takes whatever it says.

As when a body's driver answers from a table, or a vehicle's computer is carried into an office and left running: every
word that it says is what an honest vehicle would say, and nothing moves.
"""

from __future__ import annotations

from collections.abc import Callable

from dray.plant import Plant
from dray.plant.model import VehicleSpec
from dray.ports import Body, Clock
from dray_sim.bodies.chargers import Chargers
from dray_sim.bodies.vehicle.vehicle import SimVehicle


class _Nowhere:
    """A place that is in no plant (see `dray_sim.bodies.stores.Place`): it gives what is asked for, and takes what is brought."""

    def take(self, vehicle: str, item: str, quantity: int) -> str:
        return ""

    def put(self, vehicle: str, item: str, quantity: int, goal: str = "") -> str:
        return ""

    def wait_for(self, item: str, quantity: int, then: Callable[[], None]) -> bool:
        return False


def body_of(spec: VehicleSpec, plant: Plant, clock: Clock) -> Body:
    """What such software believes to be its body.

    Args:
        spec: where it believes to stand.
        plant: in which it believes to be; its chargers are its own.
        clock: the plant's clock.
    """
    places = (*plant.storages, *plant.machines, *plant.warehouses)
    docks = {place: plant.node_of(place) for place in places}
    kind = plant.vehicle_types[spec.type]
    return SimVehicle(spec, kind, plant, clock, dict.fromkeys(places, _Nowhere()), docks, Chargers())
