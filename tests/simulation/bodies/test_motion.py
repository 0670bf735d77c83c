"""Speed profiles: within every limit, continuous, exact at the end, and as fast as the plant expects."""

from __future__ import annotations

from itertools import pairwise
from math import inf, sqrt

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dray.plant import Plant, VehicleType, default_plant
from dray_sim.bodies.vehicle.motion import STANDSTILL, Profile, Stretch, brake, plan
from dray_sim.bodies.vehicle.way import Way, join

RATE_MPS2 = 0.6
ROUNDING_MPS = 1e-4
"""A stretch below a nanometre is left out; the speed jumps by as much as it would have changed there."""


@st.composite
def stretches(draw: st.DrawFn) -> Stretch:
    count = draw(st.integers(1, 12))

    def several(low: float, high: float) -> list[float]:
        return draw(st.lists(st.floats(low, high), min_size=count, max_size=count))

    caps = draw(st.lists(st.sampled_from([inf, inf, 0.3, 0.5]), min_size=count, max_size=count))
    return Stretch(several(0.01, 40.0), several(0.1, 2.5), [*caps[:-1], 0.0])


def ends(stretch: Stretch) -> list[float]:
    places, place_m = [], 0.0
    for length_m in stretch.lengths_m:
        place_m += length_m
        places.append(place_m)
    return places


def samples(profile: Profile, count: int = 400) -> list[float]:
    return [profile.duration_s * i / count for i in range(count + 1)]


def limit_at(stretch: Stretch, place_m: float) -> float:
    """The highest limit of the lanes that this place may belong to."""
    begin_m, limits = 0.0, []
    for length_m, limit_mps in zip(stretch.lengths_m, stretch.limits_mps, strict=True):
        if begin_m - 1e-9 <= place_m <= begin_m + length_m + 1e-9:
            limits.append(limit_mps)
        begin_m += length_m
    return max(limits)


@settings(deadline=None)
@given(stretches())
def test_a_profile_from_standstill_is_never_above_a_limit(stretch: Stretch) -> None:
    profile = plan(stretch, 0.0, RATE_MPS2)
    for time_s in samples(profile):
        place_m, speed_mps = profile.at(time_s)
        assert speed_mps <= limit_at(stretch, place_m) + ROUNDING_MPS
    for place_m, cap_mps in zip(ends(stretch)[:-1], stretch.caps_mps, strict=False):
        assert profile.at(profile.time_at(place_m))[1] <= cap_mps + ROUNDING_MPS


@settings(deadline=None)
@given(stretches())
def test_a_profile_from_standstill_is_continuous_monotone_and_within_the_acceleration(
    stretch: Stretch,
) -> None:
    profile = plan(stretch, 0.0, RATE_MPS2)
    for before_s, after_s in pairwise(samples(profile)):
        (before_m, before_mps), (after_m, after_mps) = profile.at(before_s), profile.at(after_s)
        dt_s = after_s - before_s
        assert after_m >= before_m
        assert abs(after_mps - before_mps) <= RATE_MPS2 * dt_s + 24 * ROUNDING_MPS
        assert after_m - before_m <= (max(before_mps, after_mps) + RATE_MPS2 * dt_s) * dt_s + 1e-6


@settings(deadline=None)
@given(stretches(), st.floats(0.0, 2.5))
def test_a_profile_ends_at_exactly_the_length_and_stands(stretch: Stretch, speed_mps: float) -> None:
    profile = plan(stretch, speed_mps, RATE_MPS2)
    assert profile.at(profile.duration_s) == (sum(stretch.lengths_m), 0.0)
    assert profile.at(profile.duration_s + 100.0) == (sum(stretch.lengths_m), 0.0)
    assert profile.at(profile.duration_s * (1.0 - 1e-12))[0] == pytest.approx(profile.length_m, abs=1e-6)


@settings(deadline=None)
@given(stretches(), st.floats(0.0, 2.5))
def test_the_place_is_the_integral_of_the_speed(stretch: Stretch, speed_mps: float) -> None:
    profile = plan(stretch, speed_mps, RATE_MPS2)
    count = 4000
    dt_s = profile.duration_s / count
    integral_m = sum(profile.at((i + 0.5) * dt_s)[1] for i in range(count)) * dt_s
    assert integral_m == pytest.approx(profile.length_m, rel=2e-3, abs=2e-3)


@settings(deadline=None)
@given(stretches(), st.floats(0.0, 2.5), st.floats(0.0, 1.0))
def test_time_and_place_are_each_others_inverse(stretch: Stretch, speed_mps: float, part: float) -> None:
    profile = plan(stretch, speed_mps, RATE_MPS2)
    place_m = part * profile.length_m
    assert profile.at(profile.time_at(place_m))[0] == pytest.approx(place_m, abs=1e-7)


