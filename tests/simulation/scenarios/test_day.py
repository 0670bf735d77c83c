"""Whole shifts in virtual time: what a seed decides, and what must hold."""

from __future__ import annotations

import dataclasses
import os
import subprocess
import sys

import pytest
from variants import in_campaigns

from dray.plant import default_plant
from dray_sim.run.evidence import HELD
from dray_sim.run.report import Report, describe
from dray_sim.run.stage import Shift, play
from dray_sim.scenarios.day import SHIFT

HOUR = dataclasses.replace(SHIFT, duration_s=3600.0)

PRINT_AN_HOUR = """
import dataclasses
from dray.plant import default_plant
from dray_sim.run.report import describe
from dray_sim.scenarios.day import SHIFT
from dray_sim.run.stage import play
print(describe(play(dataclasses.replace(SHIFT, duration_s=3600.0), default_plant(), 7).report))
"""


def report_of(shift: Shift, seed: int) -> Report:
    return play(shift, default_plant(), seed).report


@pytest.fixture(scope="module")
def hour() -> Report:
    return report_of(HOUR, 7)


@pytest.mark.slow
def test_the_invariants_hold(hour: Report) -> None:
    assert hour.invariants == HELD


@pytest.mark.slow
def test_goods_are_made_and_delivered(hour: Report) -> None:
    assert hour.transports > 20
    assert hour.pieces_delivered > 200
    assert hour.orders_delivered >= 3


@pytest.mark.slow
def test_most_transports_are_watched(hour: Report) -> None:
    assert hour.watches_taken > 0.8 * hour.transports


# Here the seed of hashes is another one in every run, unless somebody has set it: so one more is enough.
@pytest.mark.parametrize("hash_seed", in_campaigns(["4711", "0", "1"], "4711"))
def test_the_same_seed_gives_the_same_report_in_another_process(hour: Report, hash_seed: str) -> None:
    environment = {**os.environ, "PYTHONHASHSEED": hash_seed}
    printed = subprocess.run(
        [sys.executable, "-c", PRINT_AN_HOUR], env=environment, capture_output=True, text=True, check=True
    )
    assert printed.stdout == describe(hour) + "\n"


@pytest.mark.slow
def test_another_seed_gives_another_trace(hour: Report) -> None:
    other = report_of(dataclasses.replace(HOUR, duration_s=600.0), 8)
    first = report_of(dataclasses.replace(HOUR, duration_s=600.0), 7)
    assert other.trace != first.trace


@pytest.mark.slow
def test_a_day_through_the_codec_leaves_the_same_trace(hour: Report) -> None:
    through_codec = report_of(dataclasses.replace(HOUR, codec=True), 7)
    assert through_codec.trace == hour.trace
    assert describe(through_codec) == describe(hour)


@pytest.mark.campaign
def test_at_least_95_percent_of_a_morning_is_on_time() -> None:
    report = report_of(dataclasses.replace(SHIFT, duration_s=3 * 3600.0), 1)
    assert report.invariants == HELD
    assert report.orders_due > 15
    assert report.on_time_frac >= 0.95
