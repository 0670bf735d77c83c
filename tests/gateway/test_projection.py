"""From heartbeats and facts to what panels see."""

from __future__ import annotations

from random import Random
from typing import Any

import pytest
from gateway_kit import NOW_S, PLANT, atv_heartbeat, events, machine_heartbeat

from dray.gateway.frames import Delta
from dray.gateway.projection import Projection
from dray.gateway.projection import atvs as atvs_module
from dray.gateway.projection import machines as machines_module
from dray.gateway.projection import tasks as tasks_module
from dray.gateway.projection.bids import MAX_BIDS
from dray.gateway.projection.early import EARLY_KEPT
from dray.gateway.projection.orders import ENDED_KEPT
from dray.gateway.projection.tasks import CLOSED_KEPT
from dray.gateway.timescale import TimeScale
from dray.gateway.views import TaskView, TrialView
from dray.messages import (
    AtvStatus,
    Brief,
    BufferLevel,
    GoalBrief,
    MachineStatus,
    OrderTaken,
    Phase,
    Production,
    ProductionCost,
    Refusal,
    Role,
    TaskBrief,
    Transport,
    TransportCost,
    TrialBrief,
)
from dray.messages.fact import (
    AnyFact,
    AwardAnswered,
    AwardGiven,
    BidReceived,
    BidRefused,
    ContractTaken,
    GoalContracted,
    GoalWaits,
    GoodsDelivered,
    OrderAccepted,
    PhaseEntered,
    PieceMade,
    RoundFailed,
    TaskClosed,
    TaskOpened,
    WatchLost,
)
from dray.store.orders import Item, Order, OrderTotals
from dray.store.progress import Goal, OrderStatus

SPEED = 10.0
"""Plant seconds per wall second, so that a time that was not turned is seen."""


@pytest.fixture
def projection() -> Projection:
    return Projection(PLANT, TimeScale(0.0, NOW_S, SPEED))


def wall_s(plant_s: float) -> float:
    return NOW_S + plant_s / SPEED


def tell(projection: Projection, agent: str, *facts: AnyFact, at_s: float = 100.0) -> None:
    for event in events(agent, *facts, at_s=at_s):
        projection.fold(event)


def delta(projection: Projection) -> Delta:
    return projection.delta(1, NOW_S, None)


# --- facts about one transport, T1 of M1 ---------------------------------------------------------

FETCH = Transport(item="steel", quantity=8, sources=("S1", "S2"), destination="M1", ability="tote", goal="G1")


def opened(task: str = "T1", epoch: int = 1, round: int = 1, **fields: Any) -> TaskOpened:  # noqa: A002 - the fact's own word
    usual: dict[str, Any] = {
        "role": Role.PRIMARY,
        "work": FETCH,
        "radius_m": 15.0 * round,
        "deadline_s": 400.0,
        "bids_until_s": 101.0,
    }
    return TaskOpened(task=task, epoch=epoch, round=round, **usual | fields)


def bid(bidder: str, total_s: float = 40.0, epoch: int = 1, **fields: Any) -> BidReceived:
    usual: dict[str, Any] = {
        "task": "T1",
        "role": Role.PRIMARY,
        "round": 1,
        "cost": TransportCost(empty_way_s=total_s - 6.0, loaded_way_s=3.0, energy_s=2.0, suitability_s=1.0),
        "finish_s": 200.0 + total_s,
        "source": "S2",
    }
    return BidReceived(bidder=bidder, total_s=total_s, epoch=epoch, **usual | fields)


def award(bidder: str, epoch: int = 1, role: Role = Role.PRIMARY) -> AwardGiven:
    return AwardGiven(task="T1", epoch=epoch, role=role, bidder=bidder, rank=1)


def answer(bidder: str, word: str = "accepted", epoch: int = 1, role: Role = Role.PRIMARY) -> AwardAnswered:
    return AwardAnswered(task="T1", epoch=epoch, role=role, bidder=bidder, answer=word)


