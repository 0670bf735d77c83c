"""When silence becomes failure."""

from __future__ import annotations

import pytest
from msgspec.structs import replace
from spoken import mhb, rhb

from dray.messages import AtvStatus, OutOfService
from dray.protocol.liveness.suspicion import (
    IDLE_INTERVAL_S,
    JITTER_S,
    MISSES,
    WORKING_INTERVAL_S,
    bound_s,
    interval_s,
)


def test_a_vehicle_with_a_task_is_expected_every_second() -> None:
    assert interval_s(rhb("ATV1", 1, 0.0, task="T1")) == WORKING_INTERVAL_S == 1.0


def test_a_vehicle_without_a_task_is_expected_every_five_seconds() -> None:
    assert interval_s(rhb("ATV1", 1, 0.0)) == IDLE_INTERVAL_S == 5.0


def test_whoever_has_a_problem_is_expected_every_second_while_somebody_is_called_for_it() -> None:
    beat = replace(rhb("ATV1", 1, 0.0), status=AtvStatus.ERROR, problem="it stands")
    assert interval_s(beat) == interval_s(replace(mhb("M1"), problem="no oil")) == WORKING_INTERVAL_S
    assert interval_s(replace(beat, out_of_service=OutOfService("worn", 0.0))) == IDLE_INTERVAL_S


@pytest.mark.parametrize("interval_s", [WORKING_INTERVAL_S, IDLE_INTERVAL_S])
def test_two_lost_heartbeats_and_a_late_third_one_raise_no_suspicion(interval_s: float) -> None:
    third_s = 3 * interval_s + JITTER_S
    assert third_s <= bound_s(interval_s)


@pytest.mark.parametrize("interval_s", [WORKING_INTERVAL_S, IDLE_INTERVAL_S])
def test_three_lost_heartbeats_do(interval_s: float) -> None:
    assert (MISSES + 1) * interval_s > bound_s(interval_s)


def test_a_dead_primary_is_suspected_within_a_few_seconds() -> None:
    assert bound_s(WORKING_INTERVAL_S) == 3.5
