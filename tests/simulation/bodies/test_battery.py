"""The battery's arithmetic against stepwise integration, and its promises."""

from __future__ import annotations

from math import inf, log

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dray.plant import VehicleType
from dray_sim.bodies.vehicle.battery import Battery, runs_out_s

TYPE = VehicleType(id="t", name="T", battery_wh=500.0, charge_w=600.0, charge_taper_frac=0.8, idle_w=30.0)
BATTERY = Battery(TYPE)
LEVELS = st.floats(0.0, 1.0)


def stepwise_frac(level_frac: float, seconds: float, steps: int = 20_000) -> float:
    """The charging curve as `VehicleType` words it, in small steps."""
    for _ in range(steps):
        taper = max(level_frac - TYPE.charge_taper_frac, 0.0) / (1.0 - TYPE.charge_taper_frac)
        power_w = TYPE.charge_w * (1.0 - 0.9 * taper)
        level_frac = min(level_frac + power_w * seconds / steps / 3600.0 / TYPE.battery_wh, 1.0)
    return level_frac


@pytest.mark.parametrize(
    ("level_frac", "seconds"), [(0.0, 600.0), (0.5, 1500.0), (0.79, 900.0), (0.9, 300.0)]
)
def test_charging_matches_stepwise_integration(level_frac: float, seconds: float) -> None:
    assert BATTERY.charged_frac(level_frac, seconds) == pytest.approx(
        stepwise_frac(level_frac, seconds), abs=1e-5
    )


def test_half_a_charge_takes_what_the_power_says() -> None:
    assert BATTERY.charging_s(0.0, 0.6) == pytest.approx(0.6 * 500.0 / 600.0 * 3600.0)


def test_the_last_fifth_takes_the_logarithm_of_ten_over_nine_tenths_as_long() -> None:
    flat_s = 0.2 * 500.0 / 600.0 * 3600.0
    assert BATTERY.charging_s(0.8, 1.0) == pytest.approx(flat_s * log(10.0) / 0.9)


@settings(deadline=None)
@given(LEVELS, LEVELS)
def test_charging_for_the_time_to_a_level_reaches_that_level(one: float, other: float) -> None:
    low, high = sorted((one, other))
    assert BATTERY.charged_frac(low, BATTERY.charging_s(low, high)) == pytest.approx(high, abs=1e-9)


@settings(deadline=None)
@given(LEVELS, st.floats(0.0, 1e5), st.floats(0.0, 1e5))
def test_charging_in_two_parts_is_charging_at_once(level_frac: float, one_s: float, other_s: float) -> None:
    parts = BATTERY.charged_frac(BATTERY.charged_frac(level_frac, one_s), other_s)
    assert parts == pytest.approx(BATTERY.charged_frac(level_frac, one_s + other_s), abs=1e-9)


@settings(deadline=None)
@given(LEVELS, st.floats(0.0, 1e6))
def test_charging_never_lowers_a_level_nor_exceeds_full(level_frac: float, seconds: float) -> None:
    assert level_frac - 1e-12 <= BATTERY.charged_frac(level_frac, seconds) <= 1.0


@settings(deadline=None)
@given(LEVELS)
def test_a_battery_that_is_there_already_takes_no_time(level_frac: float) -> None:
    assert BATTERY.charging_s(level_frac, level_frac) == 0.0


@pytest.mark.parametrize("taper_frac", [0.0, 1.0])
def test_a_curve_may_taper_from_the_beginning_or_never(taper_frac: float) -> None:
    battery = Battery(VehicleType(id="t", name="T", charge_taper_frac=taper_frac))
    full_s = battery.charging_s(0.0)
    assert 0.0 < full_s < inf
    assert battery.charged_frac(0.0, full_s) == pytest.approx(1.0)
    assert battery.charged_frac(1.0, 10.0) == 1.0


@settings(deadline=None)
@given(st.floats(0.0, 1e4), st.floats(0.0, 1e4), st.booleans())
def test_spending_adds_metres_and_seconds(metres: float, seconds: float, loaded: bool) -> None:
    per_m = TYPE.loaded_wh_per_m if loaded else TYPE.drive_wh_per_m
    expected_wh = metres * per_m + seconds * TYPE.idle_w / 3600.0
    assert BATTERY.spent_frac(metres, loaded, seconds) == pytest.approx(expected_wh / TYPE.battery_wh)


def test_a_standing_vehicle_lasts_as_long_as_its_battery() -> None:
    assert BATTERY.lasts_s(0.5) == pytest.approx(250.0 / 30.0 * 3600.0)
    assert Battery(VehicleType(id="t", name="T", idle_w=0.0)).lasts_s(0.5) == inf


@given(st.floats(0.0, 1.0), st.floats(1e-3, 1e4))
def test_the_end_of_a_battery_is_found_on_any_curve_that_falls(when_frac: float, duration_s: float) -> None:
    begin_s, empty_s = 1000.0, 1000.0 + when_frac * duration_s

    def level_frac(at_s: float) -> float:
        return max(empty_s - at_s, 0.0) ** 2

    assert runs_out_s(level_frac, begin_s, begin_s + duration_s) == pytest.approx(empty_s, abs=1e-9)
