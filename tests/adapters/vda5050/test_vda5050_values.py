"""Values that cannot be are as good as none: nothing is clamped in silence, and people are told once."""

from __future__ import annotations

from typing import Any

import msgspec
import pytest
from field import reword, say
from vda_rig import PROFILE, Rig
from yard import drive

from dray.adapters.vda5050.control.doubts import TOLD_MAX, Doubts
from dray.adapters.vda5050.profile import Profile
from dray.body import ActionDone, Charge, NodePassed, WayDone

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
    assert with_battery(value, profile).body.sense().battery_frac == frac


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


def test_a_negative_sequence_number_is_none() -> None:
    rig = Rig(msgspec.structs.replace(PROFILE, updates=True, base_m=100.0))
    reword(rig, lambda said: said.update(lastNodeSequenceId=-2))
    rig.do(drive("west", "middle", "west"), for_s=2.0)
    assert rig.passed() == [("west", 0)], "it has not come back before it has left"


def test_doubts_that_are_told_are_bounded() -> None:
    rig = Rig()
    doubts: Doubts = rig.body.control.view.doubts
    for number in range(1000):
        doubts.note(f"odd {number}", "x")
    assert len(doubts.to_tell()) == TOLD_MAX
    assert doubts.to_tell() == []
