"""Alerts of one cause: one of them, which names the cause and all whom it has hit."""

from __future__ import annotations

from typing import Any

import msgspec
import pytest
from alerts_kit import alerts, the_alert
from facts_kit import SPEED, wall_s
from heartbeats import atv_heartbeat, machine_heartbeat
from wall_clock import NOW_S

from dray.gateway.live.projection import Projection
from dray.gateway.live.projection.alerting.causes import gathered
from dray.gateway.live.views.alert import AlertKind, CallKind, Condition
from dray.messages import CallPlace, CallState, HelpCall, Link, LostWlan, MachineStatus

pytestmark = pytest.mark.anyio


def gathered_kinds(*wrong: Condition) -> list[tuple[AlertKind, str]]:
    return [(each.kind, each.agent) for each in gathered(wrong, speed=1.0)]


def silent(agent: str, seen_at_s: float, kind: AlertKind = "atv_lost") -> Condition:
    return Condition(kind=kind, agent=agent, seen_at_s=seen_at_s)


def on_mesh(agent: str, point: str = "AP3") -> dict[str, Any]:
    lost = LostWlan(since_s=0.5, access_point=point)
    return {"atv": agent, "seq": 1, "link": Link.MESH, "via": ("ATV9",), "lost_wlan": lost}


def help_call(caller: str, on_duty: int) -> HelpCall:
    """A call for which nobody has come so far."""
    return HelpCall(
        call=f"{caller}-1-1",
        caller=caller,
        incarnation=1,
        number=1,
        at_s=1.0,
        state=CallState.RESTING,
        since_s=1.0,
        reason="spindle",
        x_m=30.0,
        y_m=30.0,
        on_duty=on_duty,
    )


# --- access points ----------------------------------------------------------------------------------


def test_vehicles_that_have_lost_one_access_point_are_one_alert(projection: Projection) -> None:
    projection.fold(atv_heartbeat(**on_mesh("ATV2")))
    assert the_alert(projection).kind == "atv_mesh", "one vehicle may be at fault itself"
    projection.fold(atv_heartbeat(**on_mesh("ATV1")))
    alert = the_alert(projection)
    assert (alert.id, alert.response) == ("access_point-AP3", "repair_access_point")
    assert (alert.agents, alert.seen_at_s) == (("ATV1", "ATV2"), NOW_S + 0.5 / SPEED)
    projection.fold(atv_heartbeat("ATV1", 2))
    assert the_alert(projection).id == "atv_mesh-ATV2"


def test_vehicles_of_different_or_unknown_access_points_are_alerts_of_their_own(
    projection: Projection,
) -> None:
    for atv, point in (("ATV1", "AP1"), ("ATV2", "AP2"), ("ATV3", ""), ("ATV4", "")):
        projection.fold(atv_heartbeat(**on_mesh(atv, point)))
    assert {alert.kind for alert in alerts(projection)} == {"atv_mesh"}
    assert len(alerts(projection)) == 4


# --- parts of the network ---------------------------------------------------------------------------


def test_those_who_fall_silent_at_one_moment_are_one_alert_and_whoever_did_not_is_another() -> None:
    part = silent("M8", 10.4, "machine_lost"), silent("ATV1", 10.0), silent("S1", 10.9, "station_lost")
    found = list(gathered((*part, silent("ATV2", 60.0)), speed=1.0))
    assert [(each.kind, each.agents, each.seen_at_s) for each in found] == [
        ("atv_lost", (), 60.0),
        ("part_lost", ("ATV1", "M8", "S1"), 10.0),
    ]


def test_two_at_one_moment_and_many_one_after_the_other_are_alerts_of_their_own() -> None:
    two = silent("ATV1", 10.0), silent("ATV2", 10.1)
    assert gathered_kinds(*two) == [("atv_lost", "ATV1"), ("atv_lost", "ATV2")]
    spread = [silent(f"ATV{place}", 10.0 + 30.0 * place) for place in range(6)]
    assert {kind for kind, _ in gathered_kinds(*spread)} == {"atv_lost"}


