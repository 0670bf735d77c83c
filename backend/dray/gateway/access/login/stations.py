"""Stations: the machines at which an operator can work."""

from __future__ import annotations

from collections.abc import Iterable

from dray.plant.floor.geometry import inside
from dray.plant.model import MachineSpec, PlantFile, Point


def stations_in(plant: PlantFile, areas: Iterable[str]) -> list[MachineSpec]:
    """The machines placed in one of these areas, by name."""
    wanted = set(areas)
    polygons = [area.polygon for area in plant.areas if area.id in wanted]
    places = {node.id: Point(node.x_m, node.y_m) for node in plant.nodes}
    found = [
        machine
        for machine in plant.machines
        if any(inside(places[machine.node], polygon) for polygon in polygons)
    ]
    return sorted(found, key=lambda machine: (machine.name, machine.id))
