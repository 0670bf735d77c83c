"""Alerts: what is wrong, since when, and who has taken it on."""

from __future__ import annotations

from typing import Any, get_args

import pytest
from gateway_kit import (
    NOW_S,
    PLANT,
    House,
    atv_heartbeat,
    events,
    gateway,
    machine_heartbeat,
    problem,
    station_heartbeat,
)

from dray.errors import UnavailableError
from dray.gateway.live.projection import Projection
from dray.gateway.live.projection.alerting.alert_rules import PATIENCE_S
from dray.gateway.live.projection.alerting.alerts import LOOK_S, REMEMBERED_S, RESPONSES
from dray.gateway.live.timescale import TimeScale
from dray.gateway.live.views import AlertKind, AlertView
from dray.messages import (
    AtvStatus,
    Brief,
    HelpWanted,
    MachineStatus,
    MaterialWait,
    Phase,
    Role,
    TaskBrief,
    Transport,
)
from dray.messages.fact import GoalWaits, PhaseEntered, TaskClosed, TaskOpened
from dray.overload import LEAST, WAITED_S
from dray.store.factory.acknowledgements import Acknowledgement
from dray.store.factory.exclusions import Exclusion
from dray.store.orders.orders import Item, Order
from dray.store.orders.progress import OrderStatus

pytestmark = pytest.mark.anyio

SPEED = 10.0
"""Plant seconds per wall second, so that a time that was not turned is seen."""

CARRYING = Brief(task="T1", epoch=1, role=Role.PRIMARY, coordinator="M1", phase=Phase.CARRYING)


@pytest.fixture
def projection() -> Projection:
    return Projection(PLANT, TimeScale(0.0, NOW_S, SPEED))


def at(plant_s: float) -> float:
    """The wall clock at a moment of the plant's."""
    return NOW_S + plant_s / SPEED


def alerts(projection: Projection, plant_s: float = 2.0) -> list[AlertView]:
    projection.look(at(plant_s))
    return list(projection.alerts.views())


def the_alert(projection: Projection, plant_s: float = 2.0) -> AlertView:
    (alert,) = alerts(projection, plant_s)
    return alert


# --- what is wrong -------------------------------------------------------------------------------


def test_every_kind_asks_for_a_response_and_has_a_level() -> None:
    assert set(RESPONSES) == set(get_args(AlertKind))


def test_what_is_as_it_should_be_makes_no_alert(projection: Projection) -> None:
    projection.fold(atv_heartbeat())
    projection.fold(machine_heartbeat(status=MachineStatus.PRODUCING))
    assert alerts(projection) == []


def test_a_machine_with_a_fault_is_told_in_its_own_words(projection: Projection) -> None:
    projection.fold(machine_heartbeat("M8", status=MachineStatus.ERROR, problem="spindle"))
    alert = the_alert(projection)
    assert (alert.kind, alert.agent, alert.problem) == ("machine_error", "M8", "spindle")


@pytest.mark.parametrize(
    ("status", "kind"),
    [(MachineStatus.STARVED, "machine_starved"), (MachineStatus.BLOCKED, "machine_blocked")],
)
def test_a_machine_may_wait_for_a_vehicle_as_long_as_one_takes(
    projection: Projection, status: MachineStatus, kind: str
) -> None:
    for seq in range(1, 121):
        projection.fold(machine_heartbeat("M8", seq, status=status))
    assert alerts(projection, PATIENCE_S) == []
    assert the_alert(projection, PATIENCE_S + 2).kind == kind


def test_a_machine_that_starves_tells_for_what_it_waits(projection: Projection) -> None:
    material = PLANT.materials[0]
    wait = MaterialWait(item=material.id, quantity=5, short=("S3",))
    for at_s in (1.0, PATIENCE_S + 2):
        projection.fold(
            machine_heartbeat("M8", int(at_s), at_s=at_s, status=MachineStatus.STARVED, waits=(wait,))
        )
    alert = the_alert(projection, PATIENCE_S + 3)
    assert alert.problem == f"for {material.name} (storage S3 has none)"


@pytest.mark.parametrize(
    ("fields", "kind"),
    [
        ({"status": AtvStatus.ERROR, "problem": "wheel"}, "atv_error"),
        ({"status": AtvStatus.STOPPED}, "atv_stopped"),
        ({"battery_frac": 0.09}, "atv_battery"),
        ({"battery_frac": 0.09, "status": AtvStatus.STOPPED}, "atv_stopped"),
    ],
)
def test_a_vehicle_has_its_gravest_trouble(projection: Projection, fields: dict[str, Any], kind: str) -> None:
    projection.fold(atv_heartbeat("ATV2", **fields))
    assert the_alert(projection).kind == kind


