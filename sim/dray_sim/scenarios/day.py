"""A working day: an eight-hour shift of seeded demand in the default plant, with no faults."""

from __future__ import annotations

from dray.plant import default_plant
from dray_sim.report import Report
from dray_sim.scenario import Shift, run_shift

DAY = Shift(name="day", duration_s=8 * 3600.0, load=0.85)
"""Of the machines' time: a good day, with a little room for whatever comes between."""


def run_day(seed: int) -> Report:
    """Play the day of this seed."""
    return run_shift(DAY, default_plant(), seed)
