"""Alerts: who has taken one on, and what is answered over REST."""

from __future__ import annotations

import pytest
from alerts_kit import alerts, the_alert
from answers import problem
from facts_kit import wall_s
from gateway_kit import House, gateway
from heartbeats import machine_heartbeat
from wall_clock import NOW_S

from dray.errors import UnavailableError
from dray.gateway.live.projection import Projection
from dray.gateway.live.projection.alerting.alerts import REMEMBERED_S
from dray.messages import MachineStatus
from dray.store.factory.alert_history import Acknowledgement

pytestmark = pytest.mark.anyio


# --- who has taken it on ----------------------------------------------------------------------------


def test_who_was_first_to_acknowledge_stays(projection: Projection) -> None:
    projection.fold(machine_heartbeat("M8", status=MachineStatus.ERROR))
    alert = the_alert(projection)
    for name, at_s in (("Day shift", 5.0), ("Night shift", 6.0)):
        projection.alerts.acknowledge(Acknowledgement(alert.id, alert.since_at_s, name, at_s))
    taken = the_alert(projection)
    assert (taken.acknowledged_by, taken.acknowledged_at_s) == ("Day shift", 5.0)


def test_what_comes_again_is_acknowledged_by_nobody(projection: Projection) -> None:
    projection.fold(machine_heartbeat("M8", 1, status=MachineStatus.ERROR))
    alert = the_alert(projection)
    projection.alerts.acknowledge(Acknowledgement(alert.id, alert.since_at_s, "Day shift", 5.0))
    projection.fold(machine_heartbeat("M8", 2))
    assert projection.look(wall_s(3.0)) == [alert.id]
    projection.fold(machine_heartbeat("M8", 3, status=MachineStatus.ERROR))
    assert the_alert(projection, 4.0).acknowledged_by == ""


def test_what_was_acknowledged_before_a_start_is_so_after_it(projection: Projection) -> None:
    known = Acknowledgement("machine_error-M8", NOW_S - 600, "Day shift", NOW_S - 500)
    projection.alerts.restore([known], NOW_S)
    assert alerts(projection) == []
    projection.fold(machine_heartbeat("M8", status=MachineStatus.ERROR))
    alert = the_alert(projection)
    assert (alert.since_at_s, alert.acknowledged_by) == (NOW_S - 600, "Day shift")


def test_what_is_not_wrong_again_soon_after_a_start_has_ended(projection: Projection) -> None:
    projection.alerts.restore([Acknowledgement("machine_error-M8", NOW_S - 600, "Day shift", NOW_S)], NOW_S)
    assert projection.look(NOW_S + REMEMBERED_S - 1) == []
    assert projection.look(NOW_S + REMEMBERED_S) == ["machine_error-M8"]
    assert projection.look(NOW_S + REMEMBERED_S + 1) == []


# --- over REST --------------------------------------------------------------------------------------


async def break_down(house: House, seq: int = 1) -> str:
    """M8 has a fault, and the desk has seen it; returns the alert's id."""
    house.bus.say(machine_heartbeat("M8", seq, status=MachineStatus.ERROR, problem="spindle"))
    await house.alerts.look()
    return "machine_error-M8"


async def kept(house: House) -> list[str]:
    async with house.store.read() as work:
        return [each.alert for each in await work.alerts.lasting() if each.is_held]


async def test_an_alert_is_acknowledged_by_name_and_that_is_on_disk(house: House) -> None:
    alert = await break_down(house)
    (listed,) = (await house.get("/api/alerts"))["items"]
    assert (listed["id"], listed["response"], listed["acknowledged_by"]) == (alert, "repair", "")
    answer = await house.client.post(f"/api/alerts/{alert}/acknowledge")
    assert answer.status_code == 200
    assert answer.json()["acknowledged_by"] == "Administrator"
    assert await kept(house) == [alert]


async def test_an_acknowledgement_is_forgotten_with_its_alert(house: House) -> None:
    alert = await break_down(house)
    await house.client.post(f"/api/alerts/{alert}/acknowledge")
    house.bus.say(machine_heartbeat("M8", 2))
    await house.alerts.look()
    assert await kept(house) == []
    problem(await house.client.post(f"/api/alerts/{alert}/acknowledge"), 404, "unknown-alert")


async def test_an_acknowledgement_outlives_a_restart(url: str) -> None:
    async with gateway(url) as house:
        await house.client.post(f"/api/alerts/{await break_down(house)}/acknowledge")
    async with gateway(url) as house:
        await break_down(house)
        (alert,) = (await house.get("/api/alerts"))["items"]
    assert alert["acknowledged_by"] == "Administrator"


async def test_what_cannot_be_forgotten_at_once_is_forgotten_later(
    house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    alert = await break_down(house)
    await house.client.post(f"/api/alerts/{alert}/acknowledge")
    house.bus.say(machine_heartbeat("M8", 2))

    def locked(*_args: object) -> None:
        raise UnavailableError("the database", "is locked", "wait")

    with monkeypatch.context() as patched:
        patched.setattr("dray.store.factory.alert_history.AlertHistory.end", locked)
        await house.alerts.look()
        assert await kept(house) == [alert]
    await house.alerts.look()
    assert await kept(house) == []
