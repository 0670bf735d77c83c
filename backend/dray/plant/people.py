"""Presence of people on the floor, by the working time of the operators' areas; people on duty are there besides."""

from __future__ import annotations

from dray.plant.plant import Plant
from dray.plant.working_time import WorkingTime


def people_of(plant: Plant, area: str) -> WorkingTime:
    """Working time of the people of an operators' area; the plant's for an area without one, and for an unknown area."""
    spec = plant.areas.get(area)
    hours = None if spec is None else spec.working_time
    return plant.working_time if hours is None else WorkingTime(hours, plant.file.time_zone)


def people_from_s(plant: Plant, x_m: float, y_m: float, now_s: float) -> float:
    """First time from `now_s` on at which people are there for a place; infinite for never.

    A place outside of all areas belongs to all of them.
    """
    areas = plant.areas_at(x_m, y_m) or tuple(plant.areas)
    times = [people_of(plant, area) for area in areas] or [plant.working_time]
    return min(time.next_on_s(now_s) for time in times)