def test_the_moment_is_counted_in_factory_time() -> None:
    fell = [silent(f"ATV{place}", 10.0 + 0.2 * place) for place in range(4)]
    assert [each.kind for each in gathered(fell, speed=1.0)] == ["part_lost"]
    assert {each.kind for each in gathered(fell, speed=100.0)} == {"atv_lost"}


def test_a_part_that_is_lost_names_itself_the_same_at_each_look(projection: Projection) -> None:
    for atv in ("ATV1", "ATV2", "ATV3"):
        projection.fold(atv_heartbeat(atv, 1))
    for seq in range(2, 200):
        for machine in ("M1", "M2", "M3", "M4"):
            projection.fold(machine_heartbeat(machine, seq))
    alert = the_alert(projection, 199.0)
    assert (alert.kind, alert.agents, alert.seen_at_s) == ("part_lost", ("ATV1", "ATV2", "ATV3"), wall_s(1.0))
    assert "ATV" not in alert.id, "who sees a part only is not told who is elsewhere"
    assert the_alert(projection, 199.5).id == alert.id


# --- calls for help ---------------------------------------------------------------------------------


@pytest.mark.parametrize(("on_duty", "call"), [(0, "call_nobody"), (2, "call_unanswered")])
def test_a_broken_machine_to_which_nobody_comes_is_one_alert(
    projection: Projection, on_duty: int, call: CallKind
) -> None:
    projection.fold(machine_heartbeat("M8", status=MachineStatus.ERROR, problem="spindle"))
    wrong = the_alert(projection)
    assert (wrong.call, wrong.response) == (None, "repair")
    projection.people.fold(help_call("M8", on_duty), 2.0)
    called = the_alert(projection)
    assert (called.id, called.call, called.response) == (wrong.id, call, "send_somebody")
    assert called.cause == wrong.cause


def test_a_call_of_whom_nothing_else_is_told_stays_an_alert_of_its_own() -> None:
    others = Condition(kind="machine_error", agent="M7")
    call = Condition(kind="call_nobody", agent="M8")
    assert gathered_kinds(others, call) == [("machine_error", "M7"), ("call_nobody", "M8")]
    out = Condition(kind="machine_shut_out", agent="M8")
    assert gathered_kinds(out, call) == [("machine_shut_out", "M8"), ("call_nobody", "M8")]


# --- a plant that is behind -------------------------------------------------------------------------


def test_where_the_plant_is_behind_no_clock_is_to_be_set() -> None:
    behind = Condition(kind="plant_behind", behind_s=147)
    late = Condition(kind="clock_wrong", agent="ATV3", clock_ahead_s=-147)
    ahead = Condition(kind="clock_wrong", agent="ATV4", clock_ahead_s=400)
    assert gathered_kinds(behind, late, ahead) == [("plant_behind", ""), ("clock_wrong", "ATV4")]
    assert gathered_kinds(late) == [("clock_wrong", "ATV3")]


# --- vehicles that tell no place --------------------------------------------------------------------


@pytest.mark.parametrize("state", [CallState.ASKING, CallState.TAKEN, CallState.RESTING])
def test_a_vehicle_that_tells_no_place_is_an_alert_for_as_long_as_it_calls(
    projection: Projection, state: CallState
) -> None:
    call = msgspec.structs.replace(help_call("ATV1", 1), state=state, place=CallPlace.UNTOLD)
    projection.people.fold(call, 2.0)
    alert = the_alert(projection, 1.0)
    assert (alert.kind, alert.agent) == ("atv_unplaced", "ATV1")
    assert alert.call == ("call_unanswered" if state is CallState.RESTING else None)
    projection.people.fold(msgspec.structs.replace(call, number=2, state=CallState.ENDED), 2.0)
    assert not alerts(projection, 1.0)


def test_its_silence_since_its_last_life_is_no_alert_of_its_own(projection: Projection) -> None:
    projection.fold(atv_heartbeat("ATV1", 1))
    for seq in range(2, 90):
        projection.fold(machine_heartbeat("M1", seq))
    assert the_alert(projection, 89.0).kind == "atv_lost"
    call = msgspec.structs.replace(help_call("ATV1", 1), state=CallState.ASKING, place=CallPlace.LAST)
    projection.people.fold(call, 89.0)
    assert the_alert(projection, 89.0).kind == "atv_unplaced"
