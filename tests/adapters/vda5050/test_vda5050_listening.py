"""What the driver believes of what a vehicle says (behaviours 1 to 5, 21, 22, 24 of docs/vehicles.md)."""

from __future__ import annotations

import json
from typing import Any

import msgspec
import pytest
from vda_rig import PROFILE, Rig
from yard import PICK, TO_CORNER, drive

from dray.body import WORDS_MAX, ActionDone, NodePassed, ProblemCleared, VehicleState, WayDone
from dray.messages.problem import Problem, ProblemKind
from dray_sim.vda5050.misbehaviour import Misbehaviour

AROUND = ("west", "middle", "east")


def state_of(rig: Rig, **changes: Any) -> bytes:
    """The newest state that the vehicle has said, with some fields changed."""
    return json.dumps({**rig.said("state", "it")[-1], **changes}).encode()


def test_01_it_asks_for_a_state_at_its_start_and_believes_what_the_broker_has_kept() -> None:
    rig = Rig(quirks=Misbehaviour(silent_until_asked=True), linked=False)
    old = json.loads(rig.retained["connection"]) | {"headerId": 0, "timestamp": "2001-01-01T00:00:00.00Z"}
    rig.retained["connection"] = json.dumps(old).encode()
    rig.run(40.0)
    assert not rig.body.control.is_known
    assert rig.body.control.why_unknown == "the broker has not answered yet"
    rig.link()
    rig.run(1.0)
    assert rig.body.sense().node == "west"
    assert [action["actionType"] for said in rig.said("instantActions") for action in said["actions"]][
        :2
    ] == [
        "stateRequest",
        "factsheetRequest",
    ]


def test_01_a_will_that_the_broker_has_kept_is_believed_whatever_its_time() -> None:
    rig = Rig()
    rig.run(1.0)
    rig.give("connection", b'{"headerId": 0, "timestamp": "1970", "connectionState": "CONNECTIONBROKEN"}')
    rig.is_up = False  # Nothing comes from it any more.
    rig.run(10.0)
    assert rig.problems() == ["the vehicle is not there: CONNECTIONBROKEN"]


@pytest.mark.parametrize("word", ["OFFLINE", "CONNECTION_BROKEN", "HIBERNATING"])
def test_02_states_that_come_are_life_whatever_the_connection_says(word: str) -> None:
    rig = Rig(quirks=Misbehaviour(says_offline=True))
    rig.run(1.0)
    rig.give("connection", json.dumps({"connectionState": word}).encode())
    rig.do(drive(*AROUND), for_s=60.0)
    assert rig.of(WayDone) == [WayDone(order=1, node="east")]
    assert rig.problems() == []


def test_02_a_vehicle_without_a_connection_topic_is_there_when_it_speaks() -> None:
    rig = Rig(linked=False)
    del rig.retained["connection"]
    rig.link()
    rig.do(drive(*AROUND), for_s=60.0)
    assert rig.of(WayDone)
    assert rig.problems() == []
    rig.is_up = False
    rig.run(200.0)
    assert rig.problems() == ["the vehicle says nothing, for 66 s and more"]
    rig.is_up = True
    rig.run(31.0)
    assert rig.heard[-1] == ProblemCleared()


def test_03_doubled_and_reordered_states_change_nothing() -> None:
    plain = Rig()
    plain.do(drive(*AROUND), for_s=60.0)
    rig = Rig(quirks=Misbehaviour(doubles_states=True))
    old: list[bytes] = []
    give = rig.give

    def reorder(topic: str, data: bytes) -> None:
        give(topic, data)
        if topic == "state":
            old.append(data)
            for late in old[-6:-1]:
                give(topic, late)

    rig.give = reorder  # type: ignore[method-assign]
    rig.do(drive(*AROUND), for_s=60.0)
    assert rig.heard == plain.heard
    assert rig.body.control.view.odd["an older state"] > 3
    assert rig.body.control.view.odd["a doubled state"] > 3


