"""Named scenarios: what `dray sim run NAME` plays.

A scenario is a function of a seed that returns a report. Each lives in a module of its own, which
says what it shows.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from dray_sim.report import Report
from dray_sim.scenarios import day

SCENARIOS: Mapping[str, Callable[[int], Report]] = {
    "day": day.run_day,
}
"""By name, in the order in which they are listed."""