def refused(reason: Refusal = Refusal.BATTERY, epoch: int = 1, detail: str = "") -> BidRefused:
    return BidRefused(task="T1", epoch=epoch, role=Role.PRIMARY, reason=reason, detail=detail)


def phase(step: Phase, epoch: int = 1) -> PhaseEntered:
    return PhaseEntered(task="T1", epoch=epoch, phase=step, station="S2")


def closed(task: str = "T1", epoch: int = 1, outcome: str = "delivered", **fields: Any) -> TaskClosed:
    return TaskClosed(task=task, epoch=epoch, outcome=outcome, **{"carrier": "ATV2"} | fields)


def task(projection: Projection, name: str = "T1") -> TaskView:
    view = projection.tasks.view(name)
    assert view is not None
    return view


# --- tasks ---------------------------------------------------------------------------------------


def test_a_task_is_seen_as_it_was_announced(projection: Projection) -> None:
    tell(projection, "M1", opened())
    view = task(projection)
    assert (view.kind, view.coordinator, view.item, view.quantity) == ("transport", "M1", "steel", 8)
    assert (view.sources, view.source, view.destination, view.goal) == (("S1", "S2"), "", "M1", "G1")
    assert (view.state, view.epoch, view.round, view.radius_m) == ("bidding", 1, 1, 15.0)
    assert (view.opened_at_s, view.deadline_at_s) == (wall_s(101.0), wall_s(400.0))


def test_bids_are_seen_with_the_parts_of_their_price(projection: Projection) -> None:
    tell(projection, "M1", opened(), bid("ATV1", 50.0), bid("ATV2", 40.0))
    first, second = task(projection).bids
    assert (first.bidder, second.bidder) == ("ATV1", "ATV2")
    assert first.parts_s == {"empty_way": 44.0, "loaded_way": 3.0, "energy": 2.0, "suitability": 1.0}
    assert sum(first.parts_s.values()) == first.total_s
    assert first.finish_at_s == wall_s(250.0)
    assert first.answer == ""


def test_a_production_goal_is_a_task_that_names_its_order(projection: Projection) -> None:
    work = Production(product="P1", quantity=4, order="O-1", item=0)
    cost = ProductionCost(queue_s=1.0, material_s=2.0, making_s=3.0)
    tell(projection, "strategist", opened("G1", work=work), bid("M1", 6.0, task="G1", cost=cost))
    view = task(projection, "G1")
    assert (view.kind, view.item, view.goal, view.order) == ("production", "P1", "G1", "O-1")
    assert view.bids[0].parts_s == {"queue": 1.0, "material": 2.0, "making": 3.0}


def test_who_refused_is_seen_with_the_reason(projection: Projection) -> None:
    tell(projection, "M1", opened())
    tell(projection, "ATV3", refused(detail="12 %"))
    (refusal,) = task(projection).refusals
    assert (refusal.agent, refusal.role, refusal.round) == ("ATV3", "primary", 1)
    assert (refusal.reason, refusal.detail) == ("battery", "12 %")


def test_a_bid_and_a_refusal_that_come_twice_are_seen_once(projection: Projection) -> None:
    for _ in range(2):
        tell(projection, "M1", opened(), bid("ATV1"))
        tell(projection, "ATV3", refused())
    assert len(task(projection).bids) == 1
    assert len(task(projection).refusals) == 1


def test_bids_and_refusals_are_bounded_and_the_newest_stay(projection: Projection) -> None:
    tell(projection, "M1", opened(), *(bid(f"ATV{n}") for n in range(2 * MAX_BIDS)))
    for number in range(2 * MAX_BIDS):
        tell(projection, f"ATV{number}", refused())
    view = task(projection)
    newest = [f"ATV{n}" for n in range(MAX_BIDS, 2 * MAX_BIDS)]
    assert [bid.bidder for bid in view.bids] == newest
    assert [refusal.agent for refusal in view.refusals] == newest