def test_03_a_vehicle_that_was_restarted_counts_its_messages_anew() -> None:
    rig = Rig()
    rig.do(drive(*TO_CORNER), for_s=120.0)
    assert rig.said("state", "it")[-1]["headerId"] > 20
    rig.vehicle.restart()
    rig.run(2.0)
    assert rig.said("state", "it")[-1]["headerId"] < 5
    rig.vehicle.condition.mode = "MANUAL"
    rig.vehicle.say_state()
    rig.run(1.0)
    assert rig.problems() == ["its mode is MANUAL"]


SPOILT = (
    b"",
    b"{",
    b"\xff\xfe\x00",
    b"[]",
    b"null",
    b"17",
    b'"state"',
    b'{"agvPosition": {"x": NaN, "y": Infinity, "theta": null, "mapId": 7}}',
    b'{"orderId": null, "errors": [null, 3, {"errorLevel": "HUGE"}], "operatingMode": "ASLEEP"}',
    b'{"nodeStates": "none", "actionStates": {"a": 1}, "safetyState": []}',
    b'{"batteryState": {"batteryCharge": 1e999}, "driving": "perhaps"}',
    b"[" * 100_000,
    b'{"orderId": "' + b"x" * 2**20 + b'"}',
)


def test_04_what_is_no_message_is_counted_and_ends_nothing() -> None:
    rig = Rig()
    rig.run(1.0)
    rig.body.instruct(drive(*TO_CORNER))
    for number in range(120):
        rig.run(1.0)
        for topic in ("state", "visualization", "connection", "factsheet", "nothing"):
            spoilt = SPOILT[number % len(SPOILT)]
            if topic != "state" or not spoilt.startswith(b"{"):
                rig.give(topic, spoilt)
    assert rig.of(WayDone) == [WayDone(order=1, node="corner")]
    assert sum(rig.body.control.view.odd.values()) > 300


@pytest.mark.parametrize("spoilt", SPOILT)
def test_04_no_state_however_odd_ends_the_driver(spoilt: bytes) -> None:
    rig = Rig()
    rig.run(1.0)
    rig.give("state", spoilt)
    assert rig.body.sense().node == "west"


def test_04_fields_of_odd_types_and_nulls_are_read_as_far_as_they_go() -> None:
    rig = Rig(quirks=Misbehaviour(numbers_as_text=True))
    rig.do(drive(*AROUND), for_s=60.0)
    assert rig.of(WayDone) == [WayDone(order=1, node="east")]
    assert rig.problems() == []


@pytest.mark.parametrize("off_s", [-86_400.0 * 365, 86_400.0 * 365 * 30])
def test_05_the_clock_of_the_vehicle_does_not_matter(off_s: float) -> None:
    plain = Rig()
    rig = Rig(quirks=Misbehaviour(clock_off_s=max(off_s, 0.0) or 1.0, no_zone=True))
    for each in (plain, rig):
        each.do(drive(*AROUND), for_s=60.0)
    assert rig.heard == plain.heard


STOPPED = {
    "fatal": ({"errors": [{"errorType": "laser", "errorLevel": "FATAL"}]}, "laser"),
    "critical": ({"errors": [{"errorType": "x", "errorLevel": "CRITICAL", "errorDescription": "y"}]}, "x: y"),
    "emergency stop": ({"safetyState": {"eStop": "MANUAL"}}, "emergency stop (MANUAL)"),
    "emergency stop of 3.0": ({"safetyState": {"activeEmergencyStop": "REMOTE"}}, "emergency stop (REMOTE)"),
    "manual": ({"operatingMode": "MANUAL"}, "its mode is MANUAL"),
    "service": ({"operatingMode": "SERVICE"}, "its mode is SERVICE"),
    "lost": (
        {"agvPosition": {"x": 0, "y": 0, "theta": 0, "mapId": "hall", "positionInitialized": False}},
        "it does not know where it is: not localised",
    ),
    "lost, of 3.0": (
        {"mobileRobotPosition": {"x": 0, "y": 0, "localized": False}, "agvPosition": None},
        "it does not know where it is: not localised",
    ),
}


