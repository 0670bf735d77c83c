"""The projection: what heartbeats tell, and what browsers are sent of it."""

from __future__ import annotations

from typing import Any

import pytest
from facts_kit import bid, closed, delta, opened, order, tell, wall_s
from fake_bus import PLANT
from heartbeats import atv_heartbeat, machine_heartbeat
from wall_clock import NOW_S

from dray.gateway.live.projection import Projection
from dray.gateway.live.projection.agents import atvs as atvs_module
from dray.gateway.live.projection.agents import machines as machines_module
from dray.gateway.live.views import BodyWaitView, ProbationView
from dray.messages import (
    AtvStatus,
    BodyWait,
    Brief,
    BufferLevel,
    GoalBrief,
    MachineStatus,
    Phase,
    ProbationBrief,
    Role,
    TaskBrief,
)

# --- heartbeats -------------------------------------------------------------------------------------


def test_a_vehicle_is_seen_as_its_last_heartbeat_told(projection: Projection) -> None:
    vehicle = PLANT.fleet[0]
    transport = Brief(
        task="T1",
        epoch=2,
        role=Role.PRIMARY,
        coordinator="M1",
        phase=Phase.CARRYING,
        item="steel",
        quantity=8,
        due_s=90.0,
    )
    watch = Brief(task="T2", epoch=1, role=Role.SECONDARY, coordinator="M2")
    projection.fold(
        atv_heartbeat(vehicle.id, at_s=50.0, status=AtvStatus.WORKING, task=transport, watches=(watch,))
    )
    view = projection.atvs.view(vehicle.id)
    assert view is not None
    assert (view.type, view.status, view.x_m, view.y_m) == (vehicle.type, "working", 1.0, 2.0)
    assert view.seen_at_s == wall_s(50.0)
    assert view.task is not None
    assert (view.task.phase, view.task.due_at_s) == ("carrying", wall_s(90.0))
    assert (view.watches[0].role, view.watches[0].phase, view.watches[0].due_at_s) == (
        "secondary",
        None,
        None,
    )


def test_what_a_body_waits_for_is_seen_with_the_time_since_when(projection: Projection) -> None:
    wait = BodyWait("its action pick", since_s=38.0, until="that is FINISHED or FAILED")
    projection.fold(atv_heartbeat("ATV1", at_s=50.0, body_wait=wait))
    view = projection.atvs.view("ATV1")
    assert view is not None
    assert view.body_wait == BodyWaitView(what=wait.what, until=wait.until, since_at_s=wall_s(38.0))
    projection.fold(atv_heartbeat("ATV1", 2, at_s=51.0))
    view = projection.atvs.view("ATV1")
    assert view is not None
    assert view.body_wait is None


def test_a_machine_is_seen_as_its_last_heartbeat_told(projection: Projection) -> None:
    machine = PLANT.machines[0]
    goal = GoalBrief(goal="G1", product="P1", quantity=4, made=2, delivered=0)
    brief = TaskBrief(
        task="T1", epoch=1, item="steel", quantity=8, source="S1", destination=machine.id, deadline_s=200.0
    )
    level = BufferLevel(item="steel", level=3, capacity=24, reorder_point=6, on_order=8)
    projection.fold(
        machine_heartbeat(
            machine.id, status=MachineStatus.STARVED, goals=(goal,), tasks=(brief,), buffers=(level,)
        )
    )
    view = projection.machines.view(machine.id)
    assert view is not None
    assert (view.name, view.status, view.goals[0].made) == (machine.name, "starved", 2)
    assert view.tasks[0].deadline_at_s == wall_s(200.0)
    assert (view.buffers[0].level, view.buffers[0].on_order) == (3, 8)


@pytest.mark.parametrize("make", [atv_heartbeat, machine_heartbeat])
def test_who_leaves_or_is_on_probation_is_seen_to(projection: Projection, make: Any) -> None:
    projection.fold(make(seq=1, draining=True))
    assert [view.draining for view in (*projection.atvs.views(), *projection.machines.views())] == [True]
    projection.fold(make(seq=1, incarnation=2, probation=ProbationBrief(of=3, done=1)))
    [view] = (*projection.atvs.views(), *projection.machines.views())
    assert not view.draining
    assert view.probation == ProbationView(of=3, done=1)


@pytest.mark.parametrize("make", [atv_heartbeat, machine_heartbeat])
def test_an_older_heartbeat_and_the_same_again_are_ignored(projection: Projection, make: Any) -> None:
    for heartbeat in (make(seq=5), make(seq=5), make(seq=4, problem="old")):
        projection.fold(heartbeat)
    assert (projection.heard, projection.ignored) == (1, 2)
    seen = (*projection.atvs.views(), *projection.machines.views())
    assert [view.problem for view in seen] == [""]


@pytest.mark.parametrize("make", [atv_heartbeat, machine_heartbeat])
def test_a_new_life_counts_from_one_and_the_old_one_is_over(projection: Projection, make: Any) -> None:
    projection.fold(make(seq=500, at_s=500.0))
    projection.fold(make(seq=1, at_s=501.0, incarnation=2, problem="new"))
    projection.fold(make(seq=501, at_s=502.0, problem="old"))
    seen = (*projection.atvs.views(), *projection.machines.views())
    assert [view.problem for view in seen] == ["new"]


