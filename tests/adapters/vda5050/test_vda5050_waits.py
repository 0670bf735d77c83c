"""What the driver waits for has a bound, a reason and a way out: one word of a vehicle alone holds nothing up for ever."""

from __future__ import annotations

from typing import Any

import msgspec
import pytest
from field import reword, say
from vda_rig import FLOWING, PROFILE, Rig
from yard import HOLD, PICK, TO_CORNER, UNHOLD, drive

from dray.adapters.vda5050.profile import Profile
from dray.body import ActionDone, Charge, Drive, ProblemCleared, WayBlocked, WayDone, WayFree
from dray_sim.vda5050.misbehaviour import Misbehaviour

V3 = msgspec.structs.replace(PROFILE, version="3.0")


@pytest.mark.parametrize("status", ["RUNNING", "WAITING", "PAUSED", "INITIALIZING", "BLINKING"])
@pytest.mark.parametrize(
    ("profile", "where"), [(PROFILE, "actionStates"), (V3, "instantActionStates"), (V3, "actionStates")]
)
def test_an_action_of_somebody_else_that_never_ends_holds_no_order_up(
    profile: Any, where: str, status: str
) -> None:
    rig = Rig(profile)
    lamp = {"actionId": "hmi-1", "actionType": "beacon", "actionStatus": status}
    reword(rig, lambda said: said[where].append(lamp))
    say(rig)
    rig.do(drive("west", "middle", "east"), for_s=90.0)
    assert rig.heard[-1] == WayDone(order=1, node="east")
    assert rig.problems() == []


@pytest.mark.parametrize("profile", [PROFILE, FLOWING], ids=["steps", "updates"])
@pytest.mark.parametrize("status", ["WAITING", "RUNNING"])
def test_an_instant_action_of_ours_that_never_ends_holds_no_order_up(profile: Any, status: str) -> None:
    rig = Rig(profile)

    def stays(said: dict[str, Any]) -> None:
        for action in said["actionStates"]:
            if action["actionType"] in ("startPause", "stopPause", "stateRequest", "factsheetRequest"):
                action["actionStatus"] = status

    reword(rig, stays)
    rig.do(drive("west", "middle", "east"), for_s=5.0)
    rig.do(HOLD, for_s=20.0)
    rig.do(UNHOLD, for_s=120.0)
    assert rig.heard[-1] == WayDone(order=1, node="east")
    assert rig.problems() == []


def test_an_action_of_a_running_order_of_somebody_else_is_waited_for() -> None:
    rig = Rig()
    foreign = {"actionId": "x-1", "actionType": "pick", "actionStatus": "RUNNING"}

    def other(said: dict[str, Any]) -> None:
        if not said["orderId"]:
            said["orderId"] = "somebody"
            said["actionStates"].append(foreign)

    reword(rig, other)
    say(rig)
    rig.do(drive("west", "middle"), for_s=20.0)
    assert rig.orders() == []
    rig.run(90.0)
    assert rig.heard[-1] == WayDone(order=1, node="middle"), "a vehicle that stands is asked all the same"


@pytest.mark.parametrize("profile", [PROFILE, FLOWING], ids=["steps", "updates"])
def test_driving_that_speed_and_position_contradict_is_not_believed(profile: Any) -> None:
    rig = Rig(profile)
    reword(rig, lambda said: said.update(driving=True))
    say(rig)
    rig.do(drive(*TO_CORNER), for_s=250.0)
    assert rig.heard[-1] == WayDone(order=1, node="corner")
    assert rig.problems() == []


def test_driving_that_nothing_contradicts_is_believed() -> None:
    rig = Rig()

    def blind(said: dict[str, Any]) -> None:
        said["driving"] = True
        del said["agvPosition"], said["velocity"]

    reword(rig, blind)
    say(rig)
    rig.do(drive("west", "middle"), for_s=30.0)
    assert rig.orders() == []


