"""Scenarios without right of way: other runs, in which the paper's claims about one vehicle hold, too."""

from __future__ import annotations

import pytest
from variants import variants

from dray_sim.run.site import Site
from dray_sim.scenarios import SCENARIOS

GHOSTS = Site(traffic=False)


@pytest.mark.parametrize("name", variants(["experiment-wlan", "experiment-power-off", "case-4", "case-5"]))
def test_a_claim_about_one_vehicle_holds_where_vehicles_pass_through_one_another(name: str) -> None:
    assert SCENARIOS[name].run(1, GHOSTS).failure == ""


@pytest.mark.slow
def test_a_scenario_is_another_run_without_right_of_way_and_the_same_one_again_with_it() -> None:
    scenario = SCENARIOS["experiment-power-off"]
    beside, alone, again = scenario.run(1), scenario.run(1, GHOSTS), scenario.run(1)
    assert beside.trace == again.trace != alone.trace
    assert "pass through one another" in alone.story


@pytest.mark.slow
def test_a_day_is_played_with_right_of_way() -> None:
    day = SCENARIOS["day"]
    alone, beside = day.run(1, Site(hours=0.25, traffic=False)), day.run(1, Site(hours=0.25))
    assert alone.describe() != beside.describe()
    assert "invariants" in beside.describe()
    assert beside.failure == ""
