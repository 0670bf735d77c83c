"""Named scenarios, for `dray sim run NAME`.

Each is in a module of its own, which states its claim: the paper's six cases and two experiments, and further
questions of ours.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from dray_sim.run.part import Part
from dray_sim.run.scenario import Playable, Scenario
from dray_sim.scenarios import (
    day,
    fault_cost,
    insider,
    latency_sweep,
    levels,
    loss_sweep,
    obstacles,
    peak_season,
    priorities,
    problems,
    scale,
    soak,
    strategists,
    supply,
    takeover,
)
from dray_sim.scenarios.paper import (
    case_1,
    case_2,
    case_3,
    case_4,
    case_5,
    case_6,
    experiment_power_off,
    experiment_wlan,
)

_ALL: tuple[Playable, ...] = (
    day.DAY,
    case_1.CASE_1,
    case_2.CASE_2,
    case_3.CASE_3,
    case_4.CASE_4,
    case_5.CASE_5,
    case_6.CASE_6,
    experiment_wlan.EXPERIMENT_WLAN,
    experiment_power_off.EXPERIMENT_POWER_OFF,
    latency_sweep.LATENCY_SWEEP,
    loss_sweep.LOSS_SWEEP,
    peak_season.PEAK_SEASON,
    priorities.PRIORITIES,
    soak.SOAK,
    levels.LEVELS,
    strategists.STRATEGISTS,
    supply.SUPPLY,
    takeover.TAKEOVER,
    fault_cost.FAULT_COST,
    problems.PROBLEMS,
    obstacles.OBSTACLES,
    insider.INSIDER,
    scale.SCALE,
)

SCENARIOS: Mapping[str, Playable] = {scenario.name: scenario for scenario in _ALL}
"""Scenarios by name, in the order of their listing."""


@dataclass(frozen=True, slots=True)
class LivePart:
    """A part of a scenario that can be followed live.

    Attributes:
        part: to be played.
        shows: its scenario's description, in one line.
    """

    part: Part[Any]
    shows: str


LIVE: Mapping[str, LivePart] = {
    part.name: LivePart(part, scenario.shows)
    for scenario in _ALL
    if isinstance(scenario, Scenario)
    for part in scenario.parts
}
"""Parts by name, for `dray up --scenario NAME`."""
