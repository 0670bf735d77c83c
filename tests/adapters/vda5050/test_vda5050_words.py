"""Words that the standard does not have, and vehicles that stand without a word that counts: people are told what the vehicle has said."""

from __future__ import annotations

import json
from typing import Any

import pytest
from field import Change, reword, say
from vda_rig import FLOWING, PROFILE, Rig
from yard import HOLD, PICK, TO_CORNER, drive

from dray.adapters.vda5050.profile import Profile
from dray.body import ActionDone, Charge, NodePassed, ProblemCleared, WayDone
from dray.messages.problem import ProblemKind


def standing(change: Change) -> Rig:
    """A vehicle that stops on its first lane by itself, and says something besides."""
    rig = Rig(FLOWING)
    rig.do(drive(*TO_CORNER), for_s=6.0)
    rig.vehicle._body.instruct(HOLD)

    def said(state: dict[str, Any]) -> None:
        state["paused"] = False
        change(state)

    reword(rig, said)
    say(rig)
    return rig


def reports(**error: str) -> Change:
    return lambda state: state.update(errors=[{"errorType": "motorFault", **error}])


# --- a known word in another spelling --------------------------------------------------------------


@pytest.mark.parametrize("level", ["fatal", "Fatal", " FATAL "])
def test_an_error_at_a_level_in_another_spelling_is_a_problem(level: str) -> None:
    rig = standing(reports(errorLevel=level, errorDescription="axis 2"))
    assert rig.problems() == ["motorFault: axis 2"]
    assert f"an odd errorLevel: {level!r} is read as FATAL" in rig.notes


@pytest.mark.parametrize("mode", ["manual", "Manual"])
def test_a_mode_in_another_spelling_is_that_mode(mode: str) -> None:
    rig = standing(lambda state: state.update(operatingMode=mode))
    assert rig.problems() == ["its mode is MANUAL"]


def test_teach_in_is_spelled_in_two_ways_by_the_standard() -> None:
    for mode in ("TEACHIN", "TEACH_IN"):
        rig = standing(lambda state, mode=mode: state.update(operatingMode=mode))
        assert rig.problems() == [f"its mode is {mode}"]
        assert rig.notes == []


@pytest.mark.parametrize("stop", ["none", "None"])
def test_no_emergency_stop_in_another_spelling_is_none(stop: str) -> None:
    rig = Rig()
    reword(rig, lambda state: state.update(safetyState={"eStop": stop, "fieldViolation": False}))
    say(rig)
    rig.do(drive("west", "middle"), for_s=30.0)
    assert rig.problems() == []
    assert rig.heard[-1] == WayDone(order=1, node="middle")


def ends_with(rig: Rig, status: str) -> None:
    """Finished actions have this status."""

    def ended(state: dict[str, Any]) -> None:
        for action in state["actionStates"]:
            if action["actionStatus"] == "FINISHED":
                action["actionStatus"] = status

    reword(rig, ended)


@pytest.mark.parametrize("status", ["finished", "Finished"])
def test_an_action_with_an_end_in_another_spelling_has_ended(status: str) -> None:
    rig = Rig()
    rig.run(1.0)
    ends_with(rig, status)
    assert rig.do(PICK, for_s=60.0) == [ActionDone(order=5)]


# --- what nobody knows is told with the problem -----------------------------------------------------


def test_a_status_that_nobody_knows_is_told_with_the_action_that_does_not_end() -> None:
    rig = Rig()
    rig.run(1.0)
    ends_with(rig, "COMPLETED")
    rig.do(PICK, for_s=400.0)
    assert rig.problems() == ["its action pick has not ended for 300 s: its status is COMPLETED"]
    assert "an unknown actionStatus: VDA 5050 has no 'COMPLETED': such an action has not ended" in rig.notes


@pytest.mark.parametrize("level", ["ERROR", "WARNING", "URGENT", None])
def test_a_vehicle_that_stands_is_told_of_with_the_errors_that_it_reports(level: str | None) -> None:
    error = {"errorDescription": "axis 2"} | ({"errorLevel": level} if level else {})
    rig = standing(reports(**error))
    rig.run(120.0)
    (told,) = rig.problems()
    assert told.startswith("it has not come nearer to middle for ")
    assert told.endswith(": it stands; it reports: motorFault: axis 2")


def test_a_vehicle_that_stands_in_a_mode_that_nobody_knows_is_told_of_with_that_mode() -> None:
    rig = standing(lambda state: state.update(operatingMode="ECO"))
    rig.run(120.0)
    (told,) = rig.problems()
    assert told.endswith(": it stands; it reports: operatingMode ECO")
    assert "an unknown operatingMode: VDA 5050 has no 'ECO': it counts as AUTOMATIC" in rig.notes


# --- a charger that gives nothing -------------------------------------------------------------------


def charging(percent: float) -> tuple[Rig, dict[str, float]]:
    """A vehicle at its charger, with a level that a test sets."""
    rig, level = Rig(node="east", battery_frac=0.2), {"percent": percent}
    rig.run(1.0)
    reword(rig, lambda state: state["batteryState"].update(batteryCharge=level["percent"]))
    rig.do(Charge(order=3, charger="CH1"), for_s=250.0)
    return rig, level


def test_a_vehicle_whose_level_does_not_rise_at_its_charger_is_a_problem_until_it_rises() -> None:
    rig, level = charging(12.0)
    assert rig.problems() == []
    rig.run(200.0)
    (told,) = rig.problems()
    assert told.startswith("it is at its charger, and its battery level has not risen for ")
    assert rig.body.sense().about_problem.kind is ProblemKind.BATTERY
    level["percent"] = 14.0
    rig.run(60.0)
    assert isinstance(rig.heard[-1], ProblemCleared)


