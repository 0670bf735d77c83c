"""The places, their replicas and the ways that every agent derives alike from the plant for right of way."""

from __future__ import annotations

from collections.abc import Callable

from dray.messages.floor.traffic import PlaceRequested
from dray.plant import Plant
from dray.protocol.traffic.places import Places
from dray.protocol.traffic.ways import Ways

IsSigned = Callable[[str, PlaceRequested], bool]
"""Called with a vehicle's name and its request."""


def names_no_key(_atv: str, request: PlaceRequested) -> bool:
    """Whether a request has no key: for agents that cannot check signatures, only such requests count."""
    return not request.key


class TrafficMap:
    """Places and ways of one plant. An agent that is given one drives, or keeps tables, with right of way.

    It depends on the plant alone and never changes, so agents of one process may share it.

    Args:
        plant: nodes, lanes, machines and vehicle types.
        is_signed: whether a vehicle's request is signed by the key that it names, or names none.

    Attributes:
        is_signed: likewise.
        places: the places and their replicas.
        atvs: the vehicles of the plant file.
    """

    def __init__(self, plant: Plant, is_signed: IsSigned = names_no_key) -> None:
        self.is_signed = is_signed
        self.places = Places(plant)
        self.atvs = tuple(plant.fleet)
        self._plant = plant
        self._ways: dict[str, Ways] = {}

    def ways(self, vehicle_type: str) -> Ways:
        """The ways of a type of vehicle."""
        if vehicle_type not in self._ways:
            kind = self._plant.vehicle_types[vehicle_type]
            self._ways[vehicle_type] = Ways(self._plant, self.places, kind)
        return self._ways[vehicle_type]
