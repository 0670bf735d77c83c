"""Alerts: what is wrong, and since when."""

from __future__ import annotations

from typing import Any, get_args

import pytest
from alerts_kit import alerts, the_alert
from facts_kit import SPEED, opened, tell, wall_s
from fake_bus import PLANT
from heartbeats import atv_heartbeat, events, machine_heartbeat, station_heartbeat
from msgspec import UNSET
from msgspec.structs import replace
from wall_clock import NOW_S

from dray.gateway.live.projection import Projection
from dray.gateway.live.projection.alerting.alert_rules import PATIENCE_S
from dray.gateway.live.projection.alerting.alerts import LOOK_S, RESPONSES
from dray.gateway.live.timescale import TimeScale
from dray.gateway.live.views import AlertKind
from dray.messages import (
    AtvStatus,
    Brief,
    HelpWanted,
    Link,
    LostWlan,
    MachineStatus,
    MaterialWait,
    OutOfService,
    Phase,
    Reason,
    Role,
    TaskBrief,
    Transport,
)
from dray.messages.fact import GoalWaits, MachineFailure, PhaseEntered
from dray.messages.heartbeat import DockWait, StockLevel
from dray.store.factory.alert_history import Acknowledgement
from dray.store.factory.exclusions import Exclusion
from dray.store.orders.orders import Item, Order
from dray.store.orders.progress import OrderStatus

pytestmark = pytest.mark.anyio

CARRYING = Brief(task="T1", epoch=1, role=Role.PRIMARY, coordinator="M1", phase=Phase.CARRYING)


# --- what is wrong ----------------------------------------------------------------------------------


def test_every_kind_asks_for_a_response_and_has_a_level() -> None:
    assert set(RESPONSES) == set(get_args(AlertKind))


def test_what_is_as_it_should_be_makes_no_alert(projection: Projection) -> None:
    projection.fold(atv_heartbeat())
    projection.fold(machine_heartbeat(status=MachineStatus.PRODUCING))
    assert alerts(projection) == []


def test_a_machine_with_a_fault_is_told_in_its_own_words(projection: Projection) -> None:
    projection.fold(machine_heartbeat("M8", status=MachineStatus.ERROR, problem="spindle"))
    alert = the_alert(projection)
    assert (alert.kind, alert.agent, (alert.cause.text if alert.cause else "")) == (
        "machine_error",
        "M8",
        "spindle",
    )


def test_a_dock_that_does_not_get_ready_is_an_alarm_until_it_does(projection: Projection) -> None:
    waits = DockWait(vehicle="ATV2", since_s=-80.0)
    projection.fold(machine_heartbeat("M8", status=MachineStatus.STARVED, dock_wait=waits))
    alert = the_alert(projection)
    assert (alert.kind, alert.level, alert.agent, alert.agents) == (
        "dock_not_ready",
        "alarm",
        "M8",
        ("ATV2",),
    )
    projection.fold(machine_heartbeat("M8", 2, status=MachineStatus.STARVED))
    assert alerts(projection) == []


def test_a_storage_that_nobody_has_counted_is_an_alarm_until_somebody_has(projection: Projection) -> None:
    unknown = StockLevel(item="shaft", level=0, capacity=80, uncounted=True)
    projection.fold(station_heartbeat(stocks=(unknown,)))
    alert = the_alert(projection)
    assert (alert.kind, alert.level, alert.agent) == ("stock_unknown", "alarm", "S1")
    projection.fold(station_heartbeat(seq=2, stocks=(replace(unknown, level=40, uncounted=False),)))
    assert alerts(projection) == []


def test_a_station_tells_of_its_dock_likewise(projection: Projection) -> None:
    waits = DockWait(vehicle="ATV2", since_s=-80.0)
    projection.fold(station_heartbeat(dock_wait=waits))
    assert (the_alert(projection).kind, the_alert(projection).agent) == ("dock_not_ready", "S1")


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
    assert (alert.cause.text if alert.cause else "") == f"for {material.name} (storage S3 has none)"


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


LOST = LostWlan(since_s=-4.0, access_point="AP3")


def test_a_vehicle_that_has_lost_its_wlan_is_an_alert_that_tells_over_whom_it_is_heard(
    projection: Projection,
) -> None:
    projection.fold(atv_heartbeat("ATV2", 1, task=CARRYING))
    assert alerts(projection) == []
    projection.fold(
        atv_heartbeat("ATV2", 2, task=CARRYING, link=Link.MESH, via=("ATV4", "ATV1"), lost_wlan=LOST)
    )
    alert = the_alert(projection)
    assert (alert.kind, alert.level, alert.response) == ("atv_mesh", "warning", "repair_link")
    assert alert.agents == ("ATV4", "ATV1")
    assert (alert.access_point, alert.seen_at_s) == ("AP3", NOW_S + LOST.since_s / SPEED)
    projection.fold(atv_heartbeat("ATV2", 3, task=CARRYING))
    assert alerts(projection) == []