def test_a_battery_that_rises_slowly_or_is_nearly_full_is_no_problem() -> None:
    rig, level = charging(12.0)
    for _ in range(10):
        level["percent"] += 1.0
        rig.run(200.0)
    level["percent"] = 95.0
    rig.run(3_600.0)
    assert rig.problems() == []


# --- orders that are over where they began -----------------------------------------------------------


def liar(profile: Profile) -> Rig:
    """A vehicle that takes every order, says at once that it is at its end, and stands at west."""
    rig = Rig(profile)
    rig.run(1.0)
    orders: list[dict[str, Any]] = []
    hear = rig.vehicle.on_message

    def take(topic: str, data: bytes) -> None:
        if topic != "order":
            hear(topic, data)
            return
        orders.append(json.loads(data))
        rig.vehicle.say_state()

    def lie(state: dict[str, Any]) -> None:
        if orders:
            order, end = orders[-1], orders[-1]["nodes"][-1]
            state.update(orderId=order["orderId"], orderUpdateId=order["orderUpdateId"])
            state.update(lastNodeId=end["nodeId"], lastNodeSequenceId=end["sequenceId"])

    rig.vehicle.on_message = take  # type: ignore[method-assign]
    reword(rig, lie)
    return rig


def be_honest(rig: Rig) -> None:
    del rig.vehicle.on_message, rig.give


@pytest.mark.parametrize("profile", [PROFILE, FLOWING], ids=["steps", "updates"])
def test_a_vehicle_that_says_that_it_is_there_and_stands_has_passed_nothing_and_is_a_problem(
    profile: Profile,
) -> None:
    rig = liar(profile)
    rig.do(drive("west", "middle", "east"), for_s=40.0)
    assert rig.passed() == [("west", 0)]
    node, gap_m = ("middle", 10.0) if profile is PROFILE else ("east", 20.0)
    why = f"it says that its last node is {node}, and is {gap_m} m before it"
    assert rig.problems() == [f"it has ended 3 orders one after the other, and has not driven: {why}"]
    assert f"a last node ahead of its position: {why}" in rig.notes


def test_the_problem_of_a_vehicle_that_does_not_drive_ends_when_it_drives() -> None:
    rig = liar(PROFILE)
    rig.do(drive("west", "middle"), for_s=30.0)
    assert len(rig.problems()) == 1
    be_honest(rig)
    rig.do(drive("west", "middle", order=9), for_s=150.0)
    assert rig.heard[-1] == WayDone(order=9, node="middle")
    assert len(rig.of(ProblemCleared)) == 1


@pytest.mark.parametrize("profile", [PROFILE, FLOWING], ids=["steps", "updates"])
def test_a_node_that_is_reported_before_it_is_reached_is_passed_when_it_is_reached(profile: Profile) -> None:
    rig = Rig(profile)
    rig.run(1.0)
    places: list[tuple[str, float]] = []

    def ahead(state: dict[str, Any]) -> None:
        if state["nodeStates"]:
            state["lastNodeId"] = state["nodeStates"][0]["nodeId"]
            state["lastNodeSequenceId"] = state["nodeStates"][0]["sequenceId"]

    reword(rig, ahead)
    rig.body.attach(
        lambda report: (
            rig.heard.append(report),
            places.append((report.node, rig.body.sense().pose.x_m))
            if isinstance(report, NodePassed)
            else None,
        )[0]
    )
    rig.do(drive("west", "middle", "east"), for_s=120.0)
    assert rig.heard[-1] == WayDone(order=1, node="east")
    where = dict(places)
    assert where["middle"] > 7.5
    assert where["east"] > 17.5
    assert rig.problems() == []


# --- two vehicles of one name -------------------------------------------------------------------------


def with_a_double(rig: Rig) -> None:
    """From now on another vehicle, which stands at corner, sends its state after each one, under the same name."""
    give = rig.give
    corner = {"x": 30.0, "y": 10.0, "theta": 0.0, "mapId": "hall", "positionInitialized": True}

    def tell(topic: str, data: bytes) -> None:
        give(topic, data)
        if topic == "state":
            said = json.loads(data)
            said.update(headerId=said["headerId"] + 5000, orderId="", orderUpdateId=0, lastNodeId="corner")
            said.update(nodeStates=[], edgeStates=[], actionStates=[], driving=False, agvPosition=corner)
            give(topic, json.dumps(said).encode())

    rig.give = tell  # type: ignore[method-assign]


def test_two_vehicles_of_one_name_are_a_problem_until_there_is_one() -> None:
    rig = Rig()
    rig.run(1.0)
    with_a_double(rig)
    rig.do(drive(*TO_CORNER), for_s=100.0)
    told = "its states come from two senders: another vehicle or program uses its name"
    assert rig.problems() == [told]
    assert rig.of(WayDone) == []
    del rig.give
    rig.run(250.0)
    assert isinstance(
        next(each for each in reversed(rig.heard) if "Problem" in type(each).__name__), ProblemCleared
    )


def test_a_vehicle_that_is_restarted_and_carried_is_one_sender() -> None:
    rig, now = Rig(), {"x": 0.0, "less": 0}
    rig.run(1.0)

    def other(state: dict[str, Any]) -> None:
        state["agvPosition"]["x"] = now["x"]
        state["headerId"] -= now["less"]

    reword(rig, other)
    for number, x in enumerate((20.0, 0.0, 20.0), 1):
        now.update(x=x, less=1000 * number)
        say(rig, 40.0)
    assert rig.problems() == []