def test_a_pick_is_done_although_a_lamp_is_on() -> None:
    rig = Rig()
    rig.run(1.0)
    lamp = {"actionId": "hmi-1", "actionType": "beacon", "actionStatus": "RUNNING"}
    reword(rig, lambda said: said["actionStates"].append(lamp))
    assert rig.do(PICK, for_s=60.0) == [ActionDone(order=5)]


# --- a vehicle that does not come nearer ---------------------------------------------------------

PAUSED = "it is paused, and not by its agent: let it go on at the vehicle (its pause button)"

OBSTACLES: dict[str, dict[str, Any]] = {
    "a field": {"safetyState": {"eStop": "NONE", "fieldViolation": True}},
    "a warning": {"errors": [{"errorType": "obstacleDetected", "errorLevel": "WARNING"}]},
    "of 3.0": {"errors": [{"errorType": "PATH_BLOCKED", "errorLevel": "URGENT"}]},
    "driving": {"safetyState": {"fieldViolation": True}, "driving": True},
}


def stuck(profile: Profile = FLOWING, **said: Any) -> Rig:
    """A vehicle that stops on its first lane by itself, and says something besides."""
    rig = Rig(profile)
    rig.do(drive(*TO_CORNER), for_s=6.0)
    rig.vehicle._body.instruct(HOLD)
    reword(rig, lambda state: state.update({"paused": False, **said}))
    say(rig)
    return rig


def let_go(rig: Rig) -> None:
    """It drives on, and says nothing besides any more."""
    del rig.give  # type: ignore[method-assign]
    rig.vehicle._body.instruct(UNHOLD)
    rig.vehicle.say_state()


@pytest.mark.parametrize("profile", [PROFILE, FLOWING], ids=["steps", "updates"])
def test_a_pause_button_on_the_vehicle_is_a_problem_by_name_until_it_is_pressed_again(profile: Any) -> None:
    rig = stuck(profile, paused=True)
    rig.run(600.0)
    assert rig.problems() == [PAUSED]
    assert rig.instant("stopPause") == [], "whoever has paused it knows why"
    let_go(rig)
    rig.run(150.0)
    assert ProblemCleared() in rig.heard
    assert rig.heard[-1] == WayDone(order=1, node="corner")
    assert len(rig.problems()) == 1


def test_paused_of_a_vehicle_that_drives_is_not_believed() -> None:
    rig = Rig()
    reword(rig, lambda state: state.update(paused=True))
    rig.do(drive("west", "middle"), for_s=0.0)
    rig.body.instruct(UNHOLD)
    rig.run(60.0)
    assert rig.heard[-1] == WayDone(order=1, node="middle")
    assert rig.problems() == []


@pytest.mark.parametrize("what", OBSTACLES)
def test_what_it_stands_before_is_said_as_a_blocked_lane_once_and_as_free_when_it_is_gone(what: str) -> None:
    rig = stuck(**OBSTACLES[what])
    rig.run(600.0)
    assert rig.of(WayBlocked) == [WayBlocked(order=1, start="west", end="middle", entered=True)]
    assert rig.of(WayFree) == []
    assert rig.problems() == []
    let_go(rig)
    rig.run(150.0)
    assert rig.of(WayFree) == [WayFree(order=1, start="west", end="middle")]
    assert rig.heard[-1] == WayDone(order=1, node="corner")


def test_an_agent_that_goes_on_before_it_is_gone_is_told_again() -> None:
    rig = stuck(**OBSTACLES["a field"])
    rig.run(60.0)
    rig.do(drive(*TO_CORNER[1:], order=2), for_s=60.0)
    assert [said.order for said in rig.of(WayBlocked)] == [1, 2]
    assert rig.of(WayFree) == []


def test_a_field_that_is_hurt_for_a_moment_blocks_nothing() -> None:
    rig = stuck(**OBSTACLES["a field"])
    rig.run(3.0)
    let_go(rig)
    rig.run(150.0)
    assert rig.of(WayBlocked) == []
    assert rig.heard[-1] == WayDone(order=1, node="corner")


