"""Recurring work leaves out the public holidays of a country or region."""

from __future__ import annotations

import csv
import io
from datetime import datetime

import msgspec
import pytest
from gateway_kit import House, gateway
from recurring_kit import DRAFT, PATH, added, brought, change, look
from wall_clock import Wall

from dray.gateway.http.provided import provided
from dray.gateway.schedules.scheduler import Scheduler
from dray.store import Store

pytestmark = [pytest.mark.anyio, pytest.mark.usefixtures("asked_by_the_test_alone")]


def at(text: str) -> float:
    return datetime.fromisoformat(text).timestamp()


EVE_S, CHRISTMAS_S, NEXT_S = (at(f"2030-12-{day}T06:00:00+01:00") for day in (24, 25, 27))
"""The last moment of `DRAFT` before Christmas, one of Christmas Day, and the first after Christmas in Germany."""


async def test_no_run_falls_on_a_public_holiday_though_the_gateway_starts_anew(url: str) -> None:
    wall = Wall(EVE_S - 1)
    async with gateway(url, wall=wall) as house:
        schedule = await added(house, holidays_of="DE")
        assert schedule["holidays_of"] == "DE"
        assert schedule["next_runs"] == [f"2030-12-{day}T06:00:00+01:00" for day in (24, 27, 28)]
        await look(house, EVE_S)
        assert len(await brought(house)) == 1
    async with gateway(url, wall=wall, incarnation=2) as house:
        assert (await house.get(f"{PATH}/{schedule['id']}"))["holidays_of"] == "DE"
        await look(house, CHRISTMAS_S)
        assert len(await brought(house)) == 1
        await look(house, NEXT_S)
        assert len(await brought(house)) == 2


async def test_a_region_is_set_kept_and_removed_by_changes(house: House) -> None:
    house.wall.now_s = EVE_S
    plain = await added(house, calendar="0 6 6 1 *")
    assert (plain["holidays_of"], plain["next_runs"][0][:10]) == ("", "2031-01-06")
    never = await house.client.patch(
        f"{PATH}/{plain['id']}", json={"holidays_of": "DE-BW"}, headers={"If-Match": "*"}
    )
    assert [each["code"] for each in never.json()["errors"]] == ["never"]
    changed = await change(house, plain, calendar="0 6 6,7 1 *", holidays_of="DE-BW")
    assert changed["next_runs"][0][:10] == "2031-01-07"
    named = await change(house, changed, name="Others")
    assert (named["holidays_of"], named["next_runs"]) == ("DE-BW", changed["next_runs"])
    removed = await change(house, named, holidays_of="")
    assert (removed["holidays_of"], removed["next_runs"][0][:10]) == ("", "2031-01-06")


async def test_a_preview_leaves_public_holidays_out(house: House) -> None:
    house.wall.now_s = EVE_S
    asked = {name: DRAFT[name] for name in ("calendar", "time_zone")} | {"holidays_of": "DE", "count": 1}
    runs = await house.client.post(f"{PATH}/preview", json=asked)
    assert runs.json() == {"runs": ["2030-12-27T06:00:00+01:00"]}
    wrong = await house.client.post(f"{PATH}/preview", json=asked | {"holidays_of": "DE-XX"})
    assert [each["field"] for each in wrong.json()["errors"]] == ["holidays_of"]


@pytest.mark.parametrize(
    ("region", "code"), [("XX", "country_unknown"), ("DE-XX", "region_unknown"), ("DE\n", "pattern")]
)
async def test_an_unknown_region_is_refused_at_its_field(house: House, region: str, code: str) -> None:
    schedule = await added(house)
    path, version = f"{PATH}/{schedule['id']}", {"If-Match": schedule["etag"]}
    fields = {"holidays_of": region}
    for answer in (
        await house.client.post(PATH, json=DRAFT | {"name": "Others"} | fields),
        await house.client.patch(path, json=fields, headers=version),
    ):
        assert answer.status_code == 422
        assert [(each["field"], each["code"]) for each in answer.json()["errors"]] == [("holidays_of", code)]
    assert [each["id"] for each in (await house.get(PATH))["items"]] == [schedule["id"]]
    assert await house.get(path) == schedule


async def test_the_table_has_the_region(house: House) -> None:
    await added(house, holidays_of="DE-BW")
    answer = await house.client.get(PATH, params={"format": "csv"})
    assert [row["holidays_of"] for row in csv.DictReader(io.StringIO(answer.text))] == ["DE-BW"]


@pytest.mark.parametrize("planned_s", [CHRISTMAS_S, NEXT_S + 86_400])
async def test_at_its_start_a_gateway_plans_by_the_holidays_that_it_knows(
    house: House, planned_s: float
) -> None:
    house.wall.now_s = EVE_S
    schedule = await added(house, holidays_of="DE")
    store = provided(house.app, Store)
    async with store.write() as work:
        row = await work.schedules.get(schedule["id"])
        assert row is not None
        # Another release of the library had other holidays.
        assert await work.schedules.change(row, msgspec.structs.replace(row, next_at_s=planned_s))
    await provided(house.app, Scheduler).renew()
    assert (await house.get(f"{PATH}/{schedule['id']}"))["next_runs"] == schedule["next_runs"]