def test_of_a_vehicle_that_is_out_of_service_nothing_is_an_alarm_while_it_carries_nothing(
    projection: Projection,
) -> None:
    out = OutOfService(by="Maria", since_s=0.0, reason="brakes")
    broken: dict[str, Any] = {"status": AtvStatus.ERROR, "problem": "brakes", "out_of_service": out}
    projection.fold(atv_heartbeat("ATV2", 1, task=CARRYING, **broken))
    assert the_alert(projection).kind == "atv_error"
    projection.fold(atv_heartbeat("ATV2", 2, **broken))
    assert alerts(projection) == []
    assert alerts(projection, 3600.0) == [], "it is switched off meanwhile"
    (view,) = projection.atvs.views()
    assert view.out_of_service is not None
    assert (view.out_of_service.by, view.out_of_service.reason) == ("Maria", "brakes")


def test_a_vehicle_that_is_being_charged_may_have_an_empty_battery(projection: Projection) -> None:
    projection.fold(atv_heartbeat(battery_frac=0.02, status=AtvStatus.CHARGING))
    assert alerts(projection) == []


def test_silence_is_a_matter_of_what_the_vehicle_does(projection: Projection) -> None:
    # At ten times real time two wall seconds, 20 factory seconds, are the least.
    projection.fold(atv_heartbeat("ATV1", at_s=1.0, task=CARRYING))
    assert alerts(projection, 20.9) == []
    lost = the_alert(projection, 21.1)
    assert (lost.kind, lost.seen_at_s) == ("atv_lost", wall_s(1.0))


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
        wall_s(1.0),
    )
    projection.fold(station_heartbeat("S3", 2, at_s=22.0))
    assert alerts(projection, 23.0) == []


def test_a_delivery_gate_that_is_silent_is_an_alarm_until_it_speaks_again(projection: Projection) -> None:
    projection.fold(station_heartbeat("gate", 1, at_s=1.0))
    assert alerts(projection, 20.9) == []
    lost = the_alert(projection, 21.1)
    assert (lost.kind, lost.level, lost.response, lost.agent) == (
        "gate_lost",
        "alarm",
        "look_at_gate",
        "gate",
    )
    projection.fold(station_heartbeat("gate", 2, at_s=22.0))
    assert alerts(projection, 23.0) == []


def test_a_gate_that_counts_nothing_is_an_alarm_that_says_why(projection: Projection) -> None:
    projection.fold(station_heartbeat("gate", problem="its count is in doubt (7): pieces went from 70 to 75"))
    alert = the_alert(projection)
    assert (alert.kind, alert.level, alert.response, alert.agent) == (
        "gate_error",
        "alarm",
        "see_to_gate",
        "gate",
    )
    assert alert.cause is not None
    assert alert.cause.detail == "its count is in doubt (7): pieces went from 70 to 75"
    projection.fold(station_heartbeat("gate", 2))
    assert alerts(projection) == []


def test_a_vehicle_that_keepers_of_books_await_is_one_alarm_that_names_them(projection: Projection) -> None:
    def say(seq: int, at_s: float, *awaits: str) -> None:
        for machine in ("M4", "M3"):
            projection.fold(machine_heartbeat(machine, seq, at_s=at_s, awaits=awaits or UNSET))

    say(1, 1.0, "ATV7")
    awaited = the_alert(projection, 2.0)
    assert (awaited.kind, awaited.level, awaited.response, awaited.agent, awaited.keepers) == (
        "atv_awaited",
        "alarm",
        "switch_on",
        "ATV7",
        ("M3", "M4"),
    )
    projection.shut_out([Exclusion("M3", "lies", "Early shift", NOW_S)])
    assert [each.keepers for each in alerts(projection, 2.0) if each.kind == "atv_awaited"] == [("M4",)]
    say(2, 3.0)
    assert [each.kind for each in alerts(projection, 4.0)] == ["machine_shut_out"]


def test_a_station_that_is_shut_out_or_stands_nowhere_is_not_called_silent(projection: Projection) -> None:
    projection.fold(station_heartbeat("S3", 1, at_s=1.0))
    projection.fold(station_heartbeat("S99", 1, at_s=1.0))
    projection.shut_out([Exclusion("S3", "lies", "Early shift", NOW_S)])
    (alert,) = alerts(projection, 60.0)
    assert (alert.kind, alert.agent) == ("station_shut_out", "S3")
    (view,) = projection.stations.views()
    assert (view.id, view.shut_out is not None) == ("S3", True)


def test_of_who_is_silent_nothing_else_is_said(projection: Projection) -> None:
    projection.fold(machine_heartbeat("M1", at_s=1.0, status=MachineStatus.ERROR, problem="spindle"))
    assert the_alert(projection, 60.0).kind == "machine_lost"


