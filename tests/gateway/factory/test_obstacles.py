"""What vehicles have met on lanes: shown until it is gone or forgotten, and cleared by a person's word."""

from __future__ import annotations

import pytest
from answers import problem
from fake_bus import KEYS
from gateway_kit import House

from dray.gateway.live.projection.obstacles import Obstacles
from dray.messages import Message, ObstacleCleared, ObstacleSeen
from dray.messages.floor.obstacle import MOST, MOST_OF_ONE

pytestmark = pytest.mark.anyio

LANE = {"start": "c3", "end": "m5-lane"}


def seen(
    start: str = "c3", end: str = "m5-lane", *, there: bool = True, for_s: float = 60.0, by: str = "ATV5"
) -> ObstacleSeen:
    return ObstacleSeen(atv=by, start=start, end=end, there=there, forget_in_s=for_s if there else 0.0)


async def test_what_a_vehicle_has_met_is_listed_and_a_person_clears_it(house: House) -> None:
    heard: list[Message] = []
    house.bus.join("ATV1", lambda _sender, message: heard.append(message)).subscribe(KEYS.all_obstacles)
    house.bus.join("ATV5", lambda *_: None).publish(KEYS.obstacle("ATV5"), seen())
    projection = house.projection
    assert [view.by for view in projection.obstacles.views()] == ["ATV5"]
    [listed] = (await house.get("/api/obstacles"))["items"]
    assert (listed["id"], listed["by"]) == ("c3>m5-lane", "ATV5")
    answer = await house.client.post("/api/obstacles/cleared", json={"start": "m5-lane", "end": "c3"})
    assert answer.status_code == 200
    assert [type(message) for message in heard] == [ObstacleSeen, ObstacleCleared]
    assert (await house.get("/api/obstacles"))["items"] == []
    again = await house.client.post("/api/obstacles/cleared", json=LANE)
    problem(again, 404, "unknown-obstacle")


async def test_what_is_old_is_forgotten_and_what_is_gone_leaves() -> None:
    obstacles = Obstacles(speed=10.0)
    obstacles.look(1000.0)
    assert obstacles.fold(seen(for_s=60.0))
    assert obstacles.fold(seen("a", "b"))
    assert obstacles.fold(seen("b", "a", there=False))
    assert not obstacles.fold(seen("b", "a", there=False))
    assert [view.until_at_s for view in obstacles.views()] == [1006.0]
    obstacles.look(1006.0)
    assert obstacles.views() == ()


def test_no_speaker_fills_the_floor_and_no_more_are_shown_than_vehicles_count_on() -> None:
    obstacles = Obstacles(speed=10.0)
    for number in range(2 * MOST):
        obstacles.fold(seen(f"n{number}", f"o{number}", by="ATV1"))
    assert len(obstacles.views()) == MOST_OF_ONE
    for number in range(2 * MOST):
        obstacles.fold(seen(f"p{number}", f"o{number}", by=f"ATV{number}"))
    assert len(obstacles.views()) == MOST
