"""When people are on the floor, by the working time of the operators' areas; whoever is on duty is there besides."""

from __future__ import annotations

from dray.plant.plant import Plant
from dray.plant.working_time import WorkingTime


def people_of(plant: Plant, area: str) -> WorkingTime:
    """When people are in an operators' area; in one that does not say it, or that the plant does not know, when the plant works."""
    spec = plant.areas.get(area)
    hours = None if spec is None else spec.working_time
    return plant.working_time if hours is None else WorkingTime(hours, plant.file.time_zone)


def people_from_s(plant: Plant, x_m: float, y_m: float, now_s: float) -> float:
    """From when on people are there for a place, not before `now_s`; infinite for never. What lies in no area is everybody's."""
    areas = plant.areas_at(x_m, y_m) or tuple(plant.areas)
    times = [people_of(plant, area) for area in areas] or [plant.working_time]
    return min(time.next_on_s(now_s) for time in times)