def test_every_award_shows_what_became_of_it(projection: Projection) -> None:
    tell(projection, "M1", opened(), *(bid(f"ATV{n}") for n in range(1, 5)))
    tell(projection, "M1", award("ATV3"), answer("ATV3", "busy"), award("ATV1"), answer("ATV1", "silent"))
    tell(projection, "M1", award("ATV2"))
    answers = {bid.bidder: bid.answer for bid in task(projection).bids}
    assert answers == {"ATV1": "silent", "ATV2": "asked", "ATV3": "busy", "ATV4": ""}
    assert (task(projection).state, task(projection).primary) == ("bidding", "")


def test_an_accepted_award_names_the_carrier_its_source_and_its_promise(projection: Projection) -> None:
    tell(projection, "M1", opened(), bid("ATV2", 40.0), award("ATV2"), answer("ATV2"))
    view = task(projection)
    assert (view.state, view.primary, view.source) == ("contracted", "ATV2", "S2")
    assert (view.contracted_at_s, view.promised_at_s) == (wall_s(104.0), wall_s(240.0))
    assert view.bids[0].answer == "accepted"


def test_a_watch_is_elected_and_lost(projection: Projection) -> None:
    tell(projection, "M1", opened(), answer("ATV2"), answer("ATV1", role=Role.SECONDARY))
    assert (task(projection).primary, task(projection).secondary) == ("ATV2", "ATV1")
    tell(projection, "M1", WatchLost(task="T1", epoch=1, secondary="ATV9", reason="silent"))
    assert task(projection).secondary == "ATV1"
    tell(projection, "M1", WatchLost(task="T1", epoch=1, secondary="ATV1", reason="silent"))
    assert task(projection).secondary == ""


def test_the_search_for_a_watch_leaves_the_contract_alone(projection: Projection) -> None:
    tell(projection, "M1", opened(), bid("ATV2"), answer("ATV2"))
    tell(projection, "M1", opened(role=Role.SECONDARY, round=4, radius_m=99.0))
    tell(
        projection,
        "M1",
        RoundFailed(task="T1", epoch=1, role=Role.SECONDARY, round=4, bids=0, next_round_s=1.0),
    )
    view = task(projection)
    assert (view.state, view.primary, view.round, view.radius_m) == ("contracted", "ATV2", 1, 15.0)


def test_a_round_without_a_contract_leads_to_a_wider_one(projection: Projection) -> None:
    failed = RoundFailed(task="T1", epoch=1, role=Role.PRIMARY, round=1, bids=0, next_round_s=110.0)
    tell(projection, "M1", opened(), failed, opened(round=2))
    assert (task(projection).round, task(projection).radius_m) == (2, 30.0)
    tell(projection, "ATV3", refused())
    assert task(projection).refusals[-1].round == 2


@pytest.mark.parametrize("step", list(Phase))
def test_a_carriage_is_followed_step_by_step(projection: Projection, step: Phase) -> None:
    tell(projection, "M1", opened(), bid("ATV2"), answer("ATV2"))
    tell(projection, "ATV2", phase(step))
    assert (task(projection).phase, task(projection).primary) == (step.value, "ATV2")


@pytest.mark.parametrize(("outcome", "state"), [("delivered", "delivered"), ("withdrawn", "withdrawn")])
def test_a_task_that_ended_is_still_seen(projection: Projection, outcome: str, state: str) -> None:
    tell(projection, "M1", opened(), bid("ATV2"), answer("ATV2"))
    tell(projection, "M1", closed(outcome=outcome, promised_s=250.0), at_s=300.0)
    view = task(projection)
    assert (view.state, view.primary, view.phase) == (state, "ATV2", "")
    assert (view.closed_at_s, view.promised_at_s) == (wall_s(301.0), wall_s(250.0))
    assert view in projection.tasks.views()


