"""Faults of the vehicles' names for things, and of their maps, in a plant file."""

from __future__ import annotations

from collections.abc import Iterator

from dray.plant.file.reasons import Reason
from dray.plant.model import PlantFile

Fault = tuple[str, str]
"""Field and reason."""


def name_faults(file: PlantFile) -> Iterator[Fault]:
    """Ambiguous names, and unknown maps."""
    yield from _map_faults(file)
    owners: dict[tuple[str, str], str] = {}
    for index, node in enumerate(file.nodes):
        for at, name in enumerate(node.originals or (node.id,)):
            owner = owners.setdefault((node.map, name), node.id)
            if owner != node.id:
                where = Reason("on_map", map=node.map) if node.map else ""
                field = f"nodes[{index}].originals[{at}]" if node.originals else f"nodes[{index}].id"
                yield field, Reason("original_twice", node=owner, name=name, map=where)
    for index, lane in enumerate(file.lanes):
        if lane.original_back and not lane.both_ways:
            yield f"lanes[{index}].original_back", Reason("original_back")


def _map_faults(file: PlantFile) -> Iterator[Fault]:
    maps = [frame.id for frame in file.maps]
    for index, name in enumerate(maps):
        if not name and len(maps) > 1:
            yield f"maps[{index}].id", Reason("map_empty")
        elif name in maps[:index]:
            yield f"maps[{index}].id", Reason("map_twice", map=name)
    for index, node in enumerate(file.nodes):
        if node.map and node.map not in maps:
            yield (
                f"nodes[{index}].map",
                Reason("no_map", map=node.map, known=tuple(maps[:5]) or Reason("none")),
            )