def test_vehicles_and_machines_are_counted_by_status(projection: Projection) -> None:
    for number in range(3):
        projection.fold(atv_heartbeat(f"ATV{number}"))
        projection.fold(machine_heartbeat(f"M{number}"))
    projection.fold(atv_heartbeat("ATV1", seq=2, status=AtvStatus.WORKING))
    projection.fold(machine_heartbeat("M1", seq=2, status=MachineStatus.BLOCKED))
    factory = projection.factory(NOW_S)
    assert factory.atvs_by_status == {"idle": 2, "working": 1}
    assert factory.machines_by_status == {"idle": 2, "blocked": 1}
    for number in range(3):
        projection.fold(atv_heartbeat(f"ATV{number}", seq=3, status=AtvStatus.ERROR))
    assert projection.factory(NOW_S).atvs_by_status == {"error": 3}


def test_a_peer_that_invents_names_does_not_fill_the_memory(
    projection: Projection, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(atvs_module, "joining_max", lambda _known: 2)
    monkeypatch.setattr(machines_module, "joining_max", lambda _known: 2)
    for number in range(5):
        projection.fold(atv_heartbeat(f"X{number}"))
        projection.fold(machine_heartbeat(f"Y{number}"))
    assert [view.id for view in projection.atvs.views()] == ["X0", "X1"]
    assert [view.id for view in projection.machines.views()] == ["Y0", "Y1"]
    assert projection.atvs.strangers == projection.machines.strangers == 3
    for known in ("ATV1", "X1"):
        projection.fold(atv_heartbeat(known, seq=2, problem="known ones are still heard"))
    assert [view.id for view in projection.atvs.views() if view.problem] == ["ATV1", "X1"]
    projection.look(NOW_S)
    assert [alert.kind for alert in projection.alerts.views()].count("strangers") == 1


def test_starvation_is_the_part_of_time_with_a_goal_in_which_material_was_missing(
    projection: Projection,
) -> None:
    goals = (GoalBrief(goal="G1", product="P1", quantity=4, made=0, delivered=0),)
    told = [
        (MachineStatus.IDLE, ()),
        (MachineStatus.STARVED, goals),
        (MachineStatus.PRODUCING, goals),
        (MachineStatus.PRODUCING, goals),
        (MachineStatus.PRODUCING, goals),
    ]
    assert projection.factory(wall_s(0.0)).starved_frac is None
    for seq, (status, its_goals) in enumerate(told, 1):
        projection.fold(machine_heartbeat(seq=seq, at_s=5.0 * seq, status=status, goals=its_goals))
    assert projection.factory(wall_s(25.0)).starved_frac == pytest.approx(1 / 3)
    assert projection.factory(wall_s(25.0 + 2 * 3600.0)).starved_frac is None


def test_a_machine_that_was_silent_did_not_starve_all_the_while(projection: Projection) -> None:
    goals = (GoalBrief(goal="G1", product="P1", quantity=4, made=0, delivered=0),)
    starved, producing = MachineStatus.STARVED, MachineStatus.PRODUCING
    for seq, (at_s, status) in enumerate([(0.0, starved), (1000.0, producing), (1015.0, producing)], 1):
        projection.fold(machine_heartbeat(seq=seq, at_s=at_s, status=status, goals=goals))
    assert projection.factory(wall_s(1015.0)).starved_frac == pytest.approx(0.5)


# --- frames -----------------------------------------------------------------------------------------


def test_a_delta_holds_what_has_changed_since_the_last_one_and_nothing_else(projection: Projection) -> None:
    projection.orders.put(order())
    for number in range(3):
        projection.fold(atv_heartbeat(f"ATV{number}"))
        projection.fold(machine_heartbeat(f"M{number}"))
    tell(projection, "M1", opened("T1"), opened("T2"))
    delta(projection)
    assert not projection.changed
    projection.fold(atv_heartbeat("ATV1", seq=2))
    tell(projection, "M1", bid("ATV1"))
    told = projection.delta(7, NOW_S, None)
    assert [view.id for view in told.atvs] == ["ATV1"]
    assert [view.id for view in told.tasks] == ["T1"]
    assert (told.number, told.machines, told.orders, told.gone) == (7, (), (), ())


def test_what_has_changed_often_is_told_once(projection: Projection) -> None:
    for seq in range(1, 6):
        projection.fold(atv_heartbeat(seq=seq, speed_mps=float(seq)))
    assert [view.speed_mps for view in delta(projection).atvs] == [5.0]


def test_a_snapshot_holds_everything_and_leaves_the_next_delta_as_it_is(projection: Projection) -> None:
    projection.orders.put(order())
    projection.fold(atv_heartbeat())
    projection.fold(machine_heartbeat())
    tell(projection, "M1", opened("T1"), opened("T2"), closed("T2"))
    snapshot = projection.snapshot(3, NOW_S)
    assert (snapshot.number, snapshot.plant) == (3, PLANT.plant)
    told = delta(projection)
    for kind in ("atvs", "machines", "tasks", "orders"):
        assert getattr(snapshot, kind)
        assert getattr(snapshot, kind) == getattr(told, kind)


def test_changes_that_nobody_looks_at_are_not_gathered(projection: Projection) -> None:
    projection.fold(atv_heartbeat())
    projection.discard_changes()
    assert not projection.changed
    assert delta(projection).atvs == ()
    assert projection.snapshot(1, NOW_S).atvs
