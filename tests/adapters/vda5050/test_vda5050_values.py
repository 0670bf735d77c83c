"""Values that cannot be are as good as none: nothing is clamped in silence, and people are told once."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import Any

import msgspec
import pytest
from field import reword, say
from vda_rig import PROFILE, Rig
from yard import PICK, drive

from dray.adapters.vda5050.control.doubts import TOLD_MAX, Doubts
from dray.adapters.vda5050.profile import Profile
from dray.adapters.vda5050.wire.timestamps import read_timestamp
from dray.body import ActionDone, Charge, NodePassed, WayDone
from dray_sim.vda5050.misbehaviour import Misbehaviour

FRACTION = msgspec.structs.replace(PROFILE, battery_scale="fraction")
ABSENT = object()


def with_battery(value: Any, profile: Profile = PROFILE) -> Rig:
    """A vehicle that says this of its battery from its first state on."""
    rig = Rig(profile)

    def change(said: dict[str, Any]) -> None:
        if value is ABSENT:
            del said["batteryState"]
        else:
            said["batteryState"]["batteryCharge"] = value

    reword(rig, change)
    say(rig)
    return rig


@pytest.mark.parametrize(
    ("value", "told"),
    [
        (0.85, "a doubtful battery: 0.85 may be of 1, not of 100; then battery_scale: fraction is right"),
        (1.0, "a doubtful battery: 1 may be of 1, not of 100; then battery_scale: fraction is right"),
        (0, "a doubtful battery: 0 may be of 1, not of 100; then battery_scale: fraction is right"),
        (-1, "an odd battery: -1 is not between 0 and 100"),
        (255, "an odd battery: 255 is not between 0 and 100"),
        (float("nan"), "no battery: it does not say how full it is"),
        (float("inf"), "no battery: it does not say how full it is"),
        (None, "no battery: it does not say how full it is"),
        (ABSENT, "no battery: it does not say how full it is"),
    ],
)
def test_a_level_that_cannot_be_is_not_known_and_told_once(value: Any, told: str) -> None:
    rig = with_battery(value)
    assert rig.body.sense().battery_frac == pytest.approx(0.5, abs=0.001)
    assert rig.body.sense().battery_reckoned
    rig.do(drive("west", "middle", "east"), for_s=90.0)
    assert rig.heard[-1] == WayDone(order=1, node="east")
    assert rig.notes.count(f"{told}; its level is reckoned by time and metres") == 1
    assert 0.47 < rig.body.sense().battery_frac < 0.495, "time and metres take from it"
    assert all(0.47 < report.battery_frac <= 0.5 for report in rig.of(NodePassed))
    assert rig.body.control.view.odd


@pytest.mark.parametrize(
    ("profile", "value", "frac"),
    [
        (PROFILE, 85.0, 0.85),
        (PROFILE, "85", 0.85),
        (FRACTION, 0.85, 0.85),
        (FRACTION, 1.0, 1.0),
        (PROFILE, 100.4, 1.0),
    ],
)
def test_a_level_is_taken_by_the_scale_of_the_profile(profile: Any, value: Any, frac: float) -> None:
    sensed = with_battery(value, profile).body.sense()
    assert (sensed.battery_frac, sensed.battery_reckoned) == (frac, False)


def test_percent_under_the_scale_of_a_fraction_is_not_believed() -> None:
    rig = with_battery(85.0, FRACTION)
    assert rig.body.sense().battery_frac == pytest.approx(0.5, abs=0.001)
    assert rig.notes[0].startswith("an odd battery: 85 is not between 0 and 1;")


def test_one_odd_word_in_between_changes_no_level_and_a_low_one_after_a_high_one_is_believed() -> None:
    rig = Rig()
    level: Any = 60.0
    reword(rig, lambda said: said["batteryState"].update(batteryCharge=level))
    for level, frac in ((60.0, 0.6), (255, 0.6), (None, 0.6), (59.0, 0.59), (0.5, 0.005)):  # noqa: B007
        say(rig, 1.0)
        assert rig.body.sense().battery_frac == pytest.approx(frac, abs=0.001)


def test_a_battery_that_does_not_tell_is_charged_by_time() -> None:
    rig = Rig(node="east", battery_frac=0.4)
    reword(rig, lambda said: said.pop("batteryState"))
    say(rig)
    rig.do(Charge(order=1, charger="CH1"), for_s=40.0)
    assert rig.of(ActionDone) == []
    assert rig.body.sense().battery_frac > 0.51
    rig.run(4 * 3600.0)
    assert rig.of(ActionDone) == [ActionDone(order=1)]


@pytest.mark.parametrize(("theta", "told"), [(90.0, True), (-180.0, True), (6.2, False), (-3.1, False)])
def test_a_theta_of_more_than_a_turn_is_told(theta: float, told: bool) -> None:
    rig = Rig()
    reword(rig, lambda said: said["agvPosition"].update(theta=theta))
    say(rig)
    assert [note.partition(" rad")[0] for note in rig.notes] == ([f"an odd theta: {theta:g}"] if told else [])
    rig.do(drive("west", "middle"), for_s=60.0)
    assert rig.heard[-1] == WayDone(order=1, node="middle")


def test_a_speed_in_other_units_is_told_and_not_taken() -> None:
    rig = Rig()
    reword(rig, lambda said: said["velocity"].update(vx=1000.0 * said["velocity"]["vx"]))
    rig.do(drive("west", "middle"), for_s=5.0)
    assert rig.body.sense().speed_mps < 2.0
    assert any(note.startswith("an odd speed: ") and "m/s is no speed of type" in note for note in rig.notes)
    rig.run(60.0)
    assert rig.heard[-1] == WayDone(order=1, node="middle")


def test_a_negative_distance_since_the_last_node_is_told_and_not_taken() -> None:
    rig = Rig(node="middle")
    reword(rig, lambda said: said.update(distanceSinceLastNode=-3.0))
    rig.do(drive("middle", "east"), for_s=60.0)
    assert rig.heard[-1] == WayDone(order=1, node="east")
    assert any(note.startswith("an odd distanceSinceLastNode: -3 m") for note in rig.notes)


def test_a_distance_since_the_last_node_that_is_longer_than_any_lane_is_told_and_not_taken() -> None:
    rig = Rig()
    rig.run(1.0)
    reword(rig, lambda said: said.update(distanceSinceLastNode=400.0))
    say(rig)
    # It stands at west, and is not on the lane behind it.
    assert rig.do(PICK, for_s=60.0) == [ActionDone(order=5)]
    assert "an odd distanceSinceLastNode: 400 m is longer than any lane; mm, or since its start?" in rig.notes


def test_a_negative_sequence_number_is_none() -> None:
    rig = Rig(msgspec.structs.replace(PROFILE, updates=True, base_m=100.0))
    reword(rig, lambda said: said.update(lastNodeSequenceId=-2))
    rig.do(drive("west", "middle", "west"), for_s=2.0)
    assert rig.passed() == [("west", 0)], "it has not come back before it has left"


def test_a_pose_that_jumps_and_comes_back_is_told_once_and_not_taken() -> None:
    rig = Rig(msgspec.structs.replace(PROFILE, updates=True, base_m=100.0))
    number = 0

    def jump(said: dict[str, Any]) -> None:
        nonlocal number
        number += 1
        if number % 2:
            said["agvPosition"]["x"] += 500.0

    say(rig)
    reword(rig, jump)
    rig.do(drive("west", "middle", "east"), for_s=90.0)
    assert rig.heard[-1] == WayDone(order=1, node="east")
    assert rig.problems() == []
    assert len([note for note in rig.notes if note.startswith("a pose that jumps: 5")]) == 1
    assert rig.body.control.view.odd["a pose that jumps"] > 5
    assert rig.body.sense().pose.x_m < 100.0


def test_a_pose_that_stays_where_it_has_jumped_to_is_believed_soon() -> None:
    rig = Rig()
    rig.run(1.0)
    rig.sim.place_at("corner")
    say(rig, 2.0)
    assert rig.body.sense().node == "west"
    rig.run(8.0)
    assert rig.body.sense().node == "corner", "it is asked, though it says something every 30 s only"


STAMPS = {
    "an odd timestamp: '14:30' is no time of ISO 8601": "14:30",
    "an odd timestamp: '' is no time of ISO 8601": "",
    "an odd timestamp: 1970-01-01T00:00:07Z: its clock was never set": "1970-01-01T00:00:07Z",
    "an odd timestamp: 9999-12-31T23:59:59Z: its clock was never set": "9999-12-31T23:59:59Z",
    "an odd timestamp: 'AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA' is no time of ISO 8601": "A" * 100_000,
    "no timestamp: a state does not say when it was": ABSENT,
}


@pytest.mark.parametrize("told", STAMPS)
def test_a_timestamp_that_cannot_be_is_told_once_and_changes_nothing(told: str) -> None:
    rig = Rig()

    def change(said: dict[str, Any]) -> None:
        if STAMPS[told] is ABSENT:
            del said["timestamp"]
        else:
            said["timestamp"] = STAMPS[told]

    reword(rig, change)
    say(rig)
    rig.do(drive("west", "middle"), for_s=60.0)
    assert rig.heard[-1] == WayDone(order=1, node="middle")
    assert rig.notes == [told]


@pytest.mark.parametrize(("off_s", "told"), [(-20.0, "goes back"), (86_400.0, "jumps"), (-86_400.0, "jumps")])
def test_a_clock_that_is_set_while_it_runs_is_told_once(off_s: float, told: str) -> None:
    rig = Rig()
    say(rig)
    rig.vehicle.words.quirks = Misbehaviour(clock_off_s=off_s)
    rig.do(drive("west", "middle"), for_s=60.0)
    assert rig.heard[-1] == WayDone(order=1, node="middle")
    assert len(rig.notes) == 1
    assert told in rig.notes[0]


def test_a_clock_that_was_always_wrong_by_a_day_is_no_doubt() -> None:
    rig = Rig(quirks=Misbehaviour(clock_off_s=86_400.0))
    rig.do(drive("west", "middle"), for_s=60.0)
    assert rig.notes == []


def test_a_load_that_comes_and_goes_with_no_action_is_told_and_not_taken() -> None:
    rig = Rig()
    rig.run(1.0)
    for _ in range(3):
        reword(rig, lambda said: said.update(loads=[{"loadType": "box", "weight": -5.0}]))
        say(rig, 1.0)
        del rig.give  # type: ignore[method-assign]
        say(rig, 1.0)
    assert rig.body.sense().load == ""
    assert rig.problems() == []
    assert [note.partition(":")[0] for note in rig.notes] == [
        "an odd weight of a load",
        "a load that comes and goes",
    ]
    assert rig.body.control.view.odd["a load that comes and goes"] == 3


def test_a_load_sensor_that_lags_behind_the_end_of_a_pick_is_no_doubt() -> None:
    rig = Rig()
    rig.run(1.0)
    lags = True
    reword(rig, lambda said: said.update(loads=[]) if lags else None)
    while not rig.of(ActionDone):
        rig.do(*([] if rig.said("order") else [PICK]), for_s=0.5)
        assert rig.clock.now_s() < 120.0
    say(rig, 0.5)
    lags = False
    say(rig, 5.0)
    assert rig.body.sense().load == PICK.item
    assert rig.notes == []
    assert rig.problems() == []


@pytest.mark.parametrize("loads", ["absent", None, "a box", [], [7, "x"]])
@pytest.mark.parametrize("weight", [float("nan"), 3.5, "heavy"])
def test_a_list_of_loads_that_is_none_and_weights_that_are_none_change_nothing(
    loads: Any, weight: Any
) -> None:
    rig = Rig()

    def change(said: dict[str, Any]) -> None:
        if loads == "absent":
            said.pop("loads", None)
        else:
            said["loads"] = loads
        if isinstance(loads, list) and rig.sim.sense().load:
            said["loads"] = [*loads, {"loadType": PICK.item, "weight": weight}]

    reword(rig, change)
    say(rig)
    assert rig.do(PICK, for_s=60.0) == [ActionDone(order=5)]
    assert rig.body.sense().load == PICK.item
    assert rig.problems() == []


def test_doubts_that_are_told_are_bounded() -> None:
    rig = Rig()
    doubts: Doubts = rig.body.control.view.doubts
    for number in range(1000):
        doubts.note(f"odd {number}", "x")
    assert len(doubts.to_tell()) == TOLD_MAX
    assert doubts.to_tell() == []


@pytest.mark.parametrize(
    "said",
    [
        "1970-01-01T00:00:00Z",
        "2024-02-29T23:59:59.25Z",
        "2026-11-27T14:30:00+02:00",
        "2026-11-27T14:30:00-0330",
        "2100-03-01 00:00:00",
        "2000-12-31T12:00:00.000000Z",
    ],
)
def test_a_timestamp_is_read_as_the_calendar_has_it(said: str) -> None:
    moment = datetime.fromisoformat(said)
    moment = moment if moment.tzinfo is not None else moment.replace(tzinfo=UTC)
    assert read_timestamp(said) == (pytest.approx(moment.timestamp()), moment.year)


@pytest.mark.parametrize(
    "said",
    ["", "14:30", "2026-13-01T00:00:00Z", "2026-01-01", "2026-01-01T25:00:00Z", "٢٠٢٦-01-01T00:00:00Z"],
)
def test_what_is_no_time_is_not_read(said: str) -> None:
    assert read_timestamp(said) is None
