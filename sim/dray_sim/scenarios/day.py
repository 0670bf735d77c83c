"""A working day: an eight-hour shift of seeded demand in the default plant, with no faults."""

from __future__ import annotations

from dray.plant import default_plant
from dray_sim.report import Report
from dray_sim.stage import Shift, play

SHIFT = Shift(name="day", duration_s=8 * 3600.0, load=0.85)
"""Of the machines' time: a good day, with a little room for whatever comes between."""


class Day:
    """Figures, and no claim: what the others are compared with."""

    name = SHIFT.name
    shows = "An eight-hour shift of seeded demand in the default plant, with no faults."
    source = ""

    def run(self, seed: int) -> Report:
        """Play the day of this seed."""
        return play(SHIFT, default_plant(), seed).report


DAY = Day()