def test_a_task_that_ended_stays_as_it_is(projection: Projection) -> None:
    tell(projection, "M1", opened(), answer("ATV2"), closed())
    delta(projection)
    tell(
        projection, "M1", opened(), opened(epoch=2), answer("ATV5"), bid("ATV5"), closed(outcome="withdrawn")
    )
    tell(projection, "ATV5", phase(Phase.CARRYING))
    assert (task(projection).state, task(projection).primary) == ("delivered", "ATV2")
    assert not projection.changed


def test_only_the_last_fifty_that_ended_are_kept_and_the_others_are_said_to_be_gone(
    projection: Projection,
) -> None:
    names = [f"T{number}" for number in range(CLOSED_KEPT + 3)]
    for name in names:
        tell(projection, "M1", opened(name), closed(name))
    assert [view.id for view in projection.tasks.views()] == names[3:]
    told = delta(projection)
    assert [view.id for view in told.tasks] == names[3:]
    assert told.gone == ("task:T0", "task:T1", "task:T2")
    assert delta(projection).gone == ()


def test_open_tasks_are_bounded_and_the_oldest_leaves(
    projection: Projection, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tasks_module, "MAX_OPEN", 2)
    tell(projection, "M1", opened("T1"), opened("T2"), opened("T3"))
    assert [view.id for view in projection.tasks.views()] == ["T2", "T3"]
    assert delta(projection).gone == ("task:T1",)


# --- what comes late, twice or too early ---------------------------------------------------------


def test_an_announcement_that_comes_again_does_not_undo_the_contract(projection: Projection) -> None:
    tell(projection, "M1", opened(), bid("ATV2"), award("ATV2"), answer("ATV2"))
    tell(projection, "ATV2", phase(Phase.CARRYING))
    delta(projection)
    tell(projection, "M1", opened())
    view = task(projection)
    assert (view.state, view.primary, view.phase) == ("contracted", "ATV2", "carrying")
    assert not projection.changed


def test_a_later_round_that_comes_after_its_contract_does_not_undo_it(projection: Projection) -> None:
    tell(projection, "M1", opened(), answer("ATV2"), opened(round=2))
    view = task(projection)
    assert (view.state, view.primary, view.round, view.radius_m) == ("contracted", "ATV2", 2, 30.0)


def test_an_earlier_round_that_comes_late_narrows_nothing(projection: Projection) -> None:
    tell(projection, "M1", opened(), opened(round=3), opened(round=2))
    assert (task(projection).round, task(projection).radius_m) == (3, 45.0)


def test_what_contractors_say_before_the_announcement_is_kept(projection: Projection) -> None:
    tell(projection, "ATV3", refused())
    tell(projection, "ATV2", phase(Phase.APPROACHING))
    assert projection.tasks.view("T1") is None
    tell(projection, "M1", opened())
    view = task(projection)
    assert [refusal.agent for refusal in view.refusals] == ["ATV3"]
    assert (view.phase, view.primary) == ("approaching", "ATV2")


def test_that_nobody_can_make_a_goal_is_kept_until_its_announcement(projection: Projection) -> None:
    tell(projection, "strategist", GoalWaits(goal="G1", order="O-1", reason="M1 is silent"))
    work = Production(product="P1", quantity=4, order="O-1", item=0)
    tell(projection, "strategist", opened("G1", work=work))
    assert task(projection, "G1").trouble == "M1 is silent"


def test_what_came_before_its_announcement_is_bounded(projection: Projection) -> None:
    for number in range(2 * EARLY_KEPT):
        tell(projection, f"ATV{number}", refused())
    tell(projection, "M1", opened())
    assert len(task(projection).refusals) <= MAX_BIDS
    assert task(projection).refusals[-1].agent == f"ATV{2 * EARLY_KEPT - 1}"


def test_a_new_epoch_forgets_the_carrier_and_its_promise(projection: Projection) -> None:
    tell(projection, "M1", opened(), bid("ATV2"), answer("ATV2"))
    tell(projection, "ATV2", phase(Phase.CARRYING))
    tell(projection, "M1", opened(epoch=2))
    view = task(projection)
    assert (view.state, view.epoch, view.primary, view.phase, view.source) == ("bidding", 2, "", "", "")
    assert (view.contracted_at_s, view.promised_at_s) == (None, None)


