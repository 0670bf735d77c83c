"""Nodes with a largest vehicle: only types that fit may use the lanes to them.

A type's rectangle holds with its load, so a vehicle without one keeps off as well.
"""

from __future__ import annotations

from msgspec.structs import replace

from dray.plant.model import Lane, LaneType, Node, PlantFile, VehicleType

SAME_M = 1e-6
"""Sizes that differ by less are the same."""


def fits(kind: VehicleType, node: Node) -> bool:
    """Whether a type of vehicle, with its load, is no larger than a node allows."""
    most = node.max_vehicle
    return most is None or (kind.length_m <= most.length_m + SAME_M and kind.width_m <= most.width_m + SAME_M)


def too_large_for(file: PlantFile, kind: VehicleType) -> tuple[str, ...]:
    """The nodes at which a type of vehicle may not be."""
    return tuple(node.id for node in file.nodes if not fits(kind, node))


def fitted(file: PlantFile) -> PlantFile:
    """A file whose lanes are for the types that fit at both of their ends; a lane for none is left out.

    The file itself where no node has a largest vehicle.
    """
    if all(node.max_vehicle is None for node in file.nodes):
        return file
    shut = {kind.id: frozenset(too_large_for(file, kind)) for kind in file.vehicle_types}
    lanes = tuple(own for lane in file.lanes if (own := _fitted(lane, shut)) is not None)
    return file if lanes == file.lanes else replace(file, lanes=lanes)


def _fitted(lane: Lane, shut: dict[str, frozenset[str]]) -> Lane | None:
    out = {kind for kind, nodes in shut.items() if nodes & {lane.start, lane.end}}
    if not out:
        return lane
    listed = lane.types or tuple(LaneType(kind) for kind in shut)
    types = tuple(each for each in listed if each.type not in out)
    return replace(lane, types=types) if types else None