@settings(deadline=None)
@given(stretches(), st.floats(0.0, 2.5))
def test_times_at_nodes_rise_along_the_way(stretch: Stretch, speed_mps: float) -> None:
    profile = plan(stretch, speed_mps, RATE_MPS2)
    times = [profile.time_at(place_m) for place_m in ends(stretch)]
    assert times == sorted(times)
    assert times[-1] == profile.duration_s


@settings(deadline=None)
@given(stretches(), st.floats(0.0, 3.0))
def test_a_profile_begins_with_the_present_speed(stretch: Stretch, speed_mps: float) -> None:
    assert plan(stretch, speed_mps, RATE_MPS2).at(0.0) == (0.0, pytest.approx(speed_mps))


@settings(deadline=None)
@given(stretches(), st.floats(0.0, 1.0))
def test_planning_anew_on_the_way_changes_nothing_when_nothing_has_changed(
    stretch: Stretch, part: float
) -> None:
    profile = plan(stretch, 0.0, RATE_MPS2)
    time_s = part * profile.duration_s
    place_m, speed_mps = profile.at(time_s)
    lane = next(i for i, end_m in enumerate(ends(stretch)) if end_m >= place_m - 1e-9)
    rest = Stretch(
        [max(ends(stretch)[lane] - place_m, 0.0), *stretch.lengths_m[lane + 1 :]],
        stretch.limits_mps[lane:],
        stretch.caps_mps[lane:],
    )
    again = plan(rest, speed_mps, RATE_MPS2)
    assert again.duration_s == pytest.approx(profile.duration_s - time_s, rel=1e-3, abs=1e-2)


def test_a_short_lane_is_a_triangle_and_a_long_one_a_trapezoid() -> None:
    short = plan(Stretch([1.0], [1.0], [0.0]), 0.0, 0.5)
    assert short.duration_s == pytest.approx(2.0 * sqrt(2.0))
    assert short.at(short.duration_s / 2.0) == (pytest.approx(0.5), pytest.approx(sqrt(0.5)))
    long = plan(Stretch([10.0], [1.0], [0.0]), 0.0, 0.5)
    assert long.duration_s == pytest.approx(12.0)
    assert long.at(6.0) == (pytest.approx(5.0), pytest.approx(1.0))


def test_a_vehicle_that_must_be_slower_brakes_as_usual() -> None:
    profile = plan(Stretch([10.0], [0.5], [0.0]), 1.0, 0.5)
    assert profile.at(1.0) == (pytest.approx(0.75), pytest.approx(0.5))
    assert profile.at(2.0) == (pytest.approx(1.25), pytest.approx(0.5))


def test_a_lower_limit_may_be_reached_only_on_a_later_lane() -> None:
    profile = plan(Stretch([0.2, 0.2, 10.0], [0.5, 0.5, 0.5], [inf, inf, 0.0]), 1.0, 0.5)
    assert profile.at(1.0) == (pytest.approx(0.75), pytest.approx(0.5))


def test_a_turn_that_comes_too_suddenly_is_braked_for_as_hard_as_needed() -> None:
    profile = plan(Stretch([0.25, 10.0], [1.0, 1.0], [0.5, 0.0]), 1.0, 0.5)
    assert profile.at(profile.time_at(0.25))[1] == pytest.approx(0.5)


def test_a_stop_that_comes_too_suddenly_is_made_in_the_room_there_is() -> None:
    assert brake(1.0, 0.5, inf).length_m == pytest.approx(1.0)
    assert brake(1.0, 0.5, 0.25).at(10.0) == (0.25, 0.0)
    assert brake(0.0, 0.5, 10.0) is STANDSTILL


def test_a_place_beyond_the_end_is_never_reached() -> None:
    assert brake(1.0, 0.5, inf).time_at(1.1) == inf
    assert STANDSTILL.time_at(1.0) == inf


def test_a_free_run_takes_exactly_what_the_plant_tells_bidders() -> None:
    plant = default_plant()
    for kind in plant.vehicle_types.values():
        for start, goal in zip(plant.nodes, reversed(plant.nodes), strict=True):
            way = plant.routes(kind.id).way(start, goal)
            if way.length_m > 0.0:
                assert free_run_s(plant, kind, way.nodes) == pytest.approx(way.duration_s)


def free_run_s(plant: Plant, kind: VehicleType, nodes: tuple[str, ...]) -> float:
    lanes = join(plant.roads, nodes)
    assert not isinstance(lanes, str)
    way = Way(1, nodes, lanes, 0, kind.turn_speed_mps)
    stretch = way.ahead(0, 0.0, way.last, kind.max_speed_mps)
    return plan(stretch, 0.0, kind.acceleration_mps2).duration_s
