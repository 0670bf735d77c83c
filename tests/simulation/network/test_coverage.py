"""Where the WLAN reaches."""

from __future__ import annotations

from math import hypot

import pytest

from dray.plant import default_plant
from dray_sim.network.coverage import AccessPoint, Coverage, Hole, access_points_of
from dray_sim.plants.generator import generate_plant


def test_an_access_point_reaches_as_far_as_its_range_and_no_farther() -> None:
    coverage = Coverage([AccessPoint("AP1", 10.0, 10.0, range_m=5.0)])
    assert coverage.covers(10.0, 15.0)
    assert coverage.covers(13.0, 14.0)
    assert not coverage.covers(10.0, 15.01)
    assert not coverage.perfect


def test_without_access_points_the_wlan_is_everywhere_but_in_the_holes() -> None:
    assert Coverage().perfect
    assert Coverage().covers(1e5, -1e5)
    holed = Coverage(holes=[Hole(10.0, 0.0, 2.0)])
    assert not holed.perfect
    assert holed.covers(7.9, 0.0)
    assert not holed.covers(8.0, 0.0)
    assert not holed.covers(10.0, 0.0)


def test_a_hole_is_a_hole_also_beside_an_access_point() -> None:
    coverage = Coverage([AccessPoint("AP1", 0.0, 0.0)], [Hole(1.0, 0.0, 2.0)])
    assert not coverage.covers(0.0, 0.0)
    assert coverage.covers(-1.5, 0.0)


def test_another_access_point_stands_in_for_one_that_is_down() -> None:
    points = [AccessPoint("AP1", 0.0, 0.0, 10.0), AccessPoint("AP2", 12.0, 0.0, 10.0)]
    whole = Coverage(points, whole=True)
    failed = whole.with_faults([], ["AP1"])
    assert whole.perfect
    assert not failed.perfect
    assert failed.covers(5.0, 0.0)
    assert not failed.covers(-5.0, 0.0)
    assert not failed.with_faults([], ["AP2"]).covers(5.0, 0.0)


@pytest.mark.parametrize("range_m", [7.0, 30.0, 500.0])
def test_a_plants_access_points_leave_no_point_of_the_floor_uncovered(range_m: float) -> None:
    for plant in (default_plant(), generate_plant(3, 30, 40)):
        points = access_points_of(plant, range_m)
        assert len({point.id for point in points}) == len(points)
        steps = 60
        for column in range(steps + 1):
            for row in range(steps + 1):
                x_m, y_m = plant.width_m * column / steps, plant.height_m * row / steps
                nearest_m = min(hypot(x_m - point.x_m, y_m - point.y_m) for point in points)
                assert nearest_m <= range_m * (1.0 + 1e-9)


def test_a_plant_is_covered_by_few_access_points() -> None:
    plant = default_plant()
    assert Coverage.of_plant(plant).perfect
    assert [point.id for point in access_points_of(plant)] == ["AP1", "AP2"]


def test_the_coverage_of_a_plant_is_what_it_says_when_an_access_point_fails() -> None:
    plant = default_plant()
    failed = Coverage.of_plant(plant).with_faults([], ["AP1"])
    assert failed.covers(plant.width_m, plant.height_m / 2)
    assert not failed.covers(0.0, plant.height_m / 2)
