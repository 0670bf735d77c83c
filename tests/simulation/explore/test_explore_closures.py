"""Closures drawn at random: nobody enters what it knows to be closed, and everything ends when all is open again."""

from __future__ import annotations

import pytest
from variants import variants

from dray.protocol.vehicle.idle_positioning import IdlePositioning
from dray.protocol.vehicle.job.transport_job import TransportJob
from dray_sim.explore.play import play, try_seed
from dray_sim.explore.run import FAULTS_UNTIL_S, draw

SEEDS = range(6)
WITHIN = 40


@pytest.mark.parametrize("profile", ["closures-alone", "closures"])
@pytest.mark.parametrize("seed", variants(SEEDS))
def test_runs_with_closures_hold(seed: int, profile: str) -> None:
    outcome = try_seed(seed, profile)
    assert outcome.broken == ""
    assert outcome.transports


def test_all_closures_of_a_run_have_ended_before_the_quiet_phase() -> None:
    drawn = [closing for seed in range(50) for closing in draw(seed, "closures").closings]
    assert len(drawn) > 100
    assert all(0.0 <= closing.at_s < closing.until_s <= FAULTS_UNTIL_S for closing in drawn)
    assert {closing.closure.kind.value for closing in drawn} == {"closed", "slow", "one_way"}


@pytest.mark.parametrize(("role", "first"), [(TransportJob, 34), (IdlePositioning, 4)])
def test_a_vehicle_that_goes_on_as_before_is_found(
    role: type, first: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(role, "floor_changed", lambda _self, _now_s: None)
    broken = (play(draw(seed, "closures-alone")).broken for seed in range(first, first + WITHIN))
    assert "invariant 15" in next(filter(None, broken), "")
