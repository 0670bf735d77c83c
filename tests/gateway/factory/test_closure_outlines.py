"""Closing a part of the floor of any shape, by its corners."""

from __future__ import annotations

from typing import Any

import pytest
from answers import problem
from fake_bus import KEYS
from gateway_kit import AUTHORITY, House

from dray.adapters.security.signing import TrustedKeys
from dray.messages import Closures, Message, closed_words
from dray.plant import load_plant
from dray.protocol.closures.closure_rules import restrictions_of

pytestmark = pytest.mark.anyio

PLANT = load_plant("single-track")

WHY = {"reason": "a shelf has fallen over"}


def corners(*at_m: tuple[float, float]) -> list[dict[str, float]]:
    return [{"x_m": x_m, "y_m": y_m} for x_m, y_m in at_m]


async def test_a_part_of_the_floor_that_somebody_has_drawn_is_closed(house: House) -> None:
    heard: list[Closures] = []

    def receive(_sender: str, message: Message) -> None:
        if isinstance(message, Closures):
            heard.append(message)

    house.bus.join("ATV1", receive).subscribe(KEYS.closures)
    dock = PLANT.nodes["m5"]
    around = corners(
        (dock.x_m - 0.5, dock.y_m - 0.5), (dock.x_m + 0.5, dock.y_m - 0.5), (dock.x_m + 0.004, dock.y_m + 0.5)
    )
    body = WHY | {"outline": around}
    preview = await house.client.post("/api/closures/preview", json=body)
    assert preview.json() == {"cut_off": ["M5"], "shut_in": []}
    answer = await house.client.post("/api/closures", json=body)
    assert answer.status_code == 201, answer.text
    told = answer.json()
    assert told["cut_off"] == ["M5"]
    assert [corner["x_m"] for corner in told["outline"]] == pytest.approx(
        [dock.x_m - 0.5, dock.x_m + 0.5, dock.x_m]
    )
    assert {(lane["start"], lane["end"]) for lane in told["lanes"]} == {("m5-lane", "m5")}
    [closure] = heard[0].closures
    assert restrictions_of(PLANT, [closure]).nodes == {"m5"}
    assert TrustedKeys(AUTHORITY.public)(
        closed_words(heard[0].number, heard[0].closures), heard[0].signature
    ), "the outline is signed"
    again = await house.client.post("/api/closures", json=body)
    assert (again.status_code, again.json()) == (200, told)
    other = await house.client.post("/api/closures", json=WHY | {"outline": [*around[1:], around[0]]})
    assert other.json()["id"] != told["id"]
    closed = (await house.audit(target=told["id"]))[-1]
    assert b"outline" in bytes(closed.detail)


@pytest.mark.parametrize(
    ("body", "field"),
    [
        ({"outline": corners((1, 1), (9, 1))}, "outline"),
        ({"outline": corners(*((1.0 + n, 1.0 + n * n) for n in range(13)))}, "outline"),
        ({"outline": corners((1, 1), (999, 1), (1, 9))}, "outline[1]"),
        ({"outline": corners((1, 1), (9, 9), (9, 1), (1, 9))}, "outline"),
        ({"outline": corners((1, 1), (5, 1), (9, 1))}, "outline"),
        ({"outline": corners((0, 0), (0.1, 0), (0, 0.1))}, "outline"),
        ({"outline": corners((1, 1), (9, 1), (1, 9)), "area": "AREA1"}, "lane"),
        ({"outline": corners((1, 1), (9, 1), (1, 9)), "kind": "one_way"}, "lane"),
    ],
)
async def test_what_is_no_part_of_the_floor_is_refused_with_the_field(
    quiet_house: House, body: dict[str, Any], field: str
) -> None:
    for path in ("/api/closures", "/api/closures/preview"):
        answer = await quiet_house.client.post(path, json=WHY | body)
        told = problem(answer, 422, answer.json()["type"].rpartition(":")[2])
        assert field in {error["field"] for error in told["errors"]}, told
