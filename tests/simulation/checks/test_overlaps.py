"""Vehicles in one spot: nothing is missed between two moments, and nothing is made up."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import pi
from typing import Any, cast

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dray.messages import AtvHeartbeat
from dray.plant import default_plant
from dray.plant.floor.rectangles import gap_m
from dray_sim.bodies.vehicle.course import Course
from dray_sim.bodies.vehicle.motion import STANDSTILL, Stretch, plan
from dray_sim.bodies.vehicle.vehicle import SimVehicle
from dray_sim.checks.broken import InvariantBroken
from dray_sim.checks.floor.overlaps import MISSED_M, Overlaps
from dray_sim.run.evidence import HELD
from dray_sim.run.stage import Shift, play

LENGTH_M, WIDTH_M = 1.0, 0.6
SOME = cast(AtvHeartbeat, None)
"""The judge does not look at messages."""


class Puppet:
    """A vehicle that moves as the test says."""

    def __init__(self, name: str, course: Course) -> None:
        self.name, self.course = name, course
        self.tell: Callable[[str, Course], None] = lambda _name, _course: None

    def watch_course(self, tell: Callable[[str, Course], None]) -> None:
        self.tell = tell
        tell(self.name, self.course)

    def go_on(self, course: Course) -> None:
        self.course = course
        self.tell(self.name, course)


def stands(x_m: float, y_m: float, heading_rad: float = 0.0, at_s: float = 0.0) -> Course:
    return Course(at_s, x_m, y_m, heading_rad, STANDSTILL, 0.0, 0.0, LENGTH_M, WIDTH_M)


def drives(
    x_m: float, y_m: float, heading_rad: float, length_m: float, at_s: float = 0.0, top_mps: float = 1.5
) -> Course:
    profile = plan(Stretch([length_m], [top_mps], [0.0]), 0.0, 0.6)
    return Course(at_s, x_m, y_m, heading_rad, profile, 0.0, length_m, LENGTH_M, WIDTH_M)


def judge(*courses: Course, strict: bool = False) -> tuple[Overlaps, list[Puppet]]:
    puppets = [Puppet(f"V{number}", course) for number, course in enumerate(courses)]
    vehicles: Any = {puppet.name: puppet for puppet in puppets}
    return Overlaps(cast("dict[str, SimVehicle]", vehicles), strict=strict), puppets


def test_vehicles_that_pass_on_two_lanes_do_not_touch() -> None:
    overlaps, _ = judge(drives(0, 0, 0.0, 20), drives(20, 0.65, pi, 20))
    overlaps.check_end(60.0)
    assert overlaps.count == 0


def test_vehicles_that_meet_on_one_track_are_in_one_spot_when_they_meet() -> None:
    overlaps, _ = judge(drives(0, 0, 0.0, 20), drives(20, 0, pi, 20))
    overlaps.check_end(60.0)
    assert overlaps.count == 1
    assert overlaps.first is not None
    # 19 m between them at first, and both speed up to 1.5 m/s, which takes 2.5 s and 1.875 m.
    assert overlaps.first.at_s == pytest.approx(2.5 + (9.5 - 1.875) / 1.5, abs=0.01)
    assert overlaps.first.depth_m <= 2 * MISSED_M


def test_an_overlap_of_a_micrometre_is_one_and_a_rounded_touch_is_none() -> None:
    overlaps, _ = judge(stands(0, 0), stands(LENGTH_M - 1e-6, 0))
    overlaps.check_end(1.0)
    assert overlaps.count == 1
    overlaps, _ = judge(stands(0, 0), stands(LENGTH_M - 1e-12, 0))
    overlaps.check_end(1.0)
    assert overlaps.count == 0


def test_a_follower_that_keeps_its_distance_does_not_touch() -> None:
    overlaps, _ = judge(drives(0, 0, 0.0, 20), drives(1.05, 0, 0.0, 20))
    overlaps.check_end(60.0)
    assert overlaps.count == 0


def test_corners_that_meet_for_a_moment_are_seen() -> None:
    """One drives across behind the other, and their corners overlap for a few centimetres of way."""
    overlaps, _ = judge(drives(0, 0, 0.0, 20), drives(8.8, -8.0, pi / 2, 20))
    overlaps.check_end(60.0)
    assert overlaps.count == 1


def test_a_vehicle_that_turns_on_the_spot_needs_room_for_it() -> None:
    overlaps, (turns, _) = judge(stands(0, 0, 0.0), stands(0, 0.75, 0.0))
    turns.go_on(stands(0, 0, pi, at_s=5.0))
    assert overlaps.count == 1
    clear, (turns, _) = judge(stands(0, 0, 0.0), stands(0, 0.9, 0.0))
    turns.go_on(stands(0, 0, pi, at_s=5.0))
    assert clear.count == 0


def test_what_is_in_one_spot_is_counted_once_until_it_is_apart_again() -> None:
    overlaps, (still, other) = judge(stands(0, 0), stands(0.2, 0))
    for second in range(1, 5):
        still.go_on(stands(0, 0, at_s=float(second)))
    assert overlaps.count == 1
    other.go_on(stands(5, 0, at_s=5.0))
    still.go_on(stands(0, 0, at_s=6.0))
    other.go_on(stands(0.2, 0, at_s=7.0))
    overlaps.check_end(8.0)
    assert overlaps.count == 2


def test_who_is_strict_breaks_the_run_with_the_next_message() -> None:
    overlaps, (still, _) = judge(stands(0, 0), stands(0.2, 0), strict=True)
    overlaps.on_message(0.0, "V0", "", SOME)
    still.go_on(stands(0, 0, at_s=1.0))
    with pytest.raises(InvariantBroken, match="V0 and V1 are in one spot"):
        overlaps.on_message(1.0, "V0", "", SOME)


PLACE = st.floats(-6.0, 6.0)
COURSES = st.one_of(
    st.builds(stands, PLACE, PLACE, st.floats(-pi, pi)),
    st.builds(
        drives, PLACE, PLACE, st.floats(-pi, pi), st.floats(0.5, 12.0), st.just(0.0), st.floats(0.3, 2.0)
    ),
)


@settings(deadline=None, max_examples=60)
@given(COURSES, COURSES)
def test_what_a_look_at_every_twentieth_of_a_second_sees_is_found(one: Course, other: Course) -> None:
    overlaps, _ = judge(one, other)
    overlaps.check_end(20.0)
    sampled = [gap_m(one.covers(step / 20), other.covers(step / 20)) for step in range(401)]
    if min(sampled) < -MISSED_M:
        assert overlaps.count == 1
    if overlaps.first is not None:
        at_s = overlaps.first.at_s
        assert gap_m(one.covers(at_s), other.covers(at_s)) < 0.0


@settings(deadline=None, max_examples=60)
@given(COURSES, COURSES, st.floats(0.1, 8.0))
def test_it_is_all_the_same_how_often_a_motion_is_told(one: Course, other: Course, at_s: float) -> None:
    """A course that is cut in two pieces is the same motion."""
    whole, _ = judge(one, other)
    whole.check_end(20.0)
    cut, (first, _) = judge(one, other)
    x_m, y_m = one.spot(at_s)
    profile = one._profile
    first.go_on(
        Course(
            at_s,
            x_m,
            y_m,
            one.heading_rad,
            profile,
            at_s,
            one.reach_m - one.driven_m(at_s),
            LENGTH_M,
            WIDTH_M,
        )
    )
    cut.check_end(20.0)
    assert bool(cut.count) == bool(whole.count)


@pytest.mark.slow
def test_a_run_with_right_of_way_for_nobody_has_overlaps_and_is_the_same_run() -> None:
    shift = Shift(name="ghosts", duration_s=600.0, load=0.85, stock_frac=(0.0, 0.1))
    plain = play(shift, default_plant(), 1)
    watched = play(replace(shift, overlaps=False), default_plant(), 1)
    assert plain.report.trace == watched.report.trace
    assert watched.invariants == HELD
    strict = play(replace(shift, overlaps=True), default_plant(), 1)
    assert "invariant 13 is broken" in strict.invariants
