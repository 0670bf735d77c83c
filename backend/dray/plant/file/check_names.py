"""What a plant file may not say of what vehicles call things, and of their maps."""

from __future__ import annotations

from collections.abc import Iterator

from dray.plant.model import PlantFile

Fault = tuple[str, str]
"""Field and reason."""


def name_faults(file: PlantFile) -> Iterator[Fault]:
    """Names of which nobody can tell what they mean, and maps that are nowhere said."""
    yield from _map_faults(file)
    owners: dict[tuple[str, str], str] = {}
    for index, node in enumerate(file.nodes):
        for at, name in enumerate(node.originals or (node.id,)):
            owner = owners.setdefault((node.map, name), node.id)
            if owner != node.id:
                where = f" on map {node.map}" if node.map else ""
                field = f"nodes[{index}].originals[{at}]" if node.originals else f"nodes[{index}].id"
                yield field, f"vehicles call {owner} {name}, too{where}: write what they call this one"
    for index, lane in enumerate(file.lanes):
        if lane.original_back and not lane.both_ways:
            yield (
                f"lanes[{index}].original_back",
                "nobody drives back on a lane without `both_ways`: leave it out, or add that",
            )


def _map_faults(file: PlantFile) -> Iterator[Fault]:
    maps = [frame.id for frame in file.maps]
    for index, name in enumerate(maps):
        if not name and len(maps) > 1:
            yield f"maps[{index}].id", "is empty, and there are several maps: write the vehicles' `mapId`"
        elif name in maps[:index]:
            yield f"maps[{index}].id", f"{name} is there twice: a map has one place in the plant"
    for index, node in enumerate(file.nodes):
        if node.map and node.map not in maps:
            known = ", ".join(maps[:5]) or "none"
            yield f"nodes[{index}].map", f"there is no map {node.map} in `maps` ({known}): add it there"
