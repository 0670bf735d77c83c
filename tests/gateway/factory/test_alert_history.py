"""Alerts: taken on until some moment and with a word, and kept from when to when."""

from __future__ import annotations

import csv
import io
from datetime import UTC, datetime
from typing import Any

import httpx
import pytest
from answers import problem
from gateway_kit import House, gateway
from heartbeats import machine_heartbeat
from wall_clock import NOW_S

from dray.errors import UnavailableError
from dray.gateway.access.principal import Scope
from dray.gateway.live.projection.alerting.alerts import REMEMBERED_S, weight_of, why_back
from dray.gateway.live.views import AlertView
from dray.messages import MachineStatus
from dray.store.factory.alert_history import Acknowledgement

pytestmark = pytest.mark.anyio

M8 = "machine_error-M8"


async def say(house: House, seq: int, status: MachineStatus, machine: str = "M8") -> None:
    at_s = house.wall.now_s - NOW_S
    house.bus.say(machine_heartbeat(machine, seq, at_s=at_s, status=status, problem="spindle"))
    await house.alerts.look()


def moment(house: House, in_s: float) -> str:
    return datetime.fromtimestamp(house.wall.now_s + in_s, UTC).isoformat()


async def take(house: House, **body: object) -> httpx.Response:
    return await house.client.post(f"/api/alerts/{M8}/acknowledge", json=body)


async def the_one(house: House) -> dict[str, Any]:
    [alert] = (await house.get("/api/alerts"))["items"]
    return alert  # type: ignore[no-any-return]


async def history(house: House, **asked: str) -> list[dict[str, Any]]:
    answer = await house.client.get("/api/alerts/history", params=asked)
    assert answer.status_code == 200, answer.text
    return answer.json()["items"]  # type: ignore[no-any-return]


async def later(house: House, seq: int, seconds_s: float, status: MachineStatus) -> None:
    house.wall.now_s += seconds_s
    await say(house, seq, status)


# --- until when ----------------------------------------------------------------------------------


async def test_who_takes_it_on_until_some_moment_is_named_until_then_and_it_asks_again(house: House) -> None:
    await say(house, 1, MachineStatus.ERROR)
    answer = await take(house, comment="fitter comes", until_at=moment(house, 600))
    assert answer.status_code == 200, answer.text
    taken = await the_one(house)
    assert (taken["acknowledged_by"], taken["acknowledged_until_at_s"]) == ("Administrator", NOW_S + 600)
    assert (taken["comment"], taken["comment_by"]) == ("fitter comes", "Administrator")
    await later(house, 2, 599, MachineStatus.ERROR)
    assert (await the_one(house))["acknowledged_by"] == "Administrator"
    await later(house, 3, 2, MachineStatus.ERROR)
    back = await the_one(house)
    assert (back["acknowledged_by"], back["came_back"]) == ("", "over")
    assert back["comment"] == "fitter comes"
    [record] = await history(house)
    assert [(word["said"], word["by"]) for word in record["words"]] == [
        ("taken", "Administrator"),
        ("over", ""),
    ]
    assert (await take(house)).json()["acknowledged_until_at_s"] is None


async def test_what_has_come_back_is_open_after_a_restart_too(url: str) -> None:
    async with gateway(url) as house:
        await say(house, 1, MachineStatus.ERROR)
        await take(house, until_at=moment(house, 60))
        await later(house, 2, 61, MachineStatus.ERROR)
        now_s = house.wall.now_s
    async with gateway(url) as house:
        house.wall.now_s = now_s
        await say(house, 3, MachineStatus.ERROR)
        back = await the_one(house)
        assert (back["acknowledged_by"], back["came_back"], back["since_at_s"]) == ("", "over", NOW_S)


@pytest.mark.parametrize("in_s", [-1, 0, 8 * 86_400])
async def test_a_moment_that_is_past_or_far_is_refused(house: House, in_s: float) -> None:
    await say(house, 1, MachineStatus.ERROR)
    problem(await take(house, until_at=moment(house, in_s)), 422, "unusable-fields")
    assert (await the_one(house))["acknowledged_by"] == ""


@pytest.mark.parametrize("body", [{"comment": "a\nb"}, {"comment": "x" * 501}, {"until_at": 5}, {"who": "M"}])
async def test_a_word_that_cannot_be_kept_is_refused(house: House, body: dict[str, object]) -> None:
    await say(house, 1, MachineStatus.ERROR)
    problem(await take(house, **body), 422, "unusable-fields")


async def test_another_person_adds_a_word_and_cannot_change_until_when(house: House) -> None:
    await say(house, 1, MachineStatus.ERROR)
    await house.alerts.acknowledge(M8, "Day shift", "mine", house.wall.now_s + 60)
    problem(await take(house, until_at=moment(house, 600)), 409, "alert-taken-on")
    said = (await take(house, comment="look at the belt, too")).json()
    assert (said["acknowledged_by"], said["acknowledged_until_at_s"]) == ("Day shift", NOW_S + 60)
    assert (said["comment"], said["comment_by"]) == ("look at the belt, too", "Administrator")
    await house.alerts.acknowledge(M8, "Day shift", "", house.wall.now_s + 300)
    assert (await the_one(house))["acknowledged_until_at_s"] == NOW_S + 300
    [record] = await history(house)
    assert [(word["said"], word["by"]) for word in record["words"]] == [
        ("taken", "Day shift"),
        ("commented", "Administrator"),
        ("taken", "Day shift"),
    ]


def bad(kind: str, **more: Any) -> AlertView:
    fields = {"id": kind, "kind": kind, "level": "warning", "response": "clear_way", "since_at_s": 0.0}
    return AlertView(**(fields | more))