def test_a_vehicle_that_is_being_charged_may_have_an_empty_battery(projection: Projection) -> None:
    projection.fold(atv_heartbeat(battery_frac=0.02, status=AtvStatus.CHARGING))
    assert alerts(projection) == []


def test_silence_is_a_matter_of_what_the_vehicle_does(projection: Projection) -> None:
    # At ten times real time two wall seconds, 20 factory seconds, are the least.
    projection.fold(atv_heartbeat("ATV1", at_s=1.0, task=CARRYING))
    assert alerts(projection, 20.9) == []
    lost = the_alert(projection, 21.1)
    assert (lost.kind, lost.seen_at_s) == ("atv_lost", at(1.0))


@pytest.mark.parametrize(("task", "bound_s"), [(CARRYING, 3.5), (None, 15.5)])
def test_in_real_time_three_beats_and_a_half_second_are_silence(task: Brief | None, bound_s: float) -> None:
    projection = Projection(PLANT, TimeScale(0.0, NOW_S))
    projection.fold(atv_heartbeat("ATV1", at_s=0.0, task=task))
    projection.look(NOW_S + bound_s - 0.1)
    assert projection.alerts.views() == ()
    projection.look(NOW_S + bound_s + 0.1)
    assert projection.alerts.views() != ()


def test_a_storage_whose_station_is_silent_is_an_alarm_until_it_speaks_again(projection: Projection) -> None:
    projection.fold(station_heartbeat("S3", 1, at_s=1.0))
    # At ten times real time two wall seconds, 20 factory seconds, are the least.
    assert alerts(projection, 20.9) == []
    lost = the_alert(projection, 21.1)
    assert (lost.kind, lost.level, lost.response, lost.agent, lost.seen_at_s) == (
        "station_lost",
        "alarm",
        "look_at_station",
        "S3",
        at(1.0),
    )
    projection.fold(station_heartbeat("S3", 2, at_s=22.0))
    assert alerts(projection, 23.0) == []


def test_a_station_that_is_shut_out_or_stands_nowhere_is_not_called_silent(projection: Projection) -> None:
    projection.fold(station_heartbeat("S3", 1, at_s=1.0))
    projection.fold(station_heartbeat("S99", 1, at_s=1.0))
    projection.shut_out([Exclusion("S3", "lies", "Maria Weber", NOW_S)])
    (alert,) = alerts(projection, 60.0)
    assert (alert.kind, alert.agent) == ("machine_shut_out", "S3")
    (view,) = projection.stations.views()
    assert (view.id, view.shut_out is not None) == ("S3", True)


def test_of_who_is_silent_nothing_else_is_said(projection: Projection) -> None:
    projection.fold(machine_heartbeat("M1", at_s=1.0, status=MachineStatus.ERROR, problem="spindle"))
    assert the_alert(projection, 60.0).kind == "machine_lost"


def test_help_that_was_promised_asks_for_less(projection: Projection) -> None:
    help_ = HelpWanted(until_s=182.0)
    projection.fold(atv_heartbeat("ATV1", 1, status=AtvStatus.ERROR, problem="load", help=help_))
    asked = the_alert(projection)
    assert (asked.kind, asked.level, asked.until_at_s) == ("atv_help", "alarm", at(182.0))
    promised = HelpWanted(until_s=182.0, promised_by="Shift 2")
    projection.fold(atv_heartbeat("ATV1", 2, status=AtvStatus.ERROR, problem="load", help=promised))
    answered = the_alert(projection)
    assert (answered.kind, answered.level, answered.by) == ("atv_promised", "warning", "Shift 2")


def test_a_vehicle_that_a_person_has_stopped_asks_for_no_help_though_its_task_waits(
    projection: Projection,
) -> None:
    help_ = HelpWanted(until_s=182.0)
    stopped = atv_heartbeat("ATV1", 1, status=AtvStatus.STOPPED, problem="load", help=help_)
    projection.fold(stopped)
    alert = the_alert(projection)
    assert (alert.kind, alert.level, alert.problem) == ("atv_stopped", "warning", "load")


