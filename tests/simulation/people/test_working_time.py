"""Simulated people keep the working time of their areas: nobody is on duty in a break, and what breaks then waits for its end."""

from __future__ import annotations

import asyncio

from msgspec.structs import replace

from dray.plant import Plant, load_plant
from dray.plant.working_time import WeeklySpan, WorkingHours
from dray_sim.checks.bounds import Bounds
from dray_sim.clock.loop import clock, run
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.people.crew import hire
from dray_sim.people.habits import Habits
from dray_sim.people.technicians import employ

FILE = load_plant("single-track").file
BREAK_S, BACK_S = 120.0, 900.0
HOURS = WorkingHours(
    shifts=(WeeklySpan("00:00", "00:00"),), breaks=(WeeklySpan("00:02", "00:15"),), holidays=()
)
PLANT = Plant(replace(FILE, areas=tuple(replace(each, working_time=HOURS) for each in FILE.areas)))


def test_nobody_is_on_duty_in_a_break_and_what_breaks_then_is_mended_after_it() -> None:
    async def main() -> tuple[dict[float, int], dict[float, tuple[str, str]]]:
        factory = SimFactory(PLANT, clock(), seed=1)
        people = (*hire(factory, seed=1), *employ(factory, seed=1))
        there: dict[float, int] = {}
        wrong: dict[float, tuple[str, str]] = {}
        async with asyncio.TaskGroup() as group:
            lives = [group.create_task(factory.run())]
            lives += [group.create_task(person.run()) for person in people]
            for at_s in (100.0, 130.0, 400.0, 899.0, 910.0, 1500.0):
                await asyncio.sleep(at_s - clock().now_s())
                there[at_s] = sum(person.duty.agent is not None for person in people)
                if at_s == 400.0:
                    factory.vehicles["ATV1"].break_down("blocked way")
                    factory.workcells["M1"].break_down("spindle")
                wrong[at_s] = factory.vehicles["ATV1"].problem, factory.workcells["M1"].broken
            for life in lives:
                life.cancel()
        assert there[100.0] == len(people)
        return there, wrong

    there, wrong = run(main())
    assert (there[130.0], there[400.0], there[899.0]) == (0, 0, 0)
    assert there[910.0] == there[1500.0] == there[100.0]
    assert wrong[899.0] == ("blocked way", "spindle")
    assert wrong[1500.0] == ("", "")


def test_bounds_count_the_rests_of_people() -> None:
    without, with_rests = (Bounds(plant, Habits()).settle_s for plant in (Plant(FILE), PLANT))
    assert with_rests == without + BACK_S - BREAK_S
