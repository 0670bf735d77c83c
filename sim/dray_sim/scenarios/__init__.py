"""Named scenarios: what `dray sim run NAME` plays.

Each lives in a module of its own, which says what it shows: the paper's six cases and two experiments,
and what we want to know beside them.
"""

from __future__ import annotations

from collections.abc import Mapping

from dray_sim.scenario import Playable
from dray_sim.scenarios import day, latency_sweep

_ALL: tuple[Playable, ...] = (
    day.DAY,
    latency_sweep.LATENCY_SWEEP,
)

SCENARIOS: Mapping[str, Playable] = {scenario.name: scenario for scenario in _ALL}
"""By name, in the order in which they are listed."""