def transport(projection: Projection) -> None:
    """M1 has announced T1, and ATV1 carries it."""
    work = Transport(item="steel", quantity=8, sources=("S1",), destination="M1", ability="tote", goal="G1")
    opened = TaskOpened(
        task="T1",
        epoch=1,
        round=1,
        role=Role.PRIMARY,
        work=work,
        radius_m=15.0,
        deadline_s=400.0,
        bids_until_s=2.0,
    )
    entered = PhaseEntered(task="T1", epoch=1, phase=Phase.CARRYING)
    for event in (*events("M1", opened, at_s=0.0), *events("ATV1", entered, at_s=1.0)):
        projection.fold(event)


def in_trouble(projection: Projection, trouble: str, machine_seq: int) -> None:
    """M1's transport T1 does not go on, says M1."""
    brief = TaskBrief(
        task="T1",
        epoch=1,
        item="steel",
        quantity=8,
        source="S1",
        destination="M1",
        deadline_s=400.0,
        primary="ATV1",
        trouble=trouble,
    )
    projection.fold(machine_heartbeat("M1", machine_seq, tasks=(brief,)))


def test_a_transport_that_does_not_go_on_is_told_unless_its_carrier_tells_of_it(
    projection: Projection,
) -> None:
    transport(projection)
    in_trouble(projection, "its carrier is silent", 1)
    alert = the_alert(projection)
    assert (alert.kind, alert.task, alert.problem) == ("task_trouble", "T1", "its carrier is silent")
    assert alert.id == "task_trouble-T1"


def test_what_the_carrier_says_itself_is_not_said_again_of_its_transport(projection: Projection) -> None:
    transport(projection)
    in_trouble(projection, "its load has shifted", 1)
    projection.fold(atv_heartbeat("ATV1", status=AtvStatus.ERROR, problem="its load has shifted"))
    assert the_alert(projection).kind == "atv_error"


def order(due_at_s: float | None, status: OrderStatus = OrderStatus.RELEASED) -> Order:
    return Order(
        id="O-1",
        status=status,
        customer="Hall 3",
        token="token",
        items=(Item("gear-unit-g1", 4),),
        created_at_s=NOW_S,
        due_at_s=due_at_s,
    )


def test_an_order_is_late_until_it_is_delivered(projection: Projection) -> None:
    projection.orders.put(order(at(100.0)))
    assert alerts(projection, 99.0) == []
    late = the_alert(projection, 101.0)
    assert (late.kind, late.order, late.until_at_s) == ("order_late", "O-1", at(100.0))
    projection.orders.put(order(at(100.0), OrderStatus.CANCELLED))
    assert alerts(projection, 102.0) == []


def test_an_order_that_waits_says_why_rather_than_that_it_is_late(projection: Projection) -> None:
    projection.orders.put(order(at(100.0)))
    waits = GoalWaits(goal="G1", order="O-1", reason="M1 is silent")
    for event in events("strategist", waits, at_s=1.0):
        projection.fold(event)
    alert = the_alert(projection, 101.0)
    assert (alert.kind, alert.problem) == ("order_waits", "M1 is silent")


def test_an_order_for_what_this_plant_does_not_make_asks_for_its_end(projection: Projection) -> None:
    strange = order(at(100.0))
    strange.items = (Item("gear-unit-g1", 4), Item("P9", 1), Item("P8", 1))
    projection.orders.put(strange)
    alert = the_alert(projection, 101.0)
    assert (alert.kind, alert.response) == ("order_impossible", "cancel_order")
    assert alert.problem == "this plant does not make P8 and P9"
    (view,) = projection.orders.views()
    assert view.waits == alert.problem
    projection.orders.put(order(at(100.0), OrderStatus.CANCELLED))
    assert alerts(projection, 102.0) == []


def test_what_was_acknowledged_at_another_gateway_is_of_the_alert_that_began_by_then(
    projection: Projection,
) -> None:
    projection.fold(machine_heartbeat("M8", 1, status=MachineStatus.ERROR))
    alert = the_alert(projection)
    before, just_now = (
        Acknowledgement(alert.id, alert.since_at_s - 9.0, name, alert.since_at_s - ago_s)
        for name, ago_s in (("Night shift", LOOK_S), ("Day shift", LOOK_S / 2))
    )
    projection.alerts.on_acknowledged(
        [before, Acknowledgement("machine_error-M1", NOW_S, "Day shift", NOW_S)]
    )
    assert the_alert(projection).acknowledged_by == ""
    projection.alerts.on_acknowledged([just_now])
    assert the_alert(projection).acknowledged_by == "Day shift"


