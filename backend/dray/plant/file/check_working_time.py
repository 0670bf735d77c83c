"""Faults of a plant's working times."""

from __future__ import annotations

from collections.abc import Iterator
from datetime import date
from zoneinfo import ZoneInfo

from msgspec.structs import replace

from dray.plant.file.reasons import Reason
from dray.plant.model import PlantFile
from dray.plant.working_time import WEEK_S, WorkingHours, WorkingTime


def working_time_faults(file: PlantFile) -> Iterator[tuple[str, str]]:
    """The faults as (field, reason); none where all fit."""
    try:
        ZoneInfo(file.time_zone)
    except (OSError, ValueError, KeyError):
        yield "time_zone", Reason("time_zone", zone=file.time_zone)
    told = [(f"machines[{at}].working_time", each.working_time) for at, each in enumerate(file.machines)]
    there = [(f"areas[{at}].working_time", each.working_time) for at, each in enumerate(file.areas)]
    for field, hours in (("working_time", file.working_time), *told, *there):
        if hours is not None:
            yield from _hours_faults(field, hours)


def _hours_faults(field: str, hours: WorkingHours) -> Iterator[tuple[str, str]]:
    for at, holiday in enumerate(hours.holidays):
        try:
            date.fromisoformat(holiday)
        except ValueError:
            yield f"{field}.holidays[{at}]", Reason("no_day", day=holiday)
    if not WorkingTime(replace(hours, holidays=())).between_s(WEEK_S, 2 * WEEK_S):
        yield f"{field}.breaks", Reason("breaks")