def test_what_tells_of_an_older_epoch_is_ignored(projection: Projection) -> None:
    tell(projection, "M1", opened(epoch=2), bid("ATV1", epoch=2), answer("ATV1", epoch=2))
    delta(projection)
    lost = WatchLost(task="T1", epoch=1, secondary="", reason="silent")
    failed = RoundFailed(task="T1", epoch=1, role=Role.PRIMARY, round=9, bids=0, next_round_s=1.0)
    tell(projection, "M1", opened(), bid("ATV2"), award("ATV1"), answer("ATV2"), lost, failed)
    tell(projection, "ATV2", phase(Phase.RETURNING), refused())
    assert (task(projection).primary, len(task(projection).bids), task(projection).round) == ("ATV1", 1, 1)
    assert not projection.changed


def test_a_secondary_that_takes_over_is_the_carrier(projection: Projection) -> None:
    tell(projection, "M1", opened(), answer("ATV2"), answer("ATV1", role=Role.SECONDARY))
    taken = ContractTaken(task="T1", epoch=2, role=Role.PRIMARY, coordinator="M1")
    tell(projection, "ATV1", taken)
    view = task(projection)
    assert (view.state, view.epoch, view.primary, view.secondary) == ("contracted", 2, "ATV1", "")
    tell(projection, "ATV2", phase(Phase.CARRYING))
    assert task(projection).primary == "ATV1"


def test_facts_that_tell_of_nothing_shown_and_other_messages_are_counted_and_ignored(
    projection: Projection,
) -> None:
    tell(projection, "M1", PieceMade(goal="G9", product="P1", made=1), closed("T9"))
    projection.fold(OrderTaken(order="O-1"))
    assert (projection.heard, projection.ignored, projection.changed) == (0, 3, False)


# --- heartbeats ----------------------------------------------------------------------------------


