"""Any plant with roads of two lanes."""

from __future__ import annotations

from collections.abc import Container

from msgspec.structs import replace

from dray.plant import Plant


def with_two_lanes(plant: Plant, single: Container[str] = ()) -> Plant:
    """The same plant, whose roads have two lanes.

    Args:
        plant: as it was.
        single: nodes beside which roads stay single track.
    """
    lanes = tuple(
        replace(lane, two_lanes=False) if lane.start in single or lane.end in single else lane
        for lane in plant.file.lanes
    )
    return Plant(replace(plant.file, plant=f"{plant.id}-2", lanes=lanes, two_lanes=True))
