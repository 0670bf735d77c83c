"""Where nobody is on duty, and by its working time nobody is there, what needs a person lasts until people come, and is judged so.

The tests' clock begins on a Thursday, at midnight of UTC; people come to all areas of this plant at six.
"""

from __future__ import annotations

import pytest
from defaults import PLANT
from effects import published
from m7 import FULL
from msgspec import UNSET
from msgspec.structs import replace
from rigs import MachineRig, VehicleRig
from spoken import award, production
from watches import newest

from dray.body import Broken, ProblemCleared, ProblemRaised
from dray.messages import DutyStatus, MachineHeartbeat, OperatorHeartbeat, Problem, ProblemEnded, ProblemKind
from dray.plant import Plant
from dray.plant.people import people_from_s
from dray.plant.working_time import WeeklySpan, WorkingHours
from dray.protocol.liveness.suspicion import BREAKDOWN_S

FROM_SIX = WorkingHours(shifts=(WeeklySpan("06:00", "14:00"),), breaks=(WeeklySpan("09:00", "09:30"),))
SIX_S, BREAK_S, NIGHT_S = 6 * 3600.0, 9 * 3600.0, 1000.0
DAYS = Plant(
    replace(PLANT.file, areas=tuple(replace(each, working_time=FROM_SIX) for each in PLANT.file.areas))
)
LOAD = Problem(kind=ProblemKind.LOAD)
JAM = Problem(kind=ProblemKind.JAM)


def carrying(now_s: float, plant: Plant = DAYS) -> VehicleRig:
    """ATV1 with a transport that has an hour."""
    rig = VehicleRig(plant=plant)
    rig.now_s = now_s
    rig.start()
    rig.on_message("M8", award(deadline_s=now_s + 3600.0))
    return rig


def on_duty(rig: VehicleRig | MachineRig, status: DutyStatus = DutyStatus.FREE) -> None:
    """Somebody is, by the tablet."""
    rig.on_message(
        "operator.anna",
        OperatorHeartbeat(
            operator="operator.anna",
            incarnation=1,
            seq=1,
            at_s=rig.now_s,
            status=status,
            areas=("AREA1",),
        ),
    )


def waits_s(rig: VehicleRig, problem: Problem = LOAD) -> float:
    """How long its task waits for a problem that begins now."""
    rig.report(ProblemRaised(reason="it stands", problem=problem))
    wanted = newest(rig).help
    assert wanted is not None
    return wanted.until_s - rig.now_s


def test_a_place_has_the_hours_of_its_area_and_what_lies_in_none_has_those_of_all() -> None:
    first, *others = PLANT.file.areas
    plant = Plant(replace(PLANT.file, areas=(replace(first, working_time=FROM_SIX), *others)))
    inside = next(node for node in plant.nodes.values() if plant.areas_at(node.x_m, node.y_m) == (first.id,))
    assert people_from_s(plant, inside.x_m, inside.y_m, NIGHT_S) == SIX_S
    assert people_from_s(plant, -500.0, -500.0, NIGHT_S) == NIGHT_S
    assert people_from_s(DAYS, -500.0, -500.0, NIGHT_S) == SIX_S


@pytest.mark.parametrize(("now_s", "waits"), [(NIGHT_S, False), (SIX_S, True), (BREAK_S, False)])
def test_a_task_waits_for_people_in_their_shift_and_not_in_a_break_or_at_night(
    now_s: float, waits: bool
) -> None:
    assert (waits_s(carrying(now_s)) > 0.0) is waits


def test_whoever_is_on_duty_by_the_tablet_counts_at_any_time_but_in_a_break() -> None:
    rig = carrying(NIGHT_S)
    on_duty(rig)
    assert waits_s(rig) > 0.0
    rig = carrying(NIGHT_S)
    on_duty(rig, DutyStatus.BREAK)
    assert waits_s(rig) == 0.0


def test_what_passes_by_itself_waits_for_nobody() -> None:
    assert waits_s(carrying(NIGHT_S), Problem(kind=ProblemKind.WAY_BLOCKED, passes=True)) > 0.0


def test_of_what_has_begun_at_night_nobody_learns_how_long_people_take() -> None:
    for now_s, told in ((NIGHT_S, 0), (SIX_S, 1)):
        rig = carrying(now_s)
        waits_s(rig)
        rig.now_s += 20.0
        rig.report(ProblemCleared())
        assert len(published(rig.all, ProblemEnded)) == told


@pytest.mark.parametrize("problem", [JAM, Problem()])
def test_a_machines_goals_go_to_others_at_night_and_wait_by_day(problem: Problem) -> None:
    for now_s, waits in ((NIGHT_S, False), (SIX_S, True)):
        rig = MachineRig("M7", FULL, plant=DAYS)
        rig.now_s = now_s
        rig.start()
        rig.take_goal("G1", production(quantity=2), deadline_s=now_s + 8 * 3600.0)
        rig.report(Broken("it stands", problem))
        rig.run(now_s)
        wanted = rig.heartbeats(MachineHeartbeat)[-1].help
        assert wanted is not UNSET
        assert (0.0 < wanted.until_s - now_s <= BREAKDOWN_S) is waits
