"""Times that vary: by the seed, around their average, and not at all unless a plant says so."""

from __future__ import annotations

from statistics import fmean, stdev

import pytest
from msgspec.structs import replace

from dray.plant import Plant, default_plant
from dray_sim.bodies.durations import Durations
from dray_sim.run.evidence import HELD
from dray_sim.run.stage import Shift, play


def test_what_does_not_vary_is_always_the_same() -> None:
    assert {Durations("any").draw_s(15.0, 0.0) for _ in range(10)} == {15.0}


def test_the_average_and_the_deviation_are_those_that_were_asked_for() -> None:
    durations = Durations("7 handling ATV1")
    drawn = [durations.draw_s(20.0, 0.3) for _ in range(20_000)]
    assert fmean(drawn) == pytest.approx(20.0, rel=0.02)
    assert stdev(drawn) == pytest.approx(6.0, rel=0.03)
    assert min(drawn) > 0.0


def test_the_same_seed_gives_the_same_times_and_bodies_have_times_of_their_own() -> None:
    def row(name: str) -> list[float]:
        durations = Durations(name)
        return [durations.draw_s(20.0, 0.3) for _ in range(5)]

    assert row("7 handling ATV1") == row("7 handling ATV1")
    assert row("7 handling ATV1") != row("7 handling ATV2")


def test_a_station_says_how_much_handling_varies_there() -> None:
    file = default_plant().file
    kinds = tuple(replace(kind, handling_cv=0.2) for kind in file.vehicle_types)
    machines = (replace(file.machines[0], handling_cv=0.5), *file.machines[1:])
    plant = Plant(replace(file, vehicle_types=kinds, machines=machines))
    light = plant.vehicle_types["light"]
    assert plant.handling_cv("M1", light) == 0.5
    assert plant.handling_cv("M2", light) == 0.2
    assert default_plant().handling_cv("M1", default_plant().vehicle_types["light"]) == 0.0


def varied() -> Plant:
    file = default_plant().file
    return Plant(
        replace(
            file,
            vehicle_types=tuple(replace(kind, handling_cv=0.3) for kind in file.vehicle_types),
            machines=tuple(
                replace(spec, makes=tuple(replace(making, cycle_cv=0.2) for making in spec.makes))
                for spec in file.machines
            ),
        )
    )


@pytest.mark.slow
def test_a_run_with_times_that_vary_holds_and_is_the_same_again() -> None:
    shift = Shift(name="varied", duration_s=900.0, load=0.85, stock_frac=(0.0, 0.2))
    one, again, plain = play(shift, varied(), 3), play(shift, varied(), 3), play(shift, default_plant(), 3)
    assert one.invariants == HELD
    assert one.report.trace == again.report.trace
    assert one.report.trace != plain.report.trace
