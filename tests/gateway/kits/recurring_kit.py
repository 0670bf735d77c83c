"""Recurring work: planned over REST, and looked at when a test says that time has come."""

from __future__ import annotations

from datetime import datetime
from typing import Any

from gateway_kit import House

from dray.gateway.http.provided import provided
from dray.gateway.schedules.scheduler import Scheduler

PATH, TRANSPORTS = "/api/schedules", "/api/transports"
BRING = {"from": "S3", "to": "M8", "item": "shaft", "quantity": 40}
DRAFT = {"name": "Shafts", "calendar": "0 6 * * *", "time_zone": "Europe/Berlin", "transport": BRING}
SIX_S = datetime.fromisoformat("2030-03-18T06:00:00+01:00").timestamp()
"""The first moment of `DRAFT` after `NOW_S`, which is the evening before."""
DAY_S = 86_400.0


async def added(house: House, **fields: Any) -> dict[str, Any]:
    """A new schedule; one that has an order brings nothing."""
    body = {name: value for name, value in (DRAFT | fields).items() if value is not None}
    response = await house.client.post(PATH, json=body)
    assert response.status_code == 201, response.text
    answer: dict[str, Any] = response.json()
    return answer


async def look(house: House, wall_s: float) -> None:
    """Let time pass, and the scheduler look."""
    house.wall.now_s = wall_s
    await provided(house.app, Scheduler).look()


async def brought(house: House) -> list[dict[str, Any]]:
    """The transports that there are."""
    items: list[dict[str, Any]] = (await house.get(TRANSPORTS))["items"]
    return items


async def change(house: House, schedule: dict[str, Any], **fields: Any) -> dict[str, Any]:
    """Change a schedule that was read."""
    response = await house.client.patch(
        f"{PATH}/{schedule['id']}", json=fields, headers={"If-Match": schedule["etag"]}
    )
    assert response.status_code == 200, response.text
    answer: dict[str, Any] = response.json()
    return answer