@pytest.mark.parametrize(
    ("said", "why"),
    [
        ({}, "it stands, and does not say why"),
        ({"driving": True}, "it says that it drives, at speed 0"),
        (
            {"driving": True, "velocity": {"vx": 0.5, "vy": 0.0}},
            "it says that it drives, and its position does not change",
        ),
    ],
    ids=["silent", "driving", "frozen"],
)
def test_a_vehicle_that_does_not_come_nearer_is_a_problem_whatever_its_flags_say(
    said: dict[str, Any], why: str
) -> None:
    rig = stuck(**said)
    rig.run(40.0)
    assert rig.problems() == []
    rig.run(560.0)
    assert rig.problems() == [f"it has not come nearer to middle for 75 s: {why}"]
    let_go(rig)
    rig.run(150.0)
    assert rig.heard[-1] == WayDone(order=1, node="corner")
    assert rig.body.sense().problem == ""


def test_a_vehicle_that_is_held_is_not_missed() -> None:
    rig = Rig(FLOWING)
    rig.do(drive(*TO_CORNER), for_s=6.0)
    rig.do(HOLD, for_s=600.0)
    assert rig.problems() == []
    rig.do(UNHOLD, for_s=150.0)
    assert rig.heard[-1] == WayDone(order=1, node="corner")
    assert rig.problems() == []


# --- a word that flickers ------------------------------------------------------------------------

FLICKERS: dict[str, dict[str, Any]] = {
    "an emergency stop": {"safetyState": {"eStop": "AUTOACK"}},
    "an error": {"errors": [{"errorType": "motor", "errorLevel": "FATAL"}]},
    "an error with a figure": {"errors": [{"errorType": "motor", "errorLevel": "FATAL"}]},
    "a lost position": {"agvPosition": {"x": 0, "y": 0, "positionInitialized": False}},
}


@pytest.mark.parametrize("what", FLICKERS)
def test_a_word_that_comes_and_goes_each_second_is_one_problem(what: str) -> None:
    rig = Rig()
    rig.run(1.0)
    moment = 0

    def flicker(state: dict[str, Any]) -> None:
        if moment % 2:
            state.update(FLICKERS[what])
        if moment % 2 and what.endswith("figure"):
            state["errors"] = [{**FLICKERS[what]["errors"][0], "errorDescription": f"{moment} A"}]

    reword(rig, flicker)
    for moment in range(120):  # noqa: B007 - `flicker` reads it
        say(rig, 1.0)
    assert len(rig.problems()) == 2, "the first end of a problem is told at once"
    del rig.give  # type: ignore[method-assign]
    say(rig, 5.0)
    assert rig.body.sense().problem
    say(rig, 10.0)
    assert rig.heard[-1] == ProblemCleared()


def test_a_figure_that_changes_while_a_problem_stays_is_told_once() -> None:
    rig = Rig()
    rig.run(1.0)
    amperes = 0

    def hot(state: dict[str, Any]) -> None:
        error = {"errorType": "motor", "errorLevel": "FATAL", "errorDescription": f"{amperes} A"}
        state["errors"] = [error]

    reword(rig, hot)
    for amperes in range(60):  # noqa: B007 - `hot` reads it
        say(rig, 1.0)
    assert len(rig.problems()) == 1


# --- what does not end ---------------------------------------------------------------------------


def test_a_cancel_that_is_never_finished_is_over_when_nothing_is_left_to_do() -> None:
    rig = Rig()
    rig.run(1.0)

    def stays(state: dict[str, Any]) -> None:
        for action in state["actionStates"]:
            if action["actionType"] == "cancelOrder":
                action["actionStatus"] = "RUNNING"

    reword(rig, stays)
    rig.do(PICK, for_s=3.0)
    rig.do(drive("west", "middle", order=6), for_s=90.0)
    assert rig.heard[-1] == WayDone(order=6, node="middle")
    assert rig.problems() == []


