"""A floor whose agents are elsewhere says when two vehicles are in one spot, and puts none down where another one stands."""

from __future__ import annotations

import asyncio
import logging
from pathlib import Path

import pytest
from floor_house import ATV, PLANT, House, in_a_house
from msgspec.structs import replace

from dray.adapters.remote_body import put_down
from dray.adapters.telemetry.traffic_log import BEGUN, TrafficLog, read_traffic_log
from dray.body import Drive
from dray.errors import UnavailableError
from dray_sim.bodies.floor import Floor
from dray_sim.clock.loop import JUMP, clock, run
from dray_sim.remote import FloorMonitor

OTHER = [*PLANT.fleet][1]


def test_overlaps_and_lanes_are_told(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    async def main() -> int:
        floor = Floor(PLANT, clock(), seed=1)
        monitor = FloorMonitor(PLANT, floor.vehicles, clock(), TrafficLog(tmp_path, "floor"))
        first, second = floor.vehicles[ATV], floor.vehicles[OTHER]
        way = PLANT.routes(PLANT.fleet[ATV].type).way(first.sense().node, second.sense().node).nodes
        first.instruct(Drive(order=1, nodes=way, released=len(way)))
        while first.sense().node != way[-1]:
            await asyncio.sleep(10.0)
            monitor.look()
        return monitor.overlaps

    assert run(main(), JUMP) >= 1
    lines = read_traffic_log(tmp_path)
    assert lines[0].did == BEGUN
    assert {(line.agent, line.overlap) for line in lines if line.overlap} == {tuple(sorted((ATV, OTHER)))}
    assert [line.lane for line in lines if line.lane is not None and line.agent == ATV]
    assert {record.levelno for record in caplog.records} == {logging.ERROR}


def test_no_vehicle_is_put_down_where_another_one_is() -> None:
    node = PLANT.fleet[ATV].node
    free = next(stop for stop in PLANT.stops if stop not in {spec.node for spec in PLANT.fleet.values()})

    async def test(house: House) -> None:
        floor = house.floor
        house.refusal = FloorMonitor(PLANT, floor.vehicles, clock()).occupied
        joining = replace(PLANT.fleet[ATV], id="ATV99")
        with pytest.raises(UnavailableError, match=f"{ATV} is at {node}"):
            await put_down(house.here, PLANT.id, joining)
        assert "ATV99" not in floor.vehicles
        await put_down(house.here, PLANT.id, replace(joining, node=free))
        await put_down(house.here, PLANT.id, replace(joining, node=free))
        assert floor.vehicles["ATV99"].sense().node == free

    in_a_house(test)
