"""Where vehicles load, unload and charge."""

from __future__ import annotations

from collections.abc import Mapping

from dray.plant import Plant
from dray_sim.bodies.chargers import Chargers
from dray_sim.bodies.stores import Place


class Stands:
    """The stands of a floor; shared by the fleet.

    Args:
        plant: knows their nodes.
        places: by station.

    Attributes:
        places: by station; more may come later.
        nodes: by station.
        chargers: the plugs.
    """

    def __init__(self, plant: Plant, places: Mapping[str, Place]) -> None:
        self.places = dict(places)
        self.nodes = {station: plant.node_of(station) for station in places}
        self.chargers = Chargers()

    def add(self, station: str, place: Place, node: str) -> None:
        """Add a station that the plant does not have."""
        self.places[station], self.nodes[station] = place, node