@pytest.mark.parametrize("why", STOPPED)
def test_21_what_keeps_it_from_going_on_is_a_problem_until_it_is_gone(why: str) -> None:
    rig = Rig()
    rig.run(1.0)
    changes, reason = STOPPED[why]
    rig.give("state", state_of(rig, headerId=1000, **changes))
    rig.run(0.1)
    assert rig.problems() == [reason]
    assert rig.body.sense().problem == reason
    rig.do(drive("west", "middle"), for_s=0.2)
    assert rig.orders() == []
    rig.give("state", state_of(rig, headerId=1001))
    rig.run(0.1)
    assert ProblemCleared() in rig.heard
    rig.run(40.0)
    assert rig.of(WayDone)


KINDS = {
    "localizationError": ProblemKind.LOST_POSITION,
    "LASER_DIRTY": ProblemKind.SENSOR,
    "forkJammed": ProblemKind.LOAD,
    "E-17": ProblemKind.DRIVE,
    "E-18": ProblemKind.UNKNOWN,
}


@pytest.mark.parametrize("error", KINDS)
def test_21_the_kind_of_a_problem_follows_from_the_profile_or_from_the_words_of_its_error(error: str) -> None:
    rig = Rig(msgspec.structs.replace(PROFILE, problems={"E-17": ProblemKind.DRIVE}))
    rig.run(1.0)
    rig.give("state", state_of(rig, headerId=1000, errors=[{"errorType": error, "errorLevel": "FATAL"}]))
    assert rig.body.sense().about_problem == Problem(kind=KINDS[error], needs_person=True)


@pytest.mark.parametrize("level", ["WARNING", "URGENT", "SOMETHING"])
def test_21_what_it_goes_on_with_is_no_problem(level: str) -> None:
    rig = Rig()
    rig.vehicle.condition.errors.append(("lamp", level, "is broken", {}))
    rig.do(drive("west", "middle"), for_s=40.0)
    assert rig.problems() == []
    assert rig.of(WayDone)


def test_22_without_a_last_node_it_is_placed_by_its_pose() -> None:
    rig = Rig(quirks=Misbehaviour(no_last_node=True), node="middle")
    rig.run(1.0)
    assert rig.body.sense().node == "middle"
    assert rig.do(drive("middle", "east"), for_s=40.0)[-1] == WayDone(order=1, node="east")


def test_22_a_pose_that_is_on_no_lane_or_on_another_map_places_nothing() -> None:
    rig = Rig(linked=False)
    rig.link()
    far = {"agvPosition": {"x": 15.0, "y": 7.0, "theta": 0, "mapId": "hall"}, "lastNodeId": ""}
    rig.give("state", state_of(rig, headerId=50, **far))
    assert not rig.body.control.is_known
    assert rig.body.control.why_unknown == "it stands on no lane of the plant: (15.0, 7.0)"
    other = {"agvPosition": {"x": 0.0, "y": 0.0, "theta": 0, "mapId": "cellar"}, "lastNodeId": ""}
    rig = Rig(linked=False)
    rig.link()
    rig.give("state", state_of(rig, headerId=50, **other))
    assert not rig.body.control.is_known
    assert rig.body.control.why_unknown == "it is on a map that is not hall"


def test_22_a_pose_beats_a_last_node_from_which_it_was_carried_away() -> None:
    rig = Rig()
    rig.run(1.0)
    rig.sim.place_at("north")
    rig.vehicle.say_state()
    rig.run(1.0)
    assert rig.vehicle.condition.last_node == "west"
    assert rig.body.sense().node == "west", "a jump is doubted first"
    rig.run(8.0)
    assert rig.body.sense().node == "north"


def pick(rig: Rig) -> list[Any]:
    return rig.do(PICK, for_s=60.0)


