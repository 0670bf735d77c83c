"""Retention settings, in wall days since an event happened or a thing ended."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field
from pydantic_settings import BaseSettings

Days = Annotated[float, Field(ge=1, le=3660)]


class Keeping(BaseSettings):
    """A part of `dray.settings.Settings`."""

    events_days: Days = 14.0
    """The agents' event log: as long as recordings (`replay_days`). Orders keep a copy of what their pages need."""

    events_most: Annotated[int, Field(ge=1000)] = 20_000_000
    """Maximum rows of that log: some 10 GB, so that no plant fills its disk. Reaching it raises a warning."""

    samples_days: Days = 3.0
    """Sampled heartbeats: some 50 MB of the default plant in real time."""

    figures_days: Annotated[float, Field(ge=35, le=3660)] = 400.0
    """Figures by the minute, some 140 MB, and pieces by the hour: enough to compare two years. Panels ask for 35 days."""

    tasks_days: Days = 400.0
    transports_days: Days = 400.0
    """Tasks that have ended, likewise."""

    alerts_days: Days = 400.0
    """Alerts that have ended, likewise."""

    audit_days: Days = 400.0
    """The audit log, likewise."""

    replay_days: Annotated[float, Field(ge=0, le=400)] = 14.0
    """Recordings of the panels' view and of everybody's actions, for replay; 0 keeps nothing. docs/operating.md gives their size."""
