"""Recurring work over REST: every moment of a calendar is used once, whoever is there and whenever somebody dies."""

from __future__ import annotations

import asyncio
import csv
import io
from datetime import datetime
from typing import Any
from zoneinfo import ZoneInfo

import pytest
from fake_bus import FakeBus
from gateway_kit import PRODUCT, House, gateway
from recurring_kit import BRING, DAY_S, DRAFT, PATH, SIX_S, added, brought, change, look
from wall_clock import NOW_S, Wall

from dray.errors import UnavailableError
from dray.gateway.http.provided import provided
from dray.gateway.http.responses import iso
from dray.gateway.orders.transports import PlainTransports
from dray.gateway.schedules.scheduler import PUNCTUAL_S, Scheduler
from dray.messages import TransportOrdered
from dray.store.orders.transports import Transports

pytestmark = [pytest.mark.anyio, pytest.mark.usefixtures("asked_by_the_test_alone")]

RUN = Scheduler.run


async def test_each_moment_is_one_transport(house: House) -> None:
    schedule = await added(house)
    assert schedule["next_runs"] == [f"2030-03-{day}T06:00:00+01:00" for day in (18, 19, 20)]
    await look(house, SIX_S - 1)
    assert await brought(house) == []
    await look(house, SIX_S)
    await look(house, SIX_S + 1)
    [one] = await brought(house)
    assert (one["from"], one["to"], one["quantity"], one["called_by"]) == ("S3", "M8", 40, "Shafts")
    [asked] = house.bus.sent_to("M8", TransportOrdered)
    assert asked.transport == one["id"]
    now = await house.get(f"{PATH}/{schedule['id']}")
    assert now["last"] == {
        "planned_at": "2030-03-18T05:00:00.000Z",
        "transport": one["id"],
        "order": None,
        "refused": None,
        "made_up_at": None,
    }
    assert now["next_runs"][0] == "2030-03-19T06:00:00+01:00"
    await look(house, SIX_S + DAY_S)
    assert len(await brought(house)) == 2
    lines = await house.audit(action="transport.call")
    assert [(line.who, line.who_kind) for line in lines] == [(schedule["id"], "schedule")] * 2
    assert lines[1].target == one["id"]


async def test_it_comes_by_itself(house: House) -> None:
    looking = asyncio.create_task(RUN(provided(house.app, Scheduler)))
    house.wall.now_s = SIX_S - 0.01
    await added(house)
    house.wall.now_s = SIX_S
    asked = await house.bus.next_to("M8", TransportOrdered)
    assert [each["id"] for each in await brought(house)] == [asked.transport]
    looking.cancel()


async def test_two_gateways_use_a_moment_once(url: str) -> None:
    wall = Wall()
    async with (
        gateway(url, wall=wall) as house,
        gateway(url, wall=wall, bus=FakeBus(), incarnation=2) as other,
    ):
        await added(house)
        wall.now_s = SIX_S
        await asyncio.gather(*(provided(each.app, Scheduler).look() for each in (house, other) * 5))
        assert len(await brought(house)) == 1


BEFORE_CLOCKS_ARE_SET = {
    "Europe/Berlin": ("2030-03-30", "2030-10-26"),
    "America/New_York": ("2030-03-09", "2030-11-02"),
    "Australia/Lord_Howe": ("2030-04-06", "2030-10-05"),
}