def test_a_vehicle_is_seen_as_its_last_heartbeat_told(projection: Projection) -> None:
    vehicle = PLANT.fleet[0]
    carriage = Brief(
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
        atv_heartbeat(vehicle.id, at_s=50.0, status=AtvStatus.WORKING, task=carriage, watches=(watch,))
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
def test_who_leaves_or_is_on_trial_is_seen_to(projection: Projection, make: Any) -> None:
    projection.fold(make(seq=1, leaving=True))
    assert [view.leaving for view in (*projection.atvs.views(), *projection.machines.views())] == [True]
    projection.fold(make(seq=1, incarnation=2, trial=TrialBrief(of=3, done=1)))
    [view] = (*projection.atvs.views(), *projection.machines.views())
    assert not view.leaving
    assert view.trial == TrialView(of=3, done=1)


@pytest.mark.parametrize("make", [atv_heartbeat, machine_heartbeat])
def test_an_older_heartbeat_and_the_same_again_are_ignored(projection: Projection, make: Any) -> None:
    for heartbeat in (make(seq=5), make(seq=5), make(seq=4, problem="old")):
        projection.fold(heartbeat)
    assert (projection.heard, projection.ignored) == (1, 2)
    seen = (*projection.atvs.views(), *projection.machines.views())
    assert [view.problem for view in seen] == [""]


@pytest.mark.parametrize("make", [atv_heartbeat, machine_heartbeat])
def test_a_new_life_counts_from_one_and_the_old_one_is_over(projection: Projection, make: Any) -> None:
    projection.fold(make(seq=500))
    projection.fold(make(seq=1, incarnation=2, problem="new"))
    projection.fold(make(seq=501, problem="old"))
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
    monkeypatch.setattr(atvs_module, "MAX_ATVS", 2)
    monkeypatch.setattr(machines_module, "MAX_MACHINES", 2)
    for number in range(5):
        projection.fold(atv_heartbeat(f"ATV{number}"))
        projection.fold(machine_heartbeat(f"M{number}"))
    assert [view.id for view in projection.atvs.views()] == ["ATV0", "ATV1"]
    assert [view.id for view in projection.machines.views()] == ["M0", "M1"]
    projection.fold(atv_heartbeat("ATV1", seq=2, problem="known ones are still heard"))
    assert projection.atvs.views()[1].problem


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


# --- orders --------------------------------------------------------------------------------------


def order(name: str = "O-1", *quantities: int, **fields: Any) -> Order:
    usual: dict[str, Any] = {
        "status": OrderStatus.RELEASED,
        "releases": 1,
        "customer": "Customer",
        "token": f"token-{name}",
        "created_at_s": NOW_S,
    }
    items = tuple(Item(f"P{index}", quantity) for index, quantity in enumerate(quantities or (4,), 1))
    return Order(id=name, items=items, **usual | fields)


def contracted(goal: str = "G1", item: int = 0, quantity: int = 4, of: str = "O-1") -> GoalContracted:
    return GoalContracted(
        goal=goal, order=of, item=item, product=f"P{item + 1}", quantity=quantity, machine="M1", finish_s=9.0
    )


def made(count: int, goal: str = "G1", item: int = 0) -> PieceMade:
    return PieceMade(goal=goal, product=f"P{item + 1}", made=count)


def arrived(count: int, goal: str = "G1", item: int = 0, of: str = "O-1") -> GoodsDelivered:
    return GoodsDelivered(goal=goal, order=of, item=item, product=f"P{item + 1}", quantity=2, delivered=count)


def seen(projection: Projection, name: str = "O-1") -> tuple[str, list[tuple[int, int]]]:
    """The status of an order, and per item what is made and delivered."""
    (view,) = [view for view in projection.orders.views() if view.id == name]
    return view.status, [(item.made, item.delivered) for item in view.items]


def test_an_order_is_followed_from_its_release_to_its_last_piece(projection: Projection) -> None:
    projection.orders.put(order("O-1", 4, 2, due_at_s=wall_s(1000.0)))
    assert seen(projection) == ("released", [(0, 0), (0, 0)])
    told: list[tuple[AnyFact, str]] = [
        (OrderAccepted(order="O-1", goals=("G1", "G2")), "released"),
        (contracted(), "in_production"),
        (contracted("G2", 1, 2), "in_production"),
        (made(4), "in_production"),
        (made(2, "G2", 1), "in_delivery"),
        (arrived(4), "in_delivery"),
        (arrived(2, "G2", 1), "delivered"),
    ]
    for fact, status in told:
        tell(projection, "somebody", fact, at_s=500.0)
        assert seen(projection)[0] == status
    factory = projection.factory(NOW_S)
    assert (factory.orders_open, factory.orders_delivered, factory.on_time_frac) == (0, 1, 1.0)
    assert projection.orders.views()[0].delivered_at_s == wall_s(501.0)


def test_facts_of_an_order_in_any_order_and_twice_end_the_same(projection: Projection) -> None:
    told = events(
        "somebody", contracted(), contracted("G2", 1, 2), made(2), made(4), arrived(2), arrived(4),
        made(2, "G2", 1), arrived(2, "G2", 1),
    )  # fmt: skip
    for seed in range(20):
        shuffled = [*told, *told]
        Random(seed).shuffle(shuffled)
        one = Projection(PLANT, TimeScale(0.0, NOW_S, SPEED))
        one.orders.put(order("O-1", 4, 2))
        for event in shuffled:
            one.fold(event)
        assert seen(one) == ("delivered", [(4, 4), (2, 2)])
        assert one.factory(NOW_S).orders_delivered == 1


def test_what_is_delivered_after_its_due_time_is_not_on_time(projection: Projection) -> None:
    projection.orders.begin([], OrderTotals(delivered=3, on_time=3))
    projection.orders.put(order(due_at_s=wall_s(50.0)))
    tell(projection, "M1", arrived(4), at_s=100.0)
    assert projection.factory(NOW_S).on_time_frac == 0.75


def test_a_stored_order_moves_only_when_it_is_released(projection: Projection) -> None:
    projection.orders.put(order(status=OrderStatus.STORED))
    tell(projection, "strategist", contracted())
    assert seen(projection)[0] == "stored"
    projection.orders.put(order(status=OrderStatus.RELEASED))
    assert seen(projection)[0] == "in_production"


def test_a_cancelled_order_stays_cancelled_whatever_still_arrives(projection: Projection) -> None:
    projection.orders.put(order())
    projection.orders.put(order(status=OrderStatus.CANCELLED))
    tell(projection, "M1", contracted(), arrived(4))
    assert seen(projection) == ("cancelled", [(4, 4)])
    projection.orders.put(order())
    assert seen(projection)[0] == "cancelled"
    assert projection.factory(NOW_S).orders_delivered == 0


def test_what_sql_says_late_does_not_take_back_what_was_heard(projection: Projection) -> None:
    projection.orders.put(order())
    tell(projection, "M1", contracted(), arrived(2))
    projection.orders.put(order())
    assert seen(projection) == ("in_delivery", [(2, 2)])


def test_after_a_restart_orders_stand_where_sql_left_them(projection: Projection) -> None:
    kept = order(status=OrderStatus.IN_DELIVERY, incarnation=1)
    kept.items[0].made = kept.items[0].delivered = 2
    goal = Goal("G1", "O-1", 0, "P1", 4, "M1", incarnation=1, made=2, delivered=2)
    projection.orders.begin([(kept, [goal])], OrderTotals(delivered=7, on_time=7))
    assert seen(projection) == ("in_delivery", [(2, 2)])
    for event in events(
        "strategist", OrderAccepted(order="O-1", goals=("Gr2",)), contracted("Gr2", 0, 2), life=2
    ):
        projection.fold(event)
    tell(projection, "M1", arrived(2, "Gr2"))
    assert seen(projection) == ("delivered", [(4, 4)])
    assert projection.factory(NOW_S).orders_delivered == 8


def test_only_the_last_fifty_orders_that_ended_are_kept(projection: Projection) -> None:
    names = [f"O-{number}" for number in range(ENDED_KEPT + 2)]
    for name in names:
        projection.orders.put(order(name))
        tell(projection, "M1", arrived(4, f"G-{name}", of=name))
    projection.orders.put(order("O-open"))
    assert [view.id for view in projection.orders.views()] == [*names[2:], "O-open"]
    assert delta(projection).gone == ("order:O-0", "order:O-1")
    # An ended one that is not shown any more is told of again: it is counted once.
    tell(projection, "M1", arrived(4, "G-O-0", of="O-0"))
    assert projection.factory(NOW_S).orders_delivered == len(names)


def test_an_event_about_an_order_that_nobody_placed_here_changes_nothing(projection: Projection) -> None:
    tell(projection, "M1", contracted(of="O-9"), arrived(4, of="O-9"))
    assert projection.orders.views() == ()
    assert not projection.changed


# --- frames --------------------------------------------------------------------------------------


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


# --- figures of transports -----------------------------------------------------------------------


def test_transports_are_measured_from_the_announcement_to_the_handover(projection: Projection) -> None:
    for number in range(1, 21):
        tell(projection, "M1", opened(f"T{number}"), at_s=100.0)
        tell(projection, "M1", closed(f"T{number}"), at_s=100.0 + number)
    tell(projection, "M1", opened("T-withdrawn"), at_s=100.0)
    tell(projection, "M1", closed("T-withdrawn", outcome="withdrawn"), at_s=900.0)
    factory = projection.factory(wall_s(130.0))
    assert (factory.transport_p50_s, factory.transport_p95_s) == (10.0, 19.0)
    assert factory.deliveries_per_hour == (0.0,) * 11 + (240.0,)
    assert projection.factory(wall_s(2 * 3600.0)).deliveries_per_hour == (0.0,) * 12
