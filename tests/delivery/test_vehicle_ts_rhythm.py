"""The vehicle in TypeScript says often enough that it is there: nobody takes it for silent, by the rule that all agents have."""

from __future__ import annotations

import json
import subprocess
import sys
from itertools import groupby, pairwise

import msgspec
import pytest
from vehicle_ts_kit import DELIVERY, PLANT_FILE, SOURCES, node

from dray.messages import AtvHeartbeat, Reason
from dray.protocol.liveness.failure_detector import FailureDetector
from dray.protocol.liveness.suspicion import IDLE_INTERVAL_S, JITTER_S, interval_s


@pytest.fixture(scope="module")
def heartbeats(tmp_path_factory: pytest.TempPathFactory) -> list[AtvHeartbeat]:
    """All that it says in half a minute each of rest, work, rest, a problem, and rest; it waits for no clock."""
    folder = tmp_path_factory.mktemp("rhythm")
    command = (sys.executable, "-m", "dray", "plant", "json", str(PLANT_FILE))
    plant = subprocess.run(command, stdout=subprocess.PIPE, check=True).stdout
    (folder / "plant.json").write_bytes(plant)
    script = (node(), DELIVERY / "vehicle_rhythm.ts", folder / "plant.json", folder, SOURCES)
    told = subprocess.run(tuple(map(str, script)), stdout=subprocess.PIPE, check=True, text=True).stdout
    said = map(json.loads, told.splitlines())
    return [msgspec.convert(each, AtvHeartbeat) for each in said]


def test_it_rests_works_and_has_a_problem(heartbeats: list[AtvHeartbeat]) -> None:
    doing = [(each.task is not None, bool(each.problem)) for each in heartbeats]
    assert [what for what, _ in groupby(doing)] == [
        (False, False),
        (True, False),
        (False, False),
        (False, True),
        (False, False),
    ]


def test_nobody_takes_it_for_silent(heartbeats: list[AtvHeartbeat]) -> None:
    detector = FailureDetector("A1", IDLE_INTERVAL_S, heartbeats[0].at_s)
    for heartbeat in heartbeats:
        assert detector.failure(heartbeat.at_s) is not Reason.SILENT, heartbeat
        assert detector.on_heartbeat(heartbeat, heartbeat.at_s)


def test_the_next_one_comes_when_the_last_one_says(heartbeats: list[AtvHeartbeat]) -> None:
    for before, after in pairwise(heartbeats):
        assert after.at_s - before.at_s <= interval_s(before) + JITTER_S, before