def test_a_vehicle_that_goes_on_with_a_cancelled_order_is_a_problem_by_name() -> None:
    rig = Rig()
    rig.run(1.0)

    def stays(state: dict[str, Any]) -> None:
        for action in state["actionStates"]:
            if action["actionType"] in ("cancelOrder", "pick"):
                action["actionStatus"] = "RUNNING"

    reword(rig, stays)
    rig.do(PICK, for_s=3.0)
    rig.do(drive("west", "middle", order=6), for_s=120.0)
    assert rig.problems() == ["it goes on with an order that was cancelled"]
    assert "cancelOrder stays RUNNING, and is not waited for any longer" in rig.notes


def test_an_action_of_an_earlier_order_that_never_ends_is_a_problem_by_name_and_ends_with_it() -> None:
    rig = Rig()
    old = {"actionId": "ATV1-0-3-a", "actionType": "pick", "actionStatus": "RUNNING"}
    reword(rig, lambda state: state["actionStates"].append(old))
    say(rig)
    rig.do(drive("west", "middle"), for_s=55.0)
    assert rig.problems() == []
    rig.run(545.0)
    assert rig.problems() == ["it takes no order: its action pick is RUNNING, of an earlier order"]
    assert rig.orders() == []
    old["actionStatus"] = "FAILED"
    say(rig, 60.0)
    assert rig.heard[-1] == WayDone(order=1, node="middle")


def test_a_pick_that_never_ends_is_a_problem_by_name() -> None:
    rig = Rig(msgspec.structs.replace(PROFILE, acting_s=100.0))
    rig.run(1.0)

    def stays(state: dict[str, Any]) -> None:
        for action in state["actionStates"]:
            if action["actionType"] == "pick":
                action["actionStatus"] = "RUNNING"

    reword(rig, stays)
    rig.do(PICK, for_s=95.0)
    assert rig.problems() == []
    rig.run(505.0)
    assert rig.problems() == ["its action pick has not ended for 100 s"]
    del rig.give  # type: ignore[method-assign]
    say(rig, 5.0)
    assert ActionDone(order=5) in rig.heard
    assert rig.heard[-1] == ProblemCleared()


def test_actions_of_somebody_else_are_told_once_each() -> None:
    rig = Rig()
    lamp = {"actionId": "hmi-1", "actionType": "beacon", "actionStatus": "RUNNING"}
    reword(rig, lambda said: said["actionStates"].append(lamp))
    rig.do(drive("west", "middle"), for_s=90.0)
    told = "an action of somebody else is RUNNING: beacon; no order waits for it"
    assert rig.notes.count(told) == 1


def test_what_it_waits_for_is_one_line_with_its_age_and_its_end_and_in_the_log_once() -> None:
    rig = stuck(paused=True)
    rig.run(600.0)
    line = rig.body.control.waits_for(rig.clock.now_s())
    assert line.startswith("waits for 59")
    assert line.endswith(f" s: {PAUSED} (until that is gone)")
    assert [note.partition(": ")[2] for note in rig.notes] == [f"{PAUSED} (until that is gone)"]
    idle = Rig()
    idle.run(300.0)
    assert idle.body.control.waits_for(300.0) == ""
    assert idle.notes == []


def test_its_agent_is_told_what_it_waits_for_since_when_and_what_would_end_it() -> None:
    rig = stuck(paused=True)
    begun_s = rig.clock.now_s()
    rig.run(60.0)
    wait = rig.body.sense().wait
    assert wait is not None
    assert (wait.what, wait.until) == (PAUSED, "that is gone")
    assert abs(wait.since_s - begun_s) < 15.0
    idle = Rig()
    idle.run(60.0)
    assert idle.body.sense().wait is None