# --- how long ------------------------------------------------------------------------------------


def test_an_alert_begins_when_it_is_seen_and_leaves_with_its_cause(projection: Projection) -> None:
    projection.fold(machine_heartbeat("M8", 1, status=MachineStatus.ERROR))
    first = the_alert(projection, 2.0)
    assert the_alert(projection, 3.0).since_at_s == first.since_at_s == at(2.0)
    projection.fold(machine_heartbeat("M8", 2, status=MachineStatus.PRODUCING))
    assert alerts(projection, 4.0) == []


def test_the_stream_tells_an_alert_once_and_that_it_has_gone(projection: Projection) -> None:
    projection.fold(machine_heartbeat("M8", 1, status=MachineStatus.ERROR))
    projection.look(at(2.0))
    assert [alert.id for alert in projection.delta(1, NOW_S, None).alerts] == ["machine_error-M8"]
    projection.look(at(3.0))
    assert projection.delta(2, NOW_S, None).alerts == ()
    projection.fold(machine_heartbeat("M8", 2))
    projection.look(at(4.0))
    assert projection.delta(3, NOW_S, None).gone == ("alert:machine_error-M8",)


def test_alarms_come_before_warnings_and_graver_ones_before_others(projection: Projection) -> None:
    projection.fold(atv_heartbeat("ATV1", status=AtvStatus.STOPPED))
    projection.fold(atv_heartbeat("ATV3", battery_frac=0.05))
    projection.fold(atv_heartbeat("ATV2", status=AtvStatus.ERROR))
    projection.fold(machine_heartbeat("M2", status=MachineStatus.ERROR))
    assert [alert.agent for alert in alerts(projection)] == ["M2", "ATV2", "ATV1", "ATV3"]


# --- who has taken it on -------------------------------------------------------------------------


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
    assert projection.look(at(3.0)) == [alert.id]
    projection.fold(machine_heartbeat("M8", 3, status=MachineStatus.ERROR))
    assert the_alert(projection, 4.0).acknowledged_by == ""


def test_what_was_acknowledged_before_a_start_is_so_after_it(projection: Projection) -> None:
    known = Acknowledgement("machine_error-M8", NOW_S - 600, "Day shift", NOW_S - 500)
    projection.alerts.recall([known], NOW_S)
    assert alerts(projection) == []
    projection.fold(machine_heartbeat("M8", status=MachineStatus.ERROR))
    alert = the_alert(projection)
    assert (alert.since_at_s, alert.acknowledged_by) == (NOW_S - 600, "Day shift")


def test_what_is_not_wrong_again_soon_after_a_start_has_ended(projection: Projection) -> None:
    projection.alerts.recall([Acknowledgement("machine_error-M8", NOW_S - 600, "Day shift", NOW_S)], NOW_S)
    assert projection.look(NOW_S + REMEMBERED_S - 1) == []
    assert projection.look(NOW_S + REMEMBERED_S) == ["machine_error-M8"]
    assert projection.look(NOW_S + REMEMBERED_S + 1) == []


# --- over REST -----------------------------------------------------------------------------------


async def break_down(house: House, seq: int = 1) -> str:
    """M8 has a fault, and the desk has seen it; returns the alert's id."""
    house.bus.say(machine_heartbeat("M8", seq, status=MachineStatus.ERROR, problem="spindle"))
    await house.alerts.look()
    return "machine_error-M8"


async def kept(house: House) -> list[str]:
    async with house.store.read() as work:
        return [each.alert for each in await work.acknowledgements.all()]


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
        patched.setattr("dray.store.factory.acknowledgements.Acknowledgements.drop", locked)
        await house.alerts.look()
        assert await kept(house) == [alert]
    await house.alerts.look()
    assert await kept(house) == []


# --- the plant as a whole ------------------------------------------------------------------------


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
    assert projection.factory(at(101.0)).behind_s == pytest.approx(10.0)


def test_that_alarm_ends_when_the_plant_has_caught_up(projection: Projection) -> None:
    everybody(projection, 1.0)
    assert alerts(projection, 101.0) != []
    everybody(projection, 99.0, seq=2)
    assert alerts(projection, 101.0) == []
    assert projection.factory(at(101.0)).behind_s == pytest.approx(0.2)


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
