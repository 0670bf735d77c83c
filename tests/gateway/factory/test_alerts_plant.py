"""Alerts of the plant as a whole: it cannot keep up, a clock is ahead, or more is asked for than vehicles can carry."""

from __future__ import annotations

import pytest
from alerts_kit import alerts, the_alert
from facts_kit import wall_s
from heartbeats import atv_heartbeat, events, machine_heartbeat

from dray.gateway.live.projection import Projection
from dray.messages import Role, Transport
from dray.messages.fact import TaskClosed, TaskOpened
from dray.overload import LEAST, WAITED_S

pytestmark = pytest.mark.anyio


def everybody(projection: Projection, at_s: float, vehicles: int = 200, seq: int = 1) -> None:
    """All vehicles and three machines speak."""
    for number in range(1, vehicles + 1):
        projection.fold(atv_heartbeat(f"ATV{number}", seq, at_s=at_s))
    for number in range(1, 4):
        projection.fold(machine_heartbeat(f"M{number}", seq, at_s=at_s))


def test_a_plant_that_cannot_keep_up_is_one_alarm_and_nobody_is_suspected(projection: Projection) -> None:
    everybody(projection, 1.0)
    alert = the_alert(projection, 101.0)
    assert (alert.kind, alert.level, alert.agent, alert.behind_s) == ("plant_behind", "alarm", "", 10)
    assert alert.id == "plant_behind"
    assert projection.factory(wall_s(101.0)).behind_s == pytest.approx(10.0)


def test_that_alarm_ends_when_the_plant_has_caught_up(projection: Projection) -> None:
    everybody(projection, 1.0)
    assert alerts(projection, 101.0) != []
    everybody(projection, 99.0, seq=2)
    assert alerts(projection, 101.0) == []
    assert projection.factory(wall_s(101.0)).behind_s == pytest.approx(0.2)


def test_who_is_silent_in_a_plant_that_is_behind_is_found_all_the_same(projection: Projection) -> None:
    everybody(projection, 1.0)
    everybody(projection, 101.0, vehicles=199, seq=2)
    kinds = {alert.kind: alert.agent for alert in alerts(projection, 201.0)}
    assert kinds == {"plant_behind": "", "atv_lost": "ATV200"}


def test_one_whose_clock_is_ahead_makes_nobody_else_look_silent(projection: Projection) -> None:
    everybody(projection, 1.0)
    projection.fold(atv_heartbeat("ATV1", 2, at_s=5000.0))
    assert [alert.kind for alert in alerts(projection, 101.0)] == ["plant_behind"]


def test_the_only_agent_that_was_ever_heard_is_lost_when_it_is_silent(projection: Projection) -> None:
    projection.fold(atv_heartbeat("ATV1", at_s=1.0))
    assert the_alert(projection, 101.0).kind == "atv_lost"


def open_transports(projection: Projection, count: int, at_s: float) -> None:
    """M1 asks for so many transports."""
    work = Transport(item="steel", quantity=8, sources=("S1",), destination="M1", ability="tote")
    facts = [
        TaskOpened(
            task=f"T{number}",
            epoch=1,
            round=1,
            role=Role.PRIMARY,
            work=work,
            radius_m=15.0,
            deadline_s=at_s + 400.0,
            bids_until_s=at_s + 2.0,
        )
        for number in range(count)
    ]
    for event in events("M1", *facts, at_s=at_s):
        projection.fold(event)


def test_vehicles_that_cannot_carry_what_is_asked_for_are_one_warning_with_the_figure(
    projection: Projection,
) -> None:
    open_transports(projection, LEAST, 0.0)
    assert alerts(projection, WAITED_S) == []
    alert = the_alert(projection, WAITED_S + 4.0)
    assert (alert.kind, alert.level, alert.waiting, alert.carried_frac) == (
        "overloaded",
        "warning",
        LEAST,
        0.0,
    )


def test_a_large_fleet_is_overloaded_by_more_transports(projection: Projection) -> None:
    open_transports(projection, LEAST, 0.0)
    everybody(projection, WAITED_S + 1.0, vehicles=20)
    assert alerts(projection, WAITED_S + 4.0) == []


def test_an_overload_does_not_come_and_go_with_every_transport(projection: Projection) -> None:
    open_transports(projection, LEAST, 0.0)
    assert the_alert(projection, WAITED_S + 4.0).kind == "overloaded"
    closed = TaskClosed(task="T0", epoch=1, outcome="delivered", carrier="ATV1")
    again = TaskClosed(task="T1", epoch=1, outcome="delivered", carrier="ATV1")
    for event in events("M1", closed, at_s=WAITED_S + 2.0, first=LEAST + 1):
        projection.fold(event)
    alert = the_alert(projection, WAITED_S + 5.0)
    assert (alert.waiting, alert.carried_frac) == (LEAST - 1, 0.33)
    for event in events("M1", again, at_s=WAITED_S, first=LEAST + 2):
        projection.fold(event)
    assert alerts(projection, WAITED_S + 7.0) == []