def test_each_thing_that_is_waited_for_is_named_in_the_line() -> None:
    rig = Rig(quirks=Misbehaviour(ignores_first_orders=3, cancel_s=5.0))
    rig.run(1.0)
    wait = rig.body.control.waits_for
    rig.do(PICK, for_s=3.0)
    assert "does not show order ATV1-1-1" in wait(rig.clock.now_s())
    rig.run(6.0)
    assert "its action pick" in wait(rig.clock.now_s())
    rig.do(drive("west", "middle", order=6), for_s=1.0)
    assert "order ATV1-1-1 is cancelled" in wait(rig.clock.now_s())
    rig.run(8.0)
    assert "it drives to middle" in wait(rig.clock.now_s())
    rig.do(HOLD, for_s=1.0)
    assert "its agent holds it" in wait(rig.clock.now_s())


def test_a_vehicle_of_3_0_is_told_to_clear_its_ended_instant_actions() -> None:
    rig = Rig(V3)
    rig.run(1.0)
    kinds = {
        "clearInstantActions": "INSTANT_ACTION_STATES_FULL",
        "clearZoneActions": "ZONE_ACTION_STATES_FULL",
    }
    for kind, error in kinds.items():
        rig.vehicle.condition.errors = [(error, "URGENT", "", {})]
        say(rig, 20.0)
        assert len({action["actionId"] for action in rig.instant(kind)}) == 1, kind
        rig.vehicle.condition.errors = []
        say(rig, 100.0)
    assert rig.problems() == []
    assert len(rig.vehicle.condition.instant) == 2


def test_many_ended_instant_actions_are_cleared_and_2_x_is_told_nothing() -> None:
    for profile, count in ((V3, 1), (PROFILE, 0)):
        rig = Rig(profile)
        where = "instantActionStates" if profile is V3 else "actionStates"
        ended = [
            {"actionId": f"hmi-{i}", "actionType": "horn", "actionStatus": "FINISHED"} for i in range(60)
        ]
        reword(rig, lambda said, where=where, ended=ended: said[where].extend(ended))
        rig.run(31.0)
        assert len({action["actionId"] for action in rig.instant("clearInstantActions")}) == count


@pytest.mark.parametrize("profile", [PROFILE, FLOWING], ids=["steps", "updates"])
def test_a_last_node_that_is_stale_counts_for_less_than_the_place_where_it_stands(profile: Any) -> None:
    rig = Rig(profile)
    reword(rig, lambda said: said.update(lastNodeId="west", lastNodeSequenceId=0))
    rig.do(drive("west", "middle", "east"), for_s=120.0)
    assert rig.heard[-1] == WayDone(order=1, node="east")
    assert rig.problems() == []
    assert len([note for note in rig.notes if "says that its last node is west" in note]) == 1


def test_an_order_that_ends_elsewhere_is_not_taken_for_done() -> None:
    rig = Rig()
    rig.do(drive("west", "middle"), for_s=6.0)
    order = rig.vehicle.order
    assert order is not None
    order.give_up()
    rig.vehicle._body.power_off()
    rig.vehicle._body.power_on()
    say(rig, 4.0)
    assert rig.of(WayDone) == []


def test_a_charge_that_is_not_stopped_is_named_and_not_waited_for_for_ever() -> None:
    rig = Rig(battery_frac=0.5, node="east")
    rig.run(1.0)
    rig.do(Charge(order=1, charger="CH1"), for_s=20.0)

    def stays(state: dict[str, Any]) -> None:
        state["batteryState"]["charging"] = True
        for action in state["actionStates"]:
            if action["actionType"] == "stopCharging":
                action["actionStatus"] = "RUNNING"

    reword(rig, stays)
    rig.do(Drive(order=2, nodes=("east", "north"), released=2), for_s=30.0)
    assert "it charges (until it does not, or stopCharging has ended)" in rig.body.control.waits_for(
        rig.clock.now_s()
    )
    rig.run(90.0)
    assert rig.heard[-1] == WayDone(order=2, node="north")
