"""An area is paused: closed, and all vehicles in it stopped; then those go on that the pause has stopped, and nobody else."""

from __future__ import annotations

from typing import Any

import httpx
import pytest
from answers import problem, vehicle
from gateway_kit import House
from heartbeats import atv_heartbeat

from dray.messages import AtvStatus, CommandKind, CommandRefusal, Pose, VehicleCommand
from dray.plant import default_plant

pytestmark = pytest.mark.anyio

PLANT = default_plant()
AREA = next(iter(PLANT.areas))


def place_in(area: str) -> Pose:
    node = next(node for node in PLANT.nodes.values() if area in PLANT.areas_near(node.x_m, node.y_m, 0.0))
    return Pose(x_m=node.x_m, y_m=node.y_m, heading_rad=0.0)


def place_outside(area: str) -> Pose:
    node = next(
        node for node in PLANT.nodes.values() if area not in PLANT.areas_near(node.x_m, node.y_m, 5.0)
    )
    return Pose(x_m=node.x_m, y_m=node.y_m, heading_rad=0.0)


class Floor:
    """Vehicles of paper that obey, and tell so in their heartbeats."""

    def __init__(self, house: House) -> None:
        self.house = house
        self.heard: dict[str, list[VehicleCommand]] = {}
        self.seq = 1

    def stands(self, atv: str, pose: Pose, *, refused: CommandRefusal | None = None) -> None:
        self.heard[atv] = vehicle(self.house, atv=atv, refusal=refused)
        self.is_seen(atv, pose, AtvStatus.IDLE)

    def is_seen(self, atv: str, pose: Pose, status: AtvStatus) -> None:
        self.seq += 1
        self.house.bus.say(atv_heartbeat(atv, seq=self.seq, pose=pose, status=status))

    def told(self, atv: str) -> list[CommandKind]:
        return [command.kind for command in self.heard[atv]]


async def pause(house: House, area: str = AREA, **body: Any) -> httpx.Response:
    return await house.client.post(f"/api/areas/{area}/pause", json={"reason": "a visitor fell"} | body)


async def go_on(house: House, area: str = AREA) -> dict[str, Any]:
    answer = await house.client.post(f"/api/areas/{area}/go-on")
    assert answer.status_code == 200, answer.text
    told: dict[str, Any] = answer.json()
    return told


async def test_whoever_is_in_it_stops_and_whoever_is_not_does_not(house: House) -> None:
    floor = Floor(house)
    floor.stands("ATV1", place_in(AREA))
    floor.stands("ATV2", place_outside(AREA))
    answer = (await pause(house)).json()
    assert [(each["atv"], each["done"]) for each in answer["vehicles"]] == [("ATV1", True)]
    assert (floor.told("ATV1"), floor.told("ATV2")) == ([CommandKind.STOP], [])
    [closure] = (await house.get("/api/closures"))["items"]
    assert (closure["area"], closure["kind"], closure["reason"]) == (AREA, "closed", "a visitor fell")
    assert answer["closures"] == [closure["id"]]


async def test_those_that_it_has_stopped_go_on_and_the_area_is_open(house: House) -> None:
    floor = Floor(house)
    floor.stands("ATV1", place_in(AREA))
    await pause(house)
    floor.is_seen("ATV1", place_outside(AREA), AtvStatus.STOPPED)
    answer = await go_on(house)
    assert [(each["atv"], each["done"]) for each in answer["vehicles"]] == [("ATV1", True)]
    assert floor.told("ATV1") == [CommandKind.STOP, CommandKind.ACKNOWLEDGE, CommandKind.RESUME]
    assert (await house.get("/api/closures"))["items"] == []
    assert (await go_on(house))["vehicles"] == []


async def test_whom_somebody_else_has_stopped_stays_stopped(house: House) -> None:
    floor = Floor(house)
    for atv in ("ATV1", "ATV2", "ATV3"):
        floor.stands(atv, place_in(AREA))
    await house.client.post("/api/atvs/ATV1/commands", json={"kind": "stop"})
    floor.is_seen("ATV1", place_in(AREA), AtvStatus.STOPPED)
    await pause(house)
    await house.client.post("/api/atvs/ATV2/commands", json={"kind": "stop"})
    for atv in ("ATV2", "ATV3"):
        floor.is_seen(atv, place_in(AREA), AtvStatus.STOPPED)
    answer = await go_on(house)
    assert [(each["atv"], each["done"]) for each in answer["vehicles"]] == [
        ("ATV1", False),
        ("ATV2", False),
        ("ATV3", True),
    ]
    assert "somebody else has stopped it" in answer["vehicles"][0]["text"]
    assert CommandKind.RESUME not in floor.told("ATV1") + floor.told("ATV2")


async def test_one_that_refuses_is_named_with_its_reason(house: House) -> None:
    floor = Floor(house)
    floor.stands("ATV1", place_in(AREA), refused=CommandRefusal.EXPIRED)
    floor.stands("ATV2", place_in(AREA))
    answer = (await pause(house)).json()
    assert [(each["atv"], each["done"]) for each in answer["vehicles"]] == [("ATV1", False), ("ATV2", True)]
    assert "expired" in answer["vehicles"][0]["text"]


async def test_it_is_in_the_audit_log_with_each_vehicle(house: House) -> None:
    floor = Floor(house)
    floor.stands("ATV1", place_in(AREA))
    await pause(house)
    [line] = [each for each in (await house.get("/api/audit"))["items"] if each["action"] == "area.pause"]
    assert (line["target"], line["detail"]) == (
        AREA,
        {"reason": "a visitor fell", "vehicles": {"ATV1": "stopped"}},
    )


async def test_what_cannot_be_is_said(house: House) -> None:
    problem(await pause(house, "nowhere"), 404, "unknown-area")
    for wrong in ({"reason": ""}, {"until": "2030-01-01T00:00:00Z"}):
        assert (await pause(house, **wrong)).status_code == 422
