"""A small plant with doors on some of its lanes."""

from __future__ import annotations

from random import Random

from msgspec.structs import replace

from dray.plant import Door, Lane, LaneEnds, PlantFile
from dray.plant.file.check_doors import door_faults

MOST = 4
"""Doors of one plant: enough that most transports pass one."""

OPENING_S = (1.0, 20.0)
"""Range from a strip curtain that is lifted to a hall gate."""

CLOSES_AFTER_S = (0.0, 10.0)


def with_doors(file: PlantFile, random: Random) -> PlantFile:
    """The same plant with one door or more, where there is a lane on which one can stand.

    Args:
        file: without doors.
        random: the only source of chance.
    """
    count = random.randint(1, MOST)
    lanes = list(file.lanes)
    random.shuffle(lanes)
    for lane in lanes:
        if len(file.doors) == count:
            break
        added = replace(file, doors=(*file.doors, _door(len(file.doors) + 1, lane, random)))
        if not any(door_faults(added)):
            file = added
    return file


def _door(number: int, lane: Lane, random: Random) -> Door:
    opening_s, closes_after_s = (
        round(random.uniform(*range_s), 1) for range_s in (OPENING_S, CLOSES_AFTER_S)
    )
    return Door(f"D{number}", f"Door {number}", (LaneEnds(lane.start, lane.end),), opening_s, closes_after_s)