def test_24_the_load_is_known_where_the_vehicle_does_not_tell_it() -> None:
    rig = Rig(quirks=Misbehaviour(no_loads=True))
    rig.run(1.0)
    assert pick(rig)[-1] == ActionDone(order=5)
    assert (rig.body.sense().load, rig.body.sense().load_quantity) == ("shaft", 20)
    rig.begin_life()
    rig.run(1.0)
    assert (rig.body.sense().load, rig.body.sense().load_quantity) == ("shaft", 20)


def test_24_a_difference_is_a_problem_until_people_have_seen_to_it() -> None:
    rig = Rig()
    rig.run(1.0)
    pick(rig)
    rig.sim.recover_load()
    for _ in range(5):
        rig.vehicle.say_state()
        rig.run(1.0)
    assert rig.problems() == [
        "tells that nothing is on board, and 20 shaft should be: see to it, then MANUAL and back"
    ]
    for mode in ("MANUAL", "AUTOMATIC"):
        rig.vehicle.condition.mode = mode
        rig.vehicle.say_state()
        rig.run(1.0)
    assert rig.heard[-1] == ProblemCleared()
    assert rig.body.sense().load == ""


def test_24_the_type_of_a_load_counts_where_the_profile_says_so() -> None:
    rig = Rig(msgspec.structs.replace(PROFILE, load="type"))
    rig.run(1.0)
    pick(rig)
    rig.vehicle.condition.loads = [{"loadType": "seal"}]
    for _ in range(5):
        rig.vehicle.say_state()
        rig.run(1.0)
    assert "tells that seal is on board, and 20 shaft should be" in rig.problems()[0]


def test_poses_that_come_in_visualization_alone_are_poses() -> None:
    rig = Rig(quirks=Misbehaviour(no_pose_in_state=True))
    rig.do(drive("west", "middle"), for_s=6.0)
    assert 2.0 < rig.body.sense().pose.x_m < 8.0
    rig.run(20.0)
    assert [report.node for report in rig.of(NodePassed)] == ["west", "middle"]


def fatal(words: str) -> list[dict[str, str]]:
    return [{"errorType": "motorFailure", "errorLevel": "FATAL", "errorDescription": words}]


def test_words_that_nobody_can_encode_and_whole_pages_are_told_all_the_same() -> None:
    rig = Rig()
    rig.run(1.0)
    rig.give("state", state_of(rig, errors=fatal("jammed \ud800 at\u202e the\u2069 lift " + "x" * 2000)))
    rig.run(0.1)
    [reason] = rig.problems()
    assert "jammed \ufffd at\ufffd the\ufffd lift" in reason
    assert reason.endswith("x…")
    assert len(reason) == WORDS_MAX
    assert rig.body.sense().problem == reason
    assert msgspec.json.decode(msgspec.json.encode(rig.body.sense()), type=VehicleState).problem == reason


@pytest.mark.parametrize(("x", "y"), [(2e6, 1.0), (1.0, -2e6), (1e300, -1e300)])
def test_a_position_that_cannot_be_is_a_problem_and_the_last_one_stays(x: float, y: float) -> None:
    rig = Rig()
    rig.run(1.0)
    before = rig.body.sense().pose
    position = rig.said("state", "it")[-1]["agvPosition"] | {"x": x, "y": y}
    rig.give("state", state_of(rig, agvPosition=position))
    rig.run(0.1)
    assert rig.body.sense().pose == before
    [reason] = rig.problems()
    assert reason.startswith("its position cannot be: x ")
    rig.run(40.0)  # It says where it is again.
    assert rig.of(ProblemCleared) == [ProblemCleared()]


@pytest.mark.parametrize("field", ["headerId", "driving"])
def test_half_a_character_beside_an_odd_number_ends_no_driver(field: str) -> None:
    rig = Rig()
    rig.run(1.0)
    said = {**rig.said("state", "it")[-1], field: "\ud800", "velocity": {"vx": float("nan")}}
    rig.give("state", json.dumps(said).encode())
    rig.vehicle.say_state()
    rig.do(drive("west", "middle"), for_s=60.0)
    assert rig.heard[-1] == WayDone(order=1, node="middle")
