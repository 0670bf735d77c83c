"""Which cause the simulator gives to the time that a machine loses while a storage has promised its load to others."""

from __future__ import annotations

import pytest

from dray.messages import MachineHeartbeat, MachineStatus, TaskBrief
from dray.messages.heartbeat import BufferLevel, GoalBrief, MaterialWait
from dray.plant import default_plant
from dray_sim.run.shortfall import Cause, Shortfall

ONE_LOT = {"shaft": 40}
"""A storage that has a container of shafts, be it promised to another machine."""

SINCE_S = 40.0
FIRST_S = 100.0

SHORT = MaterialWait(item="shaft", quantity=40, short=("S3",), since_s=SINCE_S)
SILENT = MaterialWait(item="shaft", quantity=40, silent=("S3",), since_s=SINCE_S)
FETCHED = TaskBrief(
    task="M8-1", epoch=1, item="shaft", quantity=40, source="S3", destination="M8", deadline_s=900.0
)


class Rack:
    """A storage that has this stock all the time."""

    stock = ONE_LOT


def starved(
    at_s: float, *, waits: tuple[MaterialWait, ...] = (), tasks: tuple[TaskBrief, ...] = ()
) -> MachineHeartbeat:
    """M8 lacks shafts, and nothing else, for its only goal."""
    return MachineHeartbeat(
        machine="M8",
        incarnation=1,
        seq=int(at_s),
        at_s=at_s,
        status=MachineStatus.STARVED,
        goals=(GoalBrief(goal="G1", product="gear-unit-g2", quantity=24, made=0, delivered=0),),
        tasks=tasks,
        buffers=tuple(
            BufferLevel(item=item, level=0 if item == "shaft" else 20, capacity=120)
            for item in ("housing", "shaft", "bearing")
        ),
        waits=waits,
    )


def lost_s(*beats: MachineHeartbeat) -> dict[Cause, float]:
    """The causes of what M8 has lost; the first heartbeat only begins the count."""
    seen = Shortfall(default_plant(), {"S3": Rack()})
    for beat in beats:
        seen.on_message(beat.at_s, "M8", "", beat)
    return dict(seen.lost_s)


def test_a_machine_whose_material_is_promised_to_others_lacks_the_material() -> None:
    beats = [starved(FIRST_S + 10.0 * number, waits=(SHORT,)) for number in range(4)]
    assert lost_s(*beats) == {("material", "shaft"): 30.0}


def test_the_way_of_the_load_that_was_waited_for_counts_for_the_material_too() -> None:
    lost = lost_s(
        starved(FIRST_S),
        starved(FIRST_S + 10.0, waits=(SHORT,)),
        starved(FIRST_S + 20.0, tasks=(FETCHED,)),
        starved(FIRST_S + 30.0, tasks=(FETCHED,)),
    )
    assert lost == {("material", "shaft"): 30.0}


@pytest.mark.parametrize("waits", [(), (SILENT,)])
def test_a_load_that_nobody_waited_for_and_a_silent_station_say_nothing_of_the_material(
    waits: tuple[MaterialWait, ...],
) -> None:
    beats = (
        starved(FIRST_S, waits=waits),
        starved(FIRST_S + 10.0, waits=waits),
        starved(FIRST_S + 20.0, tasks=(FETCHED,)),
    )
    assert lost_s(*beats) == {("buffer", "shaft at M8"): 20.0}


def test_of_two_loads_only_the_one_that_was_waited_for_has_waited() -> None:
    other = TaskBrief(
        task="M8-2", epoch=1, item="shaft", quantity=40, source="S3", destination="M8", deadline_s=900.0
    )
    lost = lost_s(
        starved(FIRST_S, waits=(SHORT,)),
        starved(FIRST_S + 10.0, waits=(SHORT,)),
        starved(FIRST_S + 20.0, tasks=(FETCHED, other)),
        starved(FIRST_S + 30.0, tasks=(other,)),
    )
    assert lost == {("material", "shaft"): 20.0, ("buffer", "shaft at M8"): 10.0}
