"""A rule of the protocol is told once: whoever else needs it imports it, is told it, or is held to it here."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dray.gateway.live.projection import Projection
from dray.gateway.live.timescale import TimeScale
from dray.messages import AtvHeartbeat, AtvStatus, Brief, MachineHeartbeat, MachineStatus, Pose, Role
from dray.messages.base import CLOCKS_AGREE_S
from dray.messages.heartbeat import GoalBrief
from dray.plant import default_plant
from dray.protocol.liveness.failure_detector import FailureDetector
from dray.protocol.liveness.suspicion import (
    GOAL_SILENCE_S,
    IDLE_INTERVAL_S,
    WORKING_INTERVAL_S,
    ArrivalStatistics,
    bound_s,
)
from dray.protocol.runtime.retransmission import ASK_AGAIN_S
from dray.protocol.vehicle import dwell_points, idle_positioning, pricing
from dray.protocol.vehicle.job import job_messages, job_moves, transport_job
from dray.store.history import gaps

ROOT = Path(__file__).parents[2]
PLANT = default_plant().file

ARRIVALS = st.lists(
    st.tuples(st.integers(0, 4), st.floats(0.0, 6.0), st.booleans()),
    min_size=1,
    max_size=60,
)
"""Of each heartbeat: how many before it were lost, how long it was under way (s), and whether its sender holds a task."""


def heartbeat(seq: int, at_s: float, *, works: bool) -> AtvHeartbeat:
    brief = Brief(task="T1", epoch=1, role=Role.PRIMARY, coordinator="M1")
    return AtvHeartbeat(
        atv="ATV1",
        incarnation=1,
        seq=seq,
        at_s=at_s,
        # Stopped by a person, it holds its task all the same.
        status=AtvStatus.STOPPED,
        pose=Pose(x_m=0.0, y_m=0.0, heading_rad=0.0),
        node="a1",
        speed_mps=0.0,
        battery_frac=0.9,
        task=brief if works else None,
    )


@given(ARRIVALS)
def test_a_vehicle_is_lost_in_the_panels_when_an_agent_that_hears_the_same_gives_it_up(
    arrivals: list[tuple[int, float, bool]],
) -> None:
    now_s = 100.0
    projection = Projection(PLANT, TimeScale(0.0, 0.0), wall_s=lambda: now_s)
    detector = FailureDetector("ATV1", IDLE_INTERVAL_S, now_s, ArrivalStatistics())
    seq = 0
    for missed, delay_s, works in arrivals:
        seq += 1 + missed
        now_s += 7.0
        beat = heartbeat(seq, now_s - delay_s, works=works)
        projection.fold(beat)
        detector.on_heartbeat(beat, now_s)
    view = projection.atvs.view("ATV1")
    assert view is not None
    assert view.silence.lost_after_s == pytest.approx(detector.bound_s, abs=0.051)
    assert view.silence.beat_s == (WORKING_INTERVAL_S if arrivals[-1][2] else IDLE_INTERVAL_S)


@pytest.mark.parametrize(("goals", "lost_after_s"), [(1, GOAL_SILENCE_S), (0, bound_s(IDLE_INTERVAL_S))])
def test_a_machine_is_lost_in_the_panels_when_the_strategist_gives_it_up(
    goals: int, lost_after_s: float
) -> None:
    projection = Projection(PLANT, TimeScale(0.0, 0.0))
    brief = GoalBrief(goal="G1", product="P1", quantity=5, made=0, delivered=0)
    projection.fold(
        MachineHeartbeat(
            machine="M1", incarnation=1, seq=1, at_s=0.0, status=MachineStatus.IDLE, goals=(brief,) * goals
        )
    )
    view = projection.machines.view("M1")
    assert view is not None
    assert view.silence.lost_after_s == pytest.approx(lost_after_s)


RULE = re.compile(
    r"const [A-Z_]*(BEAT|MISSES|SILEN|LOST|OVERDUE|PROMISE_MAX|ABOARD|BATTERY)[A-Z_]* = (new Set|[\d.])"
)
"""What a panel would have to keep in step with the agents."""


def test_panels_have_no_figures_of_the_protocol() -> None:
    sources = [each for each in (ROOT / "frontend/src").rglob("*.ts*") if ".test." not in each.name]
    assert len(sources) > 100
    copied = [f"{each.name}: {found[0]}" for each in sources for found in RULE.finditer(each.read_text())]
    assert copied == []


def test_the_search_for_figures_finds_them() -> None:
    for line in (
        "const WORKING_BEAT_S = 1;",
        "const BEATS = 3;",
        "const ABOARD = new Set([])",
        "const LOST_S = 3",
    ):
        assert RULE.search(line), line


def test_the_historian_thinks_of_an_agent_as_back_after_two_beats_of_an_idle_one() -> None:
    # The store stands beside the protocol and does not import it.
    assert gaps.SILENCE_S == 2 * IDLE_INTERVAL_S


IN_TYPESCRIPT: dict[str, dict[str, Any]] = {
    "vehicle.ts": {"WORKING_BEAT_S": WORKING_INTERVAL_S, "IDLE_BEAT_S": IDLE_INTERVAL_S},
    "transport-job.ts": {
        "ASK_AGAIN_S": ASK_AGAIN_S,
        "HELD_ASK_AGAIN_S": job_messages.HELD_ASK_AGAIN_S,
        "WAITS_AT_LEAST_S": transport_job.WAITS_AT_LEAST_S,
        "RETRY_S": job_moves.RETRY_S,
    },
    "rest.ts": {
        "SETTLE_S": idle_positioning.SETTLE_S,
        "SEEK_AGAIN_S": idle_positioning.SEEK_AGAIN_S,
        "CONTEST_S": dwell_points.CONTEST_S,
        "TAKEN_S": dwell_points.TAKEN_MEMORY_S,
    },
    "pricing.ts": {"LOW_BATTERY_S": pricing.LOW_BATTERY_S, "SPARE_ABILITY_S": pricing.SPARE_ABILITY_S},
}


@pytest.mark.parametrize("file", IN_TYPESCRIPT)
def test_the_example_in_typescript_goes_by_the_same_figures(file: str) -> None:
    text = (ROOT / "examples/vehicle-ts/src" / file).read_text()
    told = {name: float(value) for name, value in re.findall(r"const ([A-Z_]+) = ([\d.]+);", text)}
    assert {name: told[name] for name in IN_TYPESCRIPT[file]} == IN_TYPESCRIPT[file]


def test_the_documentation_for_other_agents_tells_the_same_figures() -> None:
    text = (ROOT / "docs/agents.md").read_text()
    assert f"{WORKING_INTERVAL_S:g} s with a task or a problem, {IDLE_INTERVAL_S:g} s without" in text
    assert f"Clocks must agree within {CLOCKS_AGREE_S:g} s" in text
    assert f"silent for {bound_s(WORKING_INTERVAL_S):g} s" in text
    assert f"`Docked` after `DockHeld` | {job_messages.HELD_ASK_AGAIN_S:g} s" in text
    assert f"it is yours after {dwell_points.CONTEST_S:g} s" in text