def test_help_that_was_promised_asks_for_less(projection: Projection) -> None:
    help_ = HelpWanted(until_s=182.0)
    projection.fold(atv_heartbeat("ATV1", 1, status=AtvStatus.ERROR, problem="load", help=help_))
    asked = the_alert(projection)
    assert (asked.kind, asked.level, asked.until_at_s) == ("atv_help", "alarm", wall_s(182.0))
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
    assert (alert.kind, alert.level, (alert.cause.text if alert.cause else "")) == (
        "atv_stopped",
        "warning",
        "load",
    )


def transport(projection: Projection) -> None:
    """M1 has announced T1, and ATV1 carries it."""
    work = Transport(item="steel", quantity=8, sources=("S1",), destination="M1", ability="tote", goal="G1")
    tell(projection, "M1", opened("T1", work=work), at_s=0.0)
    tell(projection, "ATV1", PhaseEntered(task="T1", epoch=1, phase=Phase.CARRYING), at_s=1.0)


def in_trouble(projection: Projection, detail: str, machine_seq: int) -> None:
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
        trouble=Reason.PROBLEM if detail else Reason.SILENT,
        detail=detail,
    )
    projection.fold(machine_heartbeat("M1", machine_seq, tasks=(brief,)))


def test_a_transport_that_does_not_go_on_is_told_unless_its_carrier_tells_of_it(
    projection: Projection,
) -> None:
    transport(projection)
    in_trouble(projection, "", 1)
    alert = the_alert(projection)
    assert (alert.kind, alert.task, (alert.cause.text if alert.cause else "")) == (
        "task_trouble",
        "T1",
        "silent",
    )
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
    projection.orders.put(order(wall_s(100.0)))
    assert alerts(projection, 99.0) == []
    late = the_alert(projection, 101.0)
    assert (late.kind, late.order, late.until_at_s) == ("order_late", "O-1", wall_s(100.0))
    projection.orders.put(order(wall_s(100.0), OrderStatus.CANCELLED))
    assert alerts(projection, 102.0) == []


def test_an_order_that_waits_says_why_rather_than_that_it_is_late(projection: Projection) -> None:
    projection.orders.put(order(wall_s(100.0)))
    waits = GoalWaits(goal="G1", order="O-1", machines=(MachineFailure("M1", Reason.SILENT),))
    for event in events("strategist", waits, at_s=1.0):
        projection.fold(event)
    alert = the_alert(projection, 101.0)
    assert (alert.kind, (alert.cause.text if alert.cause else "")) == ("order_waits", "M1 is silent")


def test_an_order_for_what_this_plant_does_not_make_asks_for_its_end(projection: Projection) -> None:
    strange = order(wall_s(100.0))
    strange.items = (Item("gear-unit-g1", 4), Item("P9", 1), Item("P8", 1))
    projection.orders.put(strange)
    alert = the_alert(projection, 101.0)
    assert (alert.kind, alert.response) == ("order_impossible", "cancel_order")
    assert (alert.cause.text if alert.cause else "") == "this plant does not make P8 and P9"
    (view,) = projection.orders.views()
    assert view.waits == alert.cause
    projection.orders.put(order(wall_s(100.0), OrderStatus.CANCELLED))
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


# --- how long ---------------------------------------------------------------------------------------


def test_an_alert_begins_when_it_is_seen_and_leaves_with_its_cause(projection: Projection) -> None:
    projection.fold(machine_heartbeat("M8", 1, status=MachineStatus.ERROR))
    first = the_alert(projection, 2.0)
    assert the_alert(projection, 3.0).since_at_s == first.since_at_s == wall_s(2.0)
    projection.fold(machine_heartbeat("M8", 2, status=MachineStatus.PRODUCING))
    assert alerts(projection, 4.0) == []


def test_the_stream_tells_an_alert_once_and_that_it_has_gone(projection: Projection) -> None:
    projection.fold(machine_heartbeat("M8", 1, status=MachineStatus.ERROR))
    projection.look(wall_s(2.0))
    assert [alert.id for alert in projection.delta(1, NOW_S, None).alerts] == ["machine_error-M8"]
    projection.look(wall_s(3.0))
    assert projection.delta(2, NOW_S, None).alerts == ()
    projection.fold(machine_heartbeat("M8", 2))
    projection.look(wall_s(4.0))
    assert projection.delta(3, NOW_S, None).gone == ("alert:machine_error-M8",)


def test_alarms_come_before_warnings_and_graver_ones_before_others(projection: Projection) -> None:
    projection.fold(atv_heartbeat("ATV1", status=AtvStatus.STOPPED))
    projection.fold(atv_heartbeat("ATV3", battery_frac=0.05))
    projection.fold(atv_heartbeat("ATV2", status=AtvStatus.ERROR))
    projection.fold(machine_heartbeat("M2", status=MachineStatus.ERROR))
    assert [alert.agent for alert in alerts(projection)] == ["M2", "ATV2", "ATV1", "ATV3"]
