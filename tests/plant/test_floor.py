"""Cells, areas and polygons: where a point is."""

from __future__ import annotations

from math import hypot, inf

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dray.plant import Point
from dray.plant.floor.geometry import area_m2, crossed_edges, distance_m, inside
from dray.plant.floor.grid import Grid

SIDE_M = st.floats(1.0, 200.0)
HERE_M = st.floats(-50.0, 250.0)

SQUARE = (Point(0, 0), Point(10, 0), Point(10, 10), Point(0, 10))
HORSESHOE = (
    Point(0, 0),
    Point(9, 0),
    Point(9, 9),
    Point(6, 9),
    Point(6, 3),
    Point(3, 3),
    Point(3, 9),
    Point(0, 9),
)


def test_a_cell_is_named_by_column_and_row() -> None:
    grid = Grid(60, 40, 20)
    assert grid.cell_of(0, 0) == "0_0"
    assert grid.cell_of(59.9, 39.9) == "2_1"
    assert grid.cell_of(20, 19.99) == "1_0"


def test_the_upper_and_right_walls_belong_to_the_last_cells() -> None:
    assert Grid(60, 40, 20).cell_of(60, 40) == "2_1"


def test_a_point_beyond_the_floor_counts_to_the_nearest_cell() -> None:
    assert Grid(60, 40, 20).cell_of(-5, 100) == "0_1"


def test_a_small_circle_meets_one_cell() -> None:
    assert Grid(60, 40, 20).within(10, 10, 5) == ("0_0",)


def test_a_circle_meets_the_cells_around_a_corner_only_when_it_reaches_them() -> None:
    grid = Grid(60, 40, 20)
    assert grid.within(15, 15, 6) == ("0_0", "0_1", "1_0")
    assert grid.within(15, 15, 8) == ("0_0", "0_1", "1_0", "1_1")


@pytest.mark.parametrize("radius_m", [72.2, 1e9, inf])
def test_a_circle_around_the_whole_plant_meets_all_cells(radius_m: float) -> None:
    assert Grid(60, 40, 20).within(0, 0, radius_m) == ("0_0", "0_1", "1_0", "1_1", "2_0", "2_1")


def test_a_circle_beyond_the_floor_meets_no_cell() -> None:
    assert Grid(60, 40, 20).within(-10, -10, 5) == ()


@st.composite
def grids(draw: st.DrawFn) -> tuple[Grid, float, float]:
    """A grid, its width and its height."""
    width_m, height_m = draw(SIDE_M), draw(SIDE_M)
    return Grid(width_m, height_m, draw(st.floats(2.0, 40.0))), width_m, height_m


CIRCLES = st.tuples(HERE_M, HERE_M, st.floats(0.0, 150.0))


@settings(deadline=None)
@given(grids(), CIRCLES, st.data())
def test_whoever_stands_within_the_circle_listens_to_one_of_its_cells(
    sized: tuple[Grid, float, float], circle: tuple[float, float, float], data: st.DataObject
) -> None:
    grid, width_m, height_m = sized
    x_m, y_m, radius_m = circle
    there_x_m, there_y_m = data.draw(st.floats(0.0, width_m)), data.draw(st.floats(0.0, height_m))
    # A circle that just about reaches somebody, so that most examples tell something.
    enough_m = max(radius_m, hypot(there_x_m - x_m, there_y_m - y_m) + 1e-9)
    assert grid.cell_of(there_x_m, there_y_m) in grid.within(x_m, y_m, enough_m)


@settings(deadline=None)
@given(grids(), CIRCLES)
def test_cells_come_once_each_and_grow_with_the_radius(
    sized: tuple[Grid, float, float], circle: tuple[float, float, float]
) -> None:
    x_m, y_m, radius_m = circle
    cells = sized[0].within(x_m, y_m, radius_m)
    assert len(set(cells)) == len(cells)
    assert set(cells) <= set(sized[0].within(x_m, y_m, radius_m + 10.0))
    assert sized[0].within(x_m, y_m, radius_m) is cells


@pytest.mark.parametrize(
    ("x_m", "y_m", "within"),
    [(1, 8, True), (8, 8, True), (4.5, 1, True), (4.5, 8, False), (4.5, 3, True), (9.1, 5, False)],
)
def test_a_point_is_inside_of_a_concave_polygon(x_m: float, y_m: float, within: bool) -> None:
    assert inside(Point(x_m, y_m), HORSESHOE) is within
    assert inside(Point(x_m, y_m), HORSESHOE[::-1]) is within


@given(st.floats(0, 10), st.sampled_from([0.0, 10.0]))
def test_the_border_belongs_to_the_polygon(along_m: float, side_m: float) -> None:
    assert inside(Point(along_m, side_m), SQUARE)
    assert inside(Point(side_m, along_m), SQUARE)


@given(st.floats(-5, 15), st.floats(-5, 15))
def test_a_square_holds_what_lies_between_its_sides(x_m: float, y_m: float) -> None:
    assert inside(Point(x_m, y_m), SQUARE) is (0 <= x_m <= 10 and 0 <= y_m <= 10)


@pytest.mark.parametrize(
    ("x_m", "y_m", "away_m"),
    [(1, 8, 0), (9, 5, 0), (11, 5, 2), (4.5, 5, 1.5), (4.5, -2, 2), (12, -4, 5), (4.5, 12, hypot(1.5, 3))],
)
def test_the_distance_to_a_polygon_is_that_to_its_nearest_point(
    x_m: float, y_m: float, away_m: float
) -> None:
    assert distance_m(Point(x_m, y_m), HORSESHOE) == pytest.approx(away_m)
    assert distance_m(Point(x_m, y_m), HORSESHOE[::-1]) == pytest.approx(away_m)


@pytest.mark.parametrize("turn", range(8))
def test_simple_polygons_have_no_crossed_edges(turn: int) -> None:
    assert crossed_edges(HORSESHOE[turn:] + HORSESHOE[:turn]) is None


def test_crossed_edges_are_found() -> None:
    bow_tie = (Point(0, 0), Point(10, 10), Point(10, 0), Point(0, 10))
    assert crossed_edges(bow_tie) == (0, 2)


def test_an_edge_that_runs_back_over_its_neighbour_is_found() -> None:
    assert crossed_edges((Point(0, 0), Point(10, 0), Point(4, 0), Point(4, 5))) == (0, 1)


def test_a_corner_that_touches_another_edge_is_found() -> None:
    assert crossed_edges((Point(0, 0), Point(10, 0), Point(10, 10), Point(5, 0), Point(0, 10))) is not None


def test_the_area_is_the_same_whichever_way_round() -> None:
    assert area_m2(SQUARE) == area_m2(SQUARE[::-1]) == 100.0
    assert area_m2(HORSESHOE) == 81.0 - 18.0
