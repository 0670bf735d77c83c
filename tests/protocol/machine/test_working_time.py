"""A machine works when its working time says so: what has begun is finished, nothing begins in a rest, and promises count rests.

The tests' clock begins on a Thursday, at midnight of UTC.
"""

from __future__ import annotations

import pytest
from defaults import PLANT
from effects import facts, instructed, published, sent
from m7 import FULL, NO_HOUSINGS, incoming, status
from msgspec.structs import replace
from rigs import MachineRig
from spoken import announcement, production

from dray.body import Broken, StartCycle
from dray.messages import Bid, MachineStatus, ProductionCost, TaskAnnounced
from dray.messages.fact import MachineStatusChanged
from dray.plant import Plant
from dray.plant.working_time import WeeklySpan, WorkingHours
from dray.protocol.machine.production import REST_MAX_S

TEN_MINUTES_EACH_HALF_HOUR = WorkingHours(
    shifts=(WeeklySpan("00:00", "02:00"),),
    breaks=(WeeklySpan("00:10", "00:30"), WeeklySpan("00:40", "01:00")),
)
BREAK_S, BACK_S = 600.0, 1800.0


def plant_of(hours: WorkingHours | None) -> Plant:
    return Plant(replace(PLANT.file, working_time=hours))


def resting_m7(stock: dict[str, int] = FULL, *, goal: int = 0, now_s: float = 0.0) -> MachineRig:
    rig = MachineRig("M7", stock, plant=plant_of(TEN_MINUTES_EACH_HALF_HOUR))
    rig.now_s = now_s
    rig.start()
    if goal:
        rig.take_goal("G1", production(quantity=goal))
    return rig


def begun(rig: MachineRig) -> int:
    return len(instructed(rig.all, StartCycle))


def test_a_cycle_that_has_begun_is_finished_and_the_next_one_waits_until_the_rest_is_over() -> None:
    rig = resting_m7(goal=3)
    rig.run(BREAK_S + 1.0)
    assert status(rig) is MachineStatus.PRODUCING
    rig.cycle()
    rig.run(BREAK_S + 2.0)
    assert (begun(rig), status(rig)) == (1, MachineStatus.RESTING)
    rig.run(BACK_S - 1.0)
    assert begun(rig) == 1
    rig.run(BACK_S)
    assert (begun(rig), status(rig)) == (2, MachineStatus.PRODUCING)


def test_it_rests_with_nothing_to_do_as_well_and_says_when_that_changes() -> None:
    rig = resting_m7()
    rig.run(BACK_S + 1.0)
    told = [fact.status for fact in facts(rig.all, MachineStatusChanged)]
    assert told == [MachineStatus.RESTING, MachineStatus.IDLE]


def test_one_that_breaks_in_a_rest_says_that_it_is_broken() -> None:
    rig = resting_m7(now_s=BREAK_S)
    rig.report(Broken(reason="oil"))
    rig.run(rig.now_s + 1.0)
    assert status(rig) is MachineStatus.ERROR


def test_material_comes_in_a_rest_and_is_wanted_when_it_is_over() -> None:
    rig = resting_m7(NO_HOUSINGS, goal=24, now_s=BREAK_S)
    assert incoming(rig.all) == [("housing", 24)]
    [asked] = [each for each in published(rig.all, TaskAnnounced) if each.round == 1][:1]
    assert asked.deadline_s >= BACK_S


@pytest.mark.parametrize(
    ("now_s", "quantity", "rest_s"),
    [
        (0.0, 12, 0.0),
        (0.0, 13, 1200.0),
        (BREAK_S, 1, 1200.0),
        (0.0, 25, 2400.0),
        (9 * 3600.0, 1, 15 * 3600.0),
    ],
)
def test_a_promise_counts_the_rests_until_it_is_done(now_s: float, quantity: int, rest_s: float) -> None:
    rig = resting_m7(now_s=now_s)
    ask = announcement(task="G1", coordinator="STRATEGIST", work=production(quantity=quantity))
    [bid] = sent(rig.on_message("STRATEGIST", ask), Bid)
    assert isinstance(bid.cost, ProductionCost)
    assert bid.cost.rest_s == rest_s
    assert bid.finish_s == now_s + quantity * 50.0 + rest_s
    assert bid.cost.total_s == quantity * 50.0 + rest_s


def test_who_never_rests_promises_no_rest_that_is_less_than_none_whatever_the_date() -> None:
    machines = tuple(
        replace(each, makes=tuple(replace(making, cycle_s=49.9) for making in each.makes))
        for each in PLANT.file.machines
    )
    rig = MachineRig("M7", FULL, plant=Plant(replace(PLANT.file, machines=machines)))
    rig.now_s = 1795675618.1621265
    rig.start()
    asks = [
        announcement(task=f"G{quantity}", coordinator="STRATEGIST", work=production(quantity=quantity))
        for quantity in range(1, 21)
    ]
    bids = [bid for ask in asks for bid in sent(rig.on_message("STRATEGIST", ask), Bid)]
    assert len(bids) == len(asks)
    assert all(isinstance(bid.cost, ProductionCost) and bid.cost.rest_s >= 0.0 for bid in bids)


def test_who_never_works_again_promises_no_time_that_is_not_a_number() -> None:
    never = WorkingHours(shifts=(WeeklySpan("00:00", "02:00"),), breaks=(WeeklySpan("00:00", "00:00"),))
    rig = MachineRig("M7", FULL, plant=plant_of(never))
    rig.start()
    ask = announcement(task="G1", coordinator="STRATEGIST", work=production(quantity=1))
    [bid] = sent(rig.on_message("STRATEGIST", ask), Bid)
    assert isinstance(bid.cost, ProductionCost)
    assert bid.cost.rest_s == REST_MAX_S


def test_a_machine_may_have_a_working_time_of_its_own() -> None:
    nights = WorkingHours(shifts=(WeeklySpan("22:00", "06:00"),))
    machines = tuple(
        replace(each, working_time=nights) if each.id == "M7" else each for each in PLANT.file.machines
    )
    plant = Plant(replace(PLANT.file, working_time=TEN_MINUTES_EACH_HALF_HOUR, machines=machines))
    assert plant.working_time_of("M7").is_on(5 * 3600.0)
    assert not plant.working_time_of("M8").is_on(5 * 3600.0)
    assert not plant.working_time_of("JOINED").is_on(5 * 3600.0)


def test_whoever_needs_no_calendar_sets_no_alarm_for_it() -> None:
    rig = MachineRig("M7", FULL)
    rig.start()
    assert plant_of(None).working_time_of("M7").is_always
    rig.run(3600.0)
    assert facts(rig.all, MachineStatusChanged) == []
