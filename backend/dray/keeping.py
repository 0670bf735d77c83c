"""Settings of how long what is kept, in wall days since it happened or ended."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field
from pydantic_settings import BaseSettings

Days = Annotated[float, Field(ge=1, le=3660)]


class Keeping(BaseSettings):
    """A part of `dray.settings.Settings`."""

    events_days: Days = 14.0
    """The log of what agents told: as long as what panels showed (`replay_days`). Orders keep what their pages need of it."""

    events_most: Annotated[int, Field(ge=1000)] = 20_000_000
    """Rows of that log, of whatever age: some 10 GB, so that no plant fills its disk. It is told when this is reached."""

    samples_days: Days = 3.0
    """Sampled heartbeats: some 50 MB of the default plant in real time."""

    figures_days: Annotated[float, Field(ge=35, le=3660)] = 400.0
    """Figures by the minute, some 140 MB, and pieces by the hour: a year can be compared with the one before. Panels ask for 35 days."""

    tasks_days: Days = 400.0
    transports_days: Days = 400.0
    """Tasks that have ended, likewise."""

    alerts_days: Days = 400.0
    """Alerts that have ended, likewise."""

    audit_days: Days = 400.0
    """The audit log, likewise."""

    replay_days: Annotated[float, Field(ge=0, le=400)] = 14.0
    """What panels showed, to show it again, and what everybody did; 0 keeps nothing. docs/operating.md says what it takes."""
