"""A factory with doors: vehicles pass them, none is shut on, and one that fails is told, gone round and forgotten."""

from __future__ import annotations

from functools import partial

import pytest
from msgspec.structs import replace
from variants import variants

from dray.messages import AtvHeartbeat, ObstacleSeen
from dray.messages.floor.obstacle import FORGOTTEN_S
from dray.plant import Door, LaneEnds, Plant, default_plant, load_plant
from dray.protocol.closures.obstacles import lane_of
from dray_sim.bodies.doors import DoorState
from dray_sim.run.evidence import HELD
from dray_sim.run.stage import Shift, Stage, play, with_right_of_way

ACROSS = (("c1", "m11-lane"), ("c2", "m8-lane"), ("c3", "m5-lane"), ("c4", "m2-lane"), ("s8-lane", "d5"))
"""Every road from the left half of the default plant to the right one."""

PLANT = Plant(
    replace(
        default_plant().file,
        doors=tuple(
            Door(f"D{number}", f"Door {number}", (LaneEnds(start, end),), 6.0)
            for number, (start, end) in enumerate(ACROSS, 1)
        ),
    )
)

SHIFT = Shift("doors", 900.0, load=0.8, stock_frac=(0.02, 0.15), keep=(ObstacleSeen,))

FAILS_S, MENDED_S = 100, 600


async def look(stage: Stage, failing: tuple[str, ...]) -> tuple[int, list[ObstacleSeen]]:
    """Let some doors fail and be put right again; how often one stood open, and what was told of them."""
    doors = stage.factory.floor.doors
    acts = {FAILS_S: doors.fail, MENDED_S: doors.repair}
    opened = 0
    before: dict[str, DoorState] = {}
    for second in range(1, int(stage.shift.duration_s) + 1):
        await stage.until_s(second)
        for door in failing if second in acts else ():
            acts[second](door)
        states = doors.states
        opened += sum(
            state is DoorState.OPEN and before.get(door) is not state for door, state in states.items()
        )
        before = states
    return opened, [seen.said for seen in stage.witness.all(ObstacleSeen)]


@pytest.mark.parametrize("traffic", variants([True, False]))
def test_vehicles_pass_doors_all_day_and_nothing_of_it_is_an_obstacle(traffic: bool) -> None:
    with with_right_of_way(traffic):
        played = play(SHIFT, PLANT, 1, partial(look, failing=()))
    assert played.report.invariants == HELD
    assert played.result is not None
    opened, told = played.result
    assert opened
    assert not told


@pytest.mark.parametrize("traffic", variants([True, False]))
def test_doors_that_fail_are_told_gone_round_and_known_to_be_right_again(traffic: bool) -> None:
    failing = ("D1", "D2", "D3", "D4")
    with with_right_of_way(traffic):
        played = play(SHIFT, PLANT, 1, partial(look, failing=failing))
    assert played.report.invariants == HELD
    assert played.result is not None
    opened, told = played.result
    lanes = {lane for lane, door in PLANT.door_on.items() if door.id in failing}
    there = {lane_of(seen.start, seen.end) for seen in told if seen.there}
    assert there
    assert there <= {lane_of(*lane) for lane in lanes}
    assert opened


async def shut_in_docks(stage: Stage) -> list[tuple[float, AtvHeartbeat]]:
    """The door of some docks fails for good; all heartbeats that tell of it without a task, by the time."""
    await stage.until_s(FAILS_S)
    stage.factory.floor.doors.fail("D1")
    await stage.until_s(stage.shift.duration_s)
    beats = [(seen.at_s, seen.said) for seen in stage.witness.all(AtvHeartbeat)]
    return [(at_s, beat) for at_s, beat in beats if beat.problem and beat.task is None]


def test_who_has_no_task_any_more_leaves_a_failed_door_and_who_is_shut_in_says_so() -> None:
    plant = load_plant("single-track")
    docks = {plant.node_of(machine) for machine in ("M1", "M10", "M11", "M12", "M2", "M3")}
    lanes = tuple(
        LaneEnds(lane.start, lane.end) for lane in plant.file.lanes if docks & {lane.start, lane.end}
    )
    plant = Plant(replace(plant.file, doors=(Door("D1", "Door 1", lanes, 6.0),)))
    shift = Shift("doors", 1400.0, load=0.8, stock_frac=(0.02, 0.15), keep=(AtvHeartbeat,))
    for seed in range(3, 12):
        with with_right_of_way(True):
            played = play(shift, plant, seed, shut_in_docks)
        assert played.report.invariants == HELD
        assert played.result is not None
        away: dict[tuple[str, str], list[float]] = {}
        shut_in = [beat for _, beat in played.result if beat.node in docks]
        for beat in shut_in:
            assert beat.problem == f"the door Door 1 does not open, and no lane leads back from {beat.node}"
        for at_s, beat in played.result:
            if beat.node not in docks:
                away.setdefault((beat.atv, beat.node), []).append(at_s)
        # Something else lies on every way from there: it leaves when that is forgotten.
        assert all(moments[-1] - moments[0] <= FORGOTTEN_S for moments in away.values())
        if shut_in:
            return
    pytest.fail("nobody was shut in, in nine shifts")
