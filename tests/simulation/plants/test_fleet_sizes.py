"""Fleets of several sizes on one floor: which runs are made, and when a fall is called one."""

from __future__ import annotations

import math

import pytest
from fleet_runs import fleet_run

from dray.plant import load_plant
from dray_sim.plants import fleet_sizes
from dray_sim.plants.fall import Fall, fall_from_best, standard_error, student_t
from dray_sim.plants.fleet_sizes import Asked, FleetRun, FleetSize, Floor, play_sizes

SIXTEEN = {1: 100.0, 2: 120.0, 3: 110.0, 4: 90.0, 5: 80.0}


def fall_of(*carried: float) -> Fall:
    found = fall_from_best({16: SIXTEEN}, dict(enumerate(carried, 1)))
    assert found is not None
    return found


def test_a_fall_is_one_only_where_it_is_larger_than_5_percent_and_than_chance() -> None:
    assert fall_of(80.0, 99.0, 92.0, 73.0, 61.0).verdict == "falls"
    small = fall_of(97.0, 116.0, 107.0, 87.0, 77.0)
    assert small.frac == pytest.approx(0.032)
    assert small.verdict == "holds"
    by_chance = fall_of(60.0, 150.0, 40.0, 110.0, 60.0)
    assert by_chance.frac == pytest.approx(0.16)
    assert by_chance.verdict == "open"


def test_the_runs_of_one_seed_are_compared_and_not_the_means() -> None:
    """The seeds differ by 80 to 120, and the larger fleet carries 0.8 of each."""
    found = fall_of(*(0.8 * carried for carried in SIXTEEN.values()))
    assert found.frac == pytest.approx(0.2)
    assert found.error_frac == pytest.approx(0.0)
    assert found.verdict == "falls"
    other = fall_of(*(0.8 * carried for carried in reversed(SIXTEEN.values())))
    assert other.frac == pytest.approx(0.2)
    assert other.error_frac == pytest.approx(0.091, abs=0.001)


def test_a_fleet_that_carries_more_holds_and_one_that_may_carry_less_is_open() -> None:
    assert fall_of(130.0, 150.0, 140.0, 125.0, 110.0).verdict == "holds"
    assert fall_of(60.0, 160.0, 120.0, 70.0, 95.0).verdict == "open"


def test_the_best_of_several_fleets_is_best_partly_by_chance() -> None:
    less = {1: 87.0, 2: 104.0, 3: 99.0, 4: 85.0, 5: 70.0}
    alone = fall_from_best({16: SIXTEEN}, less)
    among = fall_from_best(
        {2: dict.fromkeys(SIXTEEN, 1.0), 4: dict.fromkeys(SIXTEEN, 2.0), 16: SIXTEEN}, less
    )
    assert alone is not None
    assert among is not None
    assert alone.frac == among.frac
    assert among.chance_frac / alone.chance_frac == pytest.approx(student_t(0.05 / 3, 4) / student_t(0.05, 4))


@pytest.mark.parametrize(
    ("chance", "freedom", "t"),
    [
        (0.05, 1, 6.314),
        (0.05, 2, 2.920),
        (0.01, 2, 6.965),
        (0.01, 3, 4.541),
        (0.05, 4, 2.132),
        (0.025, 9, 2.262),
    ],
)
def test_what_chance_explains_is_as_printed_tables_say(chance: float, freedom: int, t: float) -> None:
    assert student_t(chance, freedom) == pytest.approx(t, abs=0.0006)


def test_one_run_proves_nothing() -> None:
    found = fall_from_best({16: {1: 100.0}}, {1: 20.0})
    assert found is not None
    assert found.verdict == "open"
    assert found.tell() == "open: 80.0% less than 16"
    assert math.isinf(standard_error([20.0]))


def test_a_fleet_is_compared_with_the_best_smaller_one_in_the_seeds_of_both() -> None:
    smaller = {2: {1: 10.0, 2: 20.0}, 4: {1: 40.0, 2: 60.0}, 8: {1: 30.0, 2: 50.0, 3: 900.0}}
    found = fall_from_best(smaller, {1: 39.0, 2: 57.0})
    assert found is not None
    assert found.vehicles == 4
    assert found.frac == pytest.approx(0.04)
    assert fall_from_best({}, {1: 39.0}) is None
    assert fall_from_best({2: {1: 0.0}}, {1: 39.0}) is None


def test_a_row_says_that_a_fleet_is_too_large_for_its_floor() -> None:
    floor = Floor("workshop", load_plant("workshop").file)
    for count, is_said in ((31, False), (32, True)):
        run = fleet_run(Asked(1, floor, count, 1.0, True), transports=90, most=31)
        told = FleetSize(count, (run,), 90.0, math.inf, 80.0, math.inf, None).tell()
        assert ("too many: the floor bears 31 at most" in told) is is_said


def test_a_fleet_is_no_larger_than_the_floor_has_nodes_and_is_played_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    made: list[int] = []

    def play(asked: Asked) -> FleetRun:
        made.append(asked.vehicles)
        return fleet_run(asked, transports=100 - len(made))

    monkeypatch.setattr(fleet_sizes, "play_run", play)
    floor = Floor("workshop", load_plant("workshop").file)
    rows = list(play_sizes(floor, (900, 2, 800, 2), runs=1))
    assert [row.vehicles for row in rows] == made
    assert len(rows) == 2
    assert rows[0].vehicles == 2
    assert rows[1].vehicles < 800
    assert rows[1].fall is not None
    assert rows[1].fall.vehicles == 2
