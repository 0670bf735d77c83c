"""Named scenarios: what `dray sim run NAME` plays.

Each lives in a module of its own, which says what it shows: the paper's six cases and two experiments,
and what we want to know beside them.
"""

from __future__ import annotations

from collections.abc import Mapping

from dray_sim.scenario import Playable
from dray_sim.scenarios import (
    case_4,
    day,
    experiment_power_off,
    experiment_wlan,
    latency_sweep,
    peak_season,
    soak,
    takeover,
)

_ALL: tuple[Playable, ...] = (
    day.DAY,
    case_4.CASE_4,
    experiment_wlan.EXPERIMENT_WLAN,
    experiment_power_off.EXPERIMENT_POWER_OFF,
    latency_sweep.LATENCY_SWEEP,
    peak_season.PEAK_SEASON,
    soak.SOAK,
    takeover.TAKEOVER,
)

SCENARIOS: Mapping[str, Playable] = {scenario.name: scenario for scenario in _ALL}
"""By name, in the order in which they are listed."""