@pytest.mark.parametrize(
    ("zone", "eve"), [(zone, eve) for zone, eves in BEFORE_CLOCKS_ARE_SET.items() for eve in eves]
)
async def test_in_a_night_in_which_clocks_are_set_a_run_is_done_once_though_gateways_start_anew(
    url: str, zone: str, eve: str
) -> None:
    first = datetime.fromisoformat(f"{eve}T22:00:00").replace(tzinfo=ZoneInfo(zone)).timestamp()
    wall = Wall(first)
    async with gateway(url, wall=wall) as house:
        await added(house, calendar="30 2 * * *", time_zone=zone)
    for life, begin_s in enumerate(range(0, 2 * int(DAY_S), 3600), 2):
        if not 3 * 3600 <= begin_s % DAY_S <= 5 * 3600:
            continue  # Nothing is planned then.
        async with (
            gateway(url, wall=wall, incarnation=life) as house,
            gateway(url, wall=wall, bus=FakeBus(), incarnation=life + 1000) as other,
        ):
            for minute in range(0, 60, 10):
                wall.now_s = first + begin_s + minute * 60.0
                await asyncio.gather(*(provided(each.app, Scheduler).look() for each in (house, other)))
            runs = await brought(house)
    days = [datetime.fromisoformat(run["created_at"]).astimezone(ZoneInfo(zone)).date() for run in runs]
    assert len(days) == len(set(days)) == 2


