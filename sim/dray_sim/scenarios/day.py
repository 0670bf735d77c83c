"""A working day: an eight-hour shift of seeded demand in the default plant, with no faults."""

from __future__ import annotations

from dray_sim.run.report import Report
from dray_sim.run.scenario import HERE
from dray_sim.run.site import Site
from dray_sim.run.stage import Shift, play, with_right_of_way, with_strategists

SHIFT = Shift(name="day", duration_s=8 * 3600.0, load=0.85)
"""Load as a fraction of the machines' time: a good day, with a little room for disturbances."""


class Day:
    """Figures without a claim, with which the other scenarios are compared."""

    name = SHIFT.name
    shows = "An eight-hour shift of seeded demand in the default plant, with no faults."
    source = ""

    moves = True

    def run(self, seed: int, site: Site = HERE) -> Report:
        """Play the day of this seed."""
        with with_right_of_way(site.traffic), with_strategists(site.strategists):
            return play(site.shift(SHIFT), site.ground, seed).report


DAY = Day()
