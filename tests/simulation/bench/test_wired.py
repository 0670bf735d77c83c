"""Right of way between processes: who is killed loses no place, and what a person closes is obeyed."""

from __future__ import annotations

import asyncio
import json
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any
from urllib.request import Request, urlopen

import pytest

from dray.adapters.telemetry.traffic_log import read_traffic_log
from dray.protocol.traffic.places import Places
from dray_sim.bench.losses.fleet import Fleet, running
from dray_sim.bench.losses.watch import gathered
from dray_sim.bench.wired import JOIN_S, Campaign, play
from dray_sim.checks.floor.traffic_log_check import TrafficLogCheck
from dray_sim.plants.generator import generate_plant

PLANT = generate_plant(1, machines=3, vehicles=2)
"""Every machine keeps every reservation table."""

PATIENCE_S = 180.0


@pytest.mark.campaign
def test_no_place_is_held_twice_by_processes_that_are_killed(tmp_path: Path) -> None:
    campaign = Campaign(PLANT, killing_s=25.0, calm_s=20.0, pause_s=4.0, away_s=(2.0, 8.0))
    rows = asyncio.run(play(campaign, tmp_path))
    assert [row.name for row in rows if not row.met] == []
    assert min(row.baseline for row in rows) > 0, "nothing was said, granted, driven or killed"


class Manager:
    """A manager with the administrator's token, over REST."""

    def __init__(self, fleet: Fleet) -> None:
        self._url = f"{fleet.url}/api/closures"
        self._head = {"Authorization": f"Bearer {fleet.token}", "Content-Type": "application/json"}

    def _ask(self, body: bytes | None = None) -> Any:
        with urlopen(Request(self._url, body, self._head), timeout=PATIENCE_S) as answer:
            return json.load(answer)

    def close(self, place: str) -> None:
        self._ask(json.dumps({"kind": "closed", "place": place, "reason": "oil on the floor"}).encode())

    @property
    def not_known_by(self) -> list[str]:
        """Vehicles that do not go by some closure yet."""
        return [atv for item in self._ask()["items"] for atv in item["not_known_by"]]


@pytest.mark.campaign
def test_what_is_closed_at_the_gateway_is_entered_by_no_vehicle_in_a_process(tmp_path: Path) -> None:
    log, places = tmp_path / "traffic", Places(PLANT)
    kept_open = places.docks | set(places.dock_entries.values())

    def entered() -> list[tuple[float, str]]:
        """When, and the node at the end of the lane."""
        return [(line.at_s, line.lane[1]) for line in read_traffic_log(log) if line.lane is not None]

    async def until(done: Callable[[], bool]) -> None:
        async with asyncio.timeout(PATIENCE_S):
            while not await asyncio.to_thread(done):  # noqa: ASYNC110 - REST tells nobody
                await asyncio.sleep(0.5)

    async def story() -> tuple[str, float]:
        async with running(tmp_path, PLANT, speed=1.0, plain=False, demand=True, traffic_log=log) as fleet:
            with fleet.bus() as bus:
                await gathered(fleet, bus, JOIN_S)
            manager = Manager(fleet)
            await until(lambda: len([node for _, node in entered() if node not in kept_open]) >= 6)
            [(busiest, _)] = Counter(node for _, node in entered() if node not in kept_open).most_common(1)
            await asyncio.to_thread(manager.close, busiest)
            await until(lambda: not manager.not_known_by)
            known_s = time.monotonic()
            await until(lambda: len([at_s for at_s, _ in entered() if at_s > known_s]) >= 6)
            return busiest, known_s

    closed, known_s = asyncio.run(story())
    assert [at_s - known_s for at_s, node in entered() if node == closed and at_s > known_s] == []
    assert TrafficLogCheck(places).judge(read_traffic_log(log)).broken == []