async def test_a_death_before_the_end_of_the_transaction_leaves_the_moment_to_the_next_life(
    url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def died(*_: object) -> bool:
        raise UnavailableError("database", "it went away", "start it again")

    async with gateway(url) as house:
        schedule = await added(house)
        with monkeypatch.context() as dying:
            dying.setattr(Transports, "add", died)
            with pytest.raises(UnavailableError):
                await look(house, SIX_S)
            assert (await house.get(f"{PATH}/{schedule['id']}"))["last"] is None
    async with gateway(url, incarnation=2, wall=Wall(SIX_S + 60)) as house:
        await look(house, SIX_S + 60)
        assert len(await brought(house)) == 1


async def test_a_death_after_it_is_made_good_by_the_next_life(
    url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with gateway(url) as house:
        await added(house)
        with monkeypatch.context() as dying:
            dying.setattr(PlainTransports, "ask", lambda *_: None)
            await look(house, SIX_S)
        assert house.bus.sent_to("M8", TransportOrdered) == []
    async with gateway(url, incarnation=2, wall=Wall(SIX_S + 60)) as house:
        [one] = await brought(house)
        assert [asked.transport for asked in house.bus.sent_to("M8", TransportOrdered)] == [one["id"]]
        await look(house, SIX_S + 60)
        assert len(await brought(house)) == 1


async def test_a_clock_that_is_set_back_places_nothing_again(house: House) -> None:
    schedule = await added(house)
    await look(house, SIX_S)
    house.wall.now_s = NOW_S
    schedule = await house.get(f"{PATH}/{schedule['id']}")
    schedule = await change(house, schedule, paused=True)
    schedule = await change(house, schedule, paused=False)
    assert schedule["next_runs"][0] == "2030-03-18T06:00:00+01:00"
    await look(house, SIX_S)
    [one] = await brought(house)
    now = await house.get(f"{PATH}/{schedule['id']}")
    assert (now["last"]["transport"], now["next_runs"][0]) == (one["id"], "2030-03-19T06:00:00+01:00")


@pytest.mark.parametrize(
    ("missed", "late_s", "made", "left_out"),
    [
        ("skip", 2 * DAY_S + PUNCTUAL_S + 1, 0, "2030-03-20T05:00:00.000Z"),
        ("skip", 2 * DAY_S + PUNCTUAL_S, 1, "2030-03-19T05:00:00.000Z"),
        ("catch_up", 2 * DAY_S + 3 * 3600, 1, "2030-03-19T05:00:00.000Z"),
        ("catch_up", PUNCTUAL_S + 1, 1, None),
    ],
)
async def test_after_an_absence_at_most_the_last_moment_is_made_up_for(
    house: House, missed: str, late_s: float, made: int, left_out: str | None
) -> None:
    schedule = await added(house, missed=missed)
    await look(house, SIX_S + late_s)
    await look(house, SIX_S + late_s)
    assert len(await brought(house)) == made
    now = await house.get(f"{PATH}/{schedule['id']}")
    assert now["missed_at"] == left_out
    in_time = made == 0 or late_s % DAY_S <= PUNCTUAL_S
    made_up_at = None if now["last"] is None else now["last"]["made_up_at"]
    assert made_up_at == (None if in_time else iso(SIX_S + late_s))
    # The next one is in time.
    await look(house, SIX_S + 3 * DAY_S)
    now = await house.get(f"{PATH}/{schedule['id']}")
    assert (now["last"]["planned_at"], now["last"]["made_up_at"]) == (iso(SIX_S + 3 * DAY_S), None)
    assert datetime.fromisoformat(now["next_runs"][0]).timestamp() > house.wall.now_s


async def test_what_passes_in_a_pause_is_not_made_up_for(house: House) -> None:
    schedule = await change(house, await added(house, missed="catch_up"), paused=True)
    assert schedule["next_runs"] == []
    await look(house, SIX_S + 60)
    schedule = await change(house, schedule, paused=False)
    assert schedule["next_runs"][0] == "2030-03-19T06:00:00+01:00"
    await look(house, SIX_S + 120)
    assert await brought(house) == []


async def test_a_change_of_something_else_loses_no_moment_that_has_just_come(house: House) -> None:
    schedule = await added(house)
    house.wall.now_s = SIX_S + 1
    await change(house, schedule, name="Shafts, early")
    await look(house, SIX_S + 2)
    assert [each["called_by"] for each in await brought(house)] == ["Shafts, early"]


async def test_what_cannot_be_brought_any_more_is_told_and_the_calendar_goes_on(
    house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    schedule = await added(house)
    monkeypatch.setattr("dray.gateway.orders.transports.OPEN_MAX", 0)
    await look(house, SIX_S)
    now = await house.get(f"{PATH}/{schedule['id']}")
    assert now["last"]["transport"] is None
    assert "call some off" in now["last"]["refused"]
    assert now["next_runs"][0] == "2030-03-19T06:00:00+01:00"
    assert await brought(house) == []


async def test_who_has_not_read_it_cannot_change_it(house: House) -> None:
    schedule = await added(house)
    place = f"{PATH}/{schedule['id']}"
    read = (await house.client.get(place)).headers["ETag"]
    for method in ("PATCH", "DELETE"):
        body = {"json": {"paused": True}} if method == "PATCH" else {}
        assert (await house.client.request(method, place, **body)).status_code == 428
        old = {"If-Match": '"7-0-0"'}
        assert (await house.client.request(method, place, headers=old, **body)).status_code == 412
    # That a moment was used meanwhile is news, and no change by a person.
    await look(house, SIX_S)
    assert (await house.client.get(place, headers={"If-None-Match": read})).status_code == 200
    assert (await house.get(place))["etag"] == schedule["etag"]
    after = await change(house, schedule, missed="catch_up")
    assert (after["missed"], after["next_runs"][0]) == ("catch_up", "2030-03-19T06:00:00+01:00")
    assert (await house.client.delete(place, headers={"If-Match": after["etag"]})).status_code == 204
    assert (await house.client.get(place)).status_code == 404
    assert (await house.client.delete(place, headers={"If-Match": "*"})).status_code == 404
    lines = [(line.action, line.target) for line in await house.audit(result="done", who="admin")]
    assert [action for action, _ in lines] == ["schedule.remove", "schedule.change", "schedule.add"]
    assert {target for _, target in lines} == {schedule["id"]}


async def test_no_two_have_the_same_name(house: House) -> None:
    first = await added(house)
    again = await house.client.post(PATH, json=DRAFT)
    assert (again.status_code, again.json()["type"]) == (409, "urn:dray:problem:name-taken")
    other = await added(house, name="Others")
    renamed = await house.client.patch(
        f"{PATH}/{other['id']}", json={"name": first["name"]}, headers={"If-Match": "*"}
    )
    assert renamed.status_code == 409
    names = {each["name"] for each in (await house.get(PATH))["items"]}
    assert names == {"Shafts", "Others"}


@pytest.mark.parametrize(
    ("fields", "field"),
    [
        ({"calendar": "61 * * * *"}, "calendar"),
        ({"time_zone": "Mars/Olympus"}, "time_zone"),
        ({"holidays": ["2030-02-30"]}, "holidays[0]"),
        ({"holidays": [20300101]}, "holidays[0]"),
        ({"transport": BRING | {"item": "cheese"}}, "transport.item"),
        ({"transport": BRING | {"vehicle": "ATV99"}}, "transport.vehicle"),
        ({"transport": BRING | {"due_at": "2031-01-01T00:00:00Z"}}, "transport"),
        ({"missed": "all"}, "missed"),
        ({"name": " "}, "name"),
    ],
)
async def test_what_cannot_be_is_refused_by_its_field(
    house: House, fields: dict[str, Any], field: str
) -> None:
    response = await house.client.post(PATH, json=DRAFT | fields)
    assert response.status_code == 422
    assert [each["field"] for each in response.json()["errors"]] == [field]
    # Panels say it in the reader's language.
    assert ("holidays" in fields) == (response.json()["errors"][0].get("code") == "day_unreadable")
    assert (await house.get(PATH))["items"] == []
    schedule = await added(house)
    place, version = f"{PATH}/{schedule['id']}", {"If-Match": schedule["etag"]}
    changed = await house.client.patch(place, json=fields, headers=version)
    assert (changed.status_code, [each["field"] for each in changed.json()["errors"]]) == (422, [field])
    assert await house.get(place) == schedule


async def test_a_preview_keeps_nothing(house: House) -> None:
    asked = {"calendar": "30 2 * * *", "time_zone": "Europe/Berlin", "holidays": ["2030-03-30"], "count": 14}
    response = await house.client.post(f"{PATH}/preview", json=asked)
    runs = response.json()["runs"]
    assert (response.status_code, len(runs)) == (200, 14)
    assert runs[11:] == [
        "2030-03-29T02:30:00+01:00",
        "2030-03-31T03:00:00+02:00",
        "2030-04-01T02:30:00+02:00",
    ]
    assert (await house.get(PATH))["items"] == []
    wrong = await house.client.post(f"{PATH}/preview", json=asked | {"calendar": "now"})
    assert [each["field"] for each in wrong.json()["errors"]] == ["calendar"]


async def test_all_of_it_is_a_table_with_a_row_for_each_item(house: House) -> None:
    order = {
        "customer": "=Hall 3",
        "items": [{"product": "pump-p3", "quantity": 20}, {"product": PRODUCT, "quantity": 2}],
        "due_after_s": 3600.0,
    }
    shafts = await added(house, holidays=["2030-12-25", "2030-12-26"])
    await added(house, name="Pumps", calendar="0 7 * * *", transport=None, order=order)
    await look(house, SIX_S)
    answer = await house.client.get(PATH, params={"format": "csv"})
    assert answer.headers["content-type"].startswith("text/csv")
    rows = sorted(csv.DictReader(io.StringIO(answer.text)), key=lambda row: row["item"])
    by_item = {row["item"]: row for row in rows}
    assert list(by_item) == sorted([PRODUCT, "pump-p3", "shaft"])
    shaft, pump = by_item["shaft"], by_item["pump-p3"]
    [brought_now] = await brought(house)
    assert (shaft["name"], shaft["kind"], shaft["from"], shaft["to"]) == ("Shafts", "transport", "S3", "M8")
    assert (shaft["holidays"], shaft["last"]) == ("2030-12-25 2030-12-26", brought_now["id"])
    assert shaft["next_run"] == shafts["next_runs"][1]
    assert (pump["kind"], pump["quantity"], pump["due_after_s"]) == ("order", "20", "3600.0")
    # No program takes it for a formula.
    assert pump["customer"] == "'=Hall 3"
    assert pump["last"] == ""
