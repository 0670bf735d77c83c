"""Recurring work over REST: one moment of its calendar is left out, and no other."""

from __future__ import annotations

import pytest
from answers import problem
from gateway_kit import House
from recurring_kit import DAY_S, PATH, SIX_S, added, brought, change, look

pytestmark = [pytest.mark.anyio, pytest.mark.usefixtures("asked_by_the_test_alone")]


async def test_one_moment_is_left_out_and_the_others_come(house: House) -> None:
    schedule = await added(house)
    first, second, third = schedule["next_runs"]
    less = await change(house, schedule, skipped=[second])
    assert (less["skipped"], less["next_runs"][:2]) == ([second], [first, third])
    await look(house, SIX_S)
    assert len(await brought(house)) == 1
    await look(house, SIX_S + DAY_S)
    assert len(await brought(house)) == 1
    await look(house, SIX_S + 2 * DAY_S)
    assert len(await brought(house)) == 2
    now = await house.get(f"{PATH}/{schedule['id']}")
    # It was left out on purpose, and is past.
    assert (now["missed_at"], now["skipped"]) == (None, [])


async def test_the_next_moment_is_left_out_and_done_all_the_same(house: House) -> None:
    schedule = await added(house)
    first, second, third = schedule["next_runs"]
    less = await change(house, schedule, skipped=[second, first])
    assert (less["skipped"], less["next_runs"][0]) == ([first, second], third)
    again = await change(house, less, skipped=[second])
    assert (again["skipped"], again["next_runs"][:2]) == ([second], [first, third])
    await look(house, SIX_S)
    assert len(await brought(house)) == 1


async def test_a_moment_that_has_just_come_is_done_though_another_one_is_left_out(house: House) -> None:
    schedule = await added(house)
    house.wall.now_s = SIX_S + 1.0
    await change(house, schedule, skipped=[schedule["next_runs"][1]])
    await look(house, SIX_S + 2.0)
    assert len(await brought(house)) == 1


async def test_after_an_absence_what_was_left_out_is_not_made_up_for(house: House) -> None:
    schedule = await added(house, missed="catch_up")
    await change(house, schedule, skipped=schedule["next_runs"][1:2])
    await look(house, SIX_S + DAY_S + 3600.0)
    [one] = await brought(house)
    now = await house.get(f"{PATH}/{schedule['id']}")
    assert now["last"]["planned_at"] == "2030-03-18T05:00:00.000Z"
    assert now["last"]["transport"] == one["id"]


async def test_what_is_left_out_is_a_moment_of_the_calendar(house: House) -> None:
    schedule = await added(house)
    for wrong in ("2030-03-18T06:01:00+01:00", "2029-03-18T06:00:00+01:00", "2030-03-17T06:00:00+01:00"):
        answer = await house.client.patch(
            f"{PATH}/{schedule['id']}", json={"skipped": [wrong]}, headers={"If-Match": schedule["etag"]}
        )
        [fault] = problem(answer, 422, "unusable-fields")["errors"]
        assert (fault["field"], fault["code"]) == ("skipped[0]", "no_run")
        assert "2030-03-18T06:00:00+01:00" in fault["reason"]
    # Another calendar forgets what it does not have, and keeps what it has.
    kept = await change(house, schedule, skipped=schedule["next_runs"][:2])
    other = await change(house, kept, calendar="0 6 * * TUE")
    assert other["skipped"] == schedule["next_runs"][1:2]
    assert other["next_runs"][0] == "2030-03-26T06:00:00+01:00"


async def test_what_is_left_out_in_a_pause_stays_left_out(house: House) -> None:
    paused = await change(house, await added(house), paused=True)
    at = "2030-03-18T06:00:00+01:00"
    assert (await change(house, paused, skipped=[at]))["next_runs"] == []
    on = await change(house, await house.get(f"{PATH}/{paused['id']}"), paused=False)
    assert on["next_runs"][0] == "2030-03-19T06:00:00+01:00"