@pytest.mark.parametrize(
    ("then", "now"),
    [
        (bad("jam", agents=("A", "B", "C")), bad("jam", agents=("A", "B", "C", "D"))),
        (bad("atv_error"), bad("atv_error", call="call_nobody")),
        (bad("atv_error"), bad("atv_error", level="alarm")),
        (bad("overloaded", waiting=5), bad("overloaded", waiting=10)),
        (bad("plant_behind", behind_s=20.0), bad("plant_behind", behind_s=50.0)),
        (bad("atv_battery", battery_frac=0.09), bad("atv_battery", battery_frac=0.04)),
    ],
)
def test_what_is_put_aside_comes_back_when_it_is_worse_and_not_when_it_is_better(
    then: AlertView, now: AlertView
) -> None:
    for before, after, why in ((then, now, "worse"), (then, then, None), (now, then, None)):
        taken = Acknowledgement(before.id, 0.0, "Day shift", 0.0, until_at_s=60.0, weight=weight_of(before))
        assert why_back(after, taken, 10.0) == why
    for_good = Acknowledgement(then.id, 0.0, "Day shift", 0.0, weight=weight_of(then))
    assert why_back(now, for_good, 1e9) is None, "somebody is at it"


# --- from when to when -----------------------------------------------------------------------------


async def test_an_alert_is_kept_from_when_to_when_with_what_was_known_of_it(house: House) -> None:
    await say(house, 1, MachineStatus.ERROR)
    [lasting] = await history(house, state="lasting")
    assert (lasting["since_at_s"], lasting["ended_at_s"]) == (NOW_S, None)
    await later(house, 2, 60, MachineStatus.IDLE)
    assert await history(house, state="lasting") == []
    [ended] = await history(house, state="ended")
    assert (ended["ended_at_s"], ended["agent"]) == (NOW_S + 60, "M8")
    assert ended["cause"]["detail"] == "spindle"
    await later(house, 3, 60, MachineStatus.ERROR)
    assert [each["since_at_s"] for each in await history(house)] == [NOW_S + 120, NOW_S]


async def test_the_history_is_found_by_words_kinds_times_and_in_pages_that_miss_nothing(house: House) -> None:
    for seq, machine in enumerate(("M1", "M2", "M3", "M4", "M5"), start=1):
        await say(house, seq, MachineStatus.ERROR, machine)
    await house.alerts.acknowledge("machine_error-M2", "Early shift", "Belt torn")
    assert [each["agent"] for each in await history(house, q="belt early")] == ["M2"]
    assert [each["agent"] for each in await history(house, q="m3")] == ["M3"]
    assert len(await history(house, q="SPINDLE", kind="machine_error", level="alarm")) == 5
    assert await history(house, kind="jam") == []
    assert await history(house, before=moment(house, 0)) == []
    assert len(await history(house, since=moment(house, 60))) == 5, "they last"
    seen, cursor = [], {}
    while True:
        page = (await house.client.get("/api/alerts/history", params={"limit": 2, **cursor})).json()
        seen += [each["number"] for each in page["items"]]
        if page["next_cursor"] is None:
            break
        cursor = {"cursor": page["next_cursor"]}
    assert seen == sorted(seen, reverse=True)
    assert len(seen) == 5
    problem(await house.client.get("/api/alerts/history?kind=nonsense"), 422, "unusable-fields")
    problem(await house.client.get("/api/alerts/history?cursor=xx"), 422, "unusable-fields")


async def test_the_table_has_the_words_and_no_formula(house: House) -> None:
    await say(house, 1, MachineStatus.ERROR)
    await take(house, comment="=1+1")
    answer = await house.client.get("/api/alerts/history?format=csv")
    [row] = csv.DictReader(io.StringIO(answer.text))
    assert (row["id"], row["acknowledged_by"], row["cause"]) == (M8, "Administrator", "spindle")
    assert row["comment"] == "'=1+1"
    assert row["words"].endswith("Administrator taken =1+1")


async def test_who_may_not_read_orders_finds_none_of_their_alerts(
    house: House, visitor: httpx.AsyncClient
) -> None:
    await house.place(due_at=moment(house, 60))
    house.wall.now_s += 61
    await house.alerts.look()
    _, header = await house.key(Scope.FACTORY_READ)
    assert len(await history(house)) == 1
    answer = await visitor.get("/api/alerts/history", headers=header)
    assert answer.json()["items"] == []


async def test_of_what_ended_while_no_gateway_ran_the_end_is_when_it_was_seen(url: str) -> None:
    async with gateway(url) as house:
        await say(house, 1, MachineStatus.ERROR)
    async with gateway(url) as house:
        await house.alerts.look()
        assert len(await history(house, state="lasting")) == 1, "all agents have still to speak"
        house.wall.now_s += REMEMBERED_S
        await house.alerts.look()
        [record] = await history(house)
        assert record["ended_at_s"] == NOW_S + REMEMBERED_S


async def test_what_cannot_be_written_is_written_later(house: House, monkeypatch: pytest.MonkeyPatch) -> None:
    def locked(*_args: object) -> None:
        raise UnavailableError("the database", "is locked", "wait")

    with monkeypatch.context() as patched:
        patched.setattr("dray.store.factory.alert_history.AlertHistory.begin", locked)
        await say(house, 1, MachineStatus.ERROR)
        await later(house, 2, 60, MachineStatus.IDLE)
        await later(house, 3, 60, MachineStatus.ERROR)
        assert await history(house) == []
    await house.alerts.look()
    [record] = await history(house)
    assert record["since_at_s"] == NOW_S + 120
