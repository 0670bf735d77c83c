"""Schedules of faults that are drawn from a seed."""

from __future__ import annotations

import os
import subprocess
import sys
from collections import Counter
from random import Random

import pytest
from fault_world import PLANT

from dray_sim.faults import (
    CLOCKS,
    DOORS,
    DROPPED,
    LEAVING,
    OBSTACLES,
    WEIGHTS,
    Cast,
    Crashed,
    JournalLost,
    SentAway,
    WlanCut,
    random_schedule,
    random_waves,
    read_schedule,
    write_schedule,
)
from dray_sim.faults.chance import COORDINATOR_BACK_S, VEHICLE_BACK_S
from dray_sim.faults.kinds import KINDS
from dray_sim.plants.generator import generate_plant

CAST = Cast.of_plant(PLANT)


def test_a_random_schedule_is_in_order_about_the_plant_and_over_in_time() -> None:
    for seed in range(50):
        plant = generate_plant(seed, 1 + seed % 5, 1 + seed % 7)
        schedule = random_schedule(plant, Random(seed), 600.0, 3.0, from_s=60.0)
        assert read_schedule(write_schedule(schedule), Cast.of_plant(plant)) == schedule
        assert [timed.at_s for timed in schedule] == sorted(timed.at_s for timed in schedule)
        for timed in schedule:
            assert timed.until_s is not None
            assert 60.0 <= timed.at_s < timed.until_s <= 600.0


def test_waves_are_crashes_of_sets_in_any_order_that_end_before_anybody_is_missed() -> None:
    firsts: set[str] = set()
    at_once: set[str] = set()
    for seed in range(50):
        waves = random_waves(PLANT, Random(seed), 600.0, 1.0)
        assert read_schedule(write_schedule(waves), CAST) == waves
        assert [timed.at_s for timed in waves] == sorted(timed.at_s for timed in waves)
        for timed in waves:
            assert isinstance(timed.fault, Crashed)
            back_s = VEHICLE_BACK_S if timed.fault.agent in PLANT.fleet else COORDINATOR_BACK_S
            assert 0.0 < (timed.until_s or 0.0) - timed.at_s <= back_s + 0.01
            assert (timed.until_s or 0.0) <= 600.0
            if timed.at_s == waves[0].at_s:
                at_once.add(timed.fault.agent)
        firsts |= {timed.fault.agent for timed in waves[:1] if isinstance(timed.fault, Crashed)}
    assert len(firsts) > 10
    assert at_once >= firsts
    assert random_waves(PLANT, Random(3), 600.0, 1.0) == random_waves(PLANT, Random(3), 600.0, 1.0)


def test_random_schedules_have_all_kinds_as_often_as_they_weigh_and_overlap() -> None:
    schedule = [timed for seed in range(40) for timed in random_schedule(PLANT, Random(seed), 3600.0, 2.0)]
    counts = Counter(type(timed.fault) for timed in schedule)
    assert (
        set(counts)
        == {*KINDS} - {*LEAVING, *CLOCKS, *OBSTACLES, *DROPPED, *DOORS, JournalLost}
        == set(WEIGHTS)
    )
    total = sum(WEIGHTS.values())
    for kind, weight in WEIGHTS.items():
        assert counts[kind] / len(schedule) == pytest.approx(weight / total, abs=0.015)
    assert len(schedule) / 40 == pytest.approx(2.0 * 60.0, rel=0.05)
    ends = [(timed.until_s or 0.0) - timed.at_s for timed in schedule]
    assert sum(ends) / len(ends) > 30.0


def test_agents_that_leave_are_drawn_apart_some_for_probation() -> None:
    schedule = random_schedule(PLANT, Random(1), 3600.0, 2.0, weights=LEAVING)
    leaving = [timed.fault for timed in schedule]
    assert {type(fault) for fault in leaving} == {SentAway}
    assert len({fault.agent for fault in leaving if isinstance(fault, SentAway)}) > 10
    assert {fault.probation for fault in leaving if isinstance(fault, SentAway)} == {0, 1, 2, 3}


def test_intensity_and_weights_are_obeyed() -> None:
    assert random_schedule(PLANT, Random(1), 3600.0, 0.0) == ()
    assert random_schedule(PLANT, Random(1), 3600.0, weights={}) == ()
    only = random_schedule(PLANT, Random(1), 3600.0, weights={WlanCut: 1.0})
    assert {type(timed.fault) for timed in only} == {WlanCut}
    assert random_schedule(PLANT, Random(1), 1.0, 100.0) == ()
    assert len(random_schedule(PLANT, Random(1), 1e6, 1000.0)) == 500


def test_a_random_schedule_depends_on_its_seed_alone() -> None:
    script = (
        "from random import Random; from dray.plant import default_plant;"
        "from dray_sim.faults import random_schedule, write_schedule;"
        "print(write_schedule(random_schedule(default_plant(), Random(5), 1200.0, 3.0)).decode(), end='')"
    )
    told = {
        subprocess.run(
            [sys.executable, "-c", script],
            env={**os.environ, "PYTHONHASHSEED": hash_seed, "PYTHONPATH": os.pathsep.join(sys.path)},
            check=True,
            capture_output=True,
            text=True,
        ).stdout
        for hash_seed in ("1", "2")
    }
    here = random_schedule(PLANT, Random(5), 1200.0, 3.0)
    assert told == {write_schedule(here).decode()}
    assert here != random_schedule(PLANT, Random(6), 1200.0, 3.0)
