"""The strategist goes on with what its earlier life has left."""

from __future__ import annotations

import msgspec
import pytest
from bureau import announced, beats, brief, contract, making, order, reborn, released
from effects import committed, facts, published, sent
from rigs import StrategistRig
from spoken import accepted, goal_bid

from dray.messages import (
    Confirmed,
    GoalClosed,
    OrderCancelled,
    OrderRevoked,
    OrderTaken,
    Release,
    TaskAnnounced,
    Withdrawn,
)
from dray.messages.fact import GoalLost, GoodsDelivered, OrderAccepted, OrderFulfilled, TaskClosed
from dray.protocol.liveness.suspicion import GOAL_SILENCE_S
from dray.protocol.runtime.events import Commit, Effect


def test_what_binds_the_strategist_is_written_down_before_it_is_said() -> None:
    rig = StrategistRig()
    rig.start()
    steps = [rig.on_message("gateway", order(pump=24))]
    [(goal, _, _)] = announced(rig.all)
    rig.on_message("M7", goal_bid(goal, 100.0))
    rig.run(1.0)
    steps += [rig.on_message("M7", accepted(goal)), rig.arrive(goal, 10), rig.arrive(goal, 14)]
    for effects in steps:
        commits = [isinstance(effect, Commit) for effect in effects]
        assert any(commits)
        assert commits == sorted(commits, reverse=True)
        assert not all(commits)


def test_an_order_survives_the_strategist() -> None:
    again = reborn(released(order(pump=24)))
    [(goal, _, quantity)] = announced(again.all)
    assert quantity == 24
    contract(again, goal, "M7")
    again.arrive(goal, 24)
    assert [fact.order for fact in facts(again.all, OrderFulfilled)] == ["O1"]


def test_an_answer_to_an_award_of_an_earlier_life_binds_nobody() -> None:
    rig = released(order(pump=24))
    [(goal, _, _)] = announced(rig.all)
    rig.on_message("M7", goal_bid(goal, 100.0))
    rig.run(1.0)
    again = reborn(rig)
    [message] = published(again.all, TaskAnnounced)
    assert (message.task, message.epoch) == (goal, 2)
    effects = again.on_message("M7", accepted(goal))
    assert sent(effects, Confirmed) == []
    assert sent(effects, Release, to="M7")


def test_a_contract_survives_the_strategist_and_is_confirmed_when_it_is_asked_for() -> None:
    rig, goal = making()
    again = reborn(rig)
    assert announced(again.all) == []
    assert again.admitted(goal) == 24
    effects = again.on_message("M7", accepted(goal, number=7))
    assert sent(effects, Confirmed, to="M7") == [Confirmed(task=goal, epoch=1)]
    beats(again, 60.0, "M7", "M8", goals=(brief(goal),))
    effects = again.arrive(goal, 24)
    assert sent(effects, GoalClosed, to="M7") == [GoalClosed(goal=goal)]
    assert [fact.outcome for fact in facts(effects, TaskClosed)] == ["delivered"]


def test_what_arrived_while_the_strategist_was_away_is_counted_once() -> None:
    rig, goal = making()
    rig.arrive(goal, 5)
    rig.arrived[goal] = 12
    again = reborn(rig)
    assert [fact.quantity for fact in facts(again.all, GoodsDelivered)] == [7]
    once_more = reborn(again, 3)
    assert facts(once_more.all, GoodsDelivered) == []
    effects = once_more.on_message("M7", accepted(goal))
    assert sent(effects, Confirmed, to="M7") == [Confirmed(task=goal, epoch=1, arrived=12)]


def test_an_order_that_was_completed_while_the_strategist_was_away_is_fulfilled() -> None:
    rig, goal = making()
    rig.arrived[goal] = 24
    again = reborn(rig)
    assert sent(again.all, GoalClosed, to="M7")
    assert [fact.order for fact in facts(again.all, OrderFulfilled)] == ["O1"]


def test_a_machine_that_died_with_the_strategist_loses_its_goal_to_another() -> None:
    rig, goal = making()
    again = reborn(rig)
    beats(again, again.now_s + GOAL_SILENCE_S + 1.0, "M8")
    effects = again.gate_answers(goal)
    [lost] = facts(effects, GoalLost)
    assert sent(effects, Withdrawn, to="M7")
    contract(again, lost.successor, "M8")


def test_no_two_goals_ever_have_one_name() -> None:
    rig, goal = making()
    names = {goal}
    for incarnation in (2, 3, 4):
        rig = reborn(rig, incarnation)
        beats(rig, rig.now_s + GOAL_SILENCE_S + 1.0, "M8")
        [lost] = facts(rig.gate_answers(goal), GoalLost)
        goal = lost.successor
        contract(rig, goal, "M7")
        rig.on_message("gateway", order(f"O{incarnation}", g1=40))
        fresh = {goal, *facts(rig.all, OrderAccepted)[-1].goals}
        assert not names & fresh
        names |= fresh


def test_the_next_life_knows_which_ended_orders_were_fulfilled() -> None:
    rig, goal = making()
    rig.arrive(goal, 24)
    rig.on_message("gateway", OrderCancelled(order="O2"))
    later = reborn(reborn(rig), 3)
    effects = later.on_message("gateway", order(pump=24)) + later.on_message("gateway", order("O2", pump=24))
    assert sent(effects, OrderTaken) == [OrderTaken(order="O1", fulfilled=True), OrderTaken(order="O2")]
    assert announced(effects) == []


def test_an_order_that_was_fulfilled_is_not_begun_again_however_many_have_ended_since() -> None:
    rig = StrategistRig()
    rig.start()
    rig.on_message("gateway", order("O0", pump=24))
    [(goal, _, _)] = announced(rig.all)
    contract(rig, goal, "M7")
    rig.arrive(goal, 24)
    for number in range(3000):
        rig.on_message("gateway", OrderCancelled(order=f"O{number + 1}"))
    for each in (rig, reborn(rig)):
        effects = each.on_message("gateway", order("O0", pump=24))
        assert sent(effects, OrderTaken) == [OrderTaken(order="O0", fulfilled=True)]
        assert announced(effects) == []


def test_what_is_forgotten_is_forgotten_on_the_disk_too(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("dray.protocol.strategist.order_book.ENDED_KEPT", 10)
    rig = StrategistRig()
    rig.start()
    for number in range(30):
        rig.on_message("gateway", OrderCancelled(order=f"O{number}"))
        rig.on_message("gateway", OrderRevoked(order=f"R{number}", release=1))
    kept = {f"{kind}{number}" for kind in "OR" for number in range(20, 30)}
    assert committed(rig.all).keys() == kept
    assert set(reborn(rig).memory) == kept


def test_what_is_written_in_a_step_does_not_grow_with_the_orders_in_work() -> None:
    def written(effects: list[Effect]) -> int:
        commits = [effect for effect in effects if isinstance(effect, Commit)]
        return sum(len(msgspec.json.encode(commit.note)) for commit in commits)

    rig = StrategistRig()
    rig.start()
    first = written(rig.on_message("gateway", order("O0000", pump=24, g1=40)))
    [(goal, *_), _] = announced(rig.all)
    for number in range(1, 1000):
        assert written(rig.on_message("gateway", order(f"O{number:04}", pump=24, g1=40))) <= 1.1 * first
    assert written(contract(rig, goal, "M7")) <= 1.1 * first
    assert written(rig.arrive(goal, 12)) <= 1.1 * first
    assert written(rig.on_message("gateway", order("O0999", pump=24, g1=40))) == 0, "nothing has changed"


def test_a_strategist_takes_no_more_orders_than_it_can_remember(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("dray.protocol.strategist.order_book.ORDERS_MAX", 2)
    rig = released(order("O1", pump=24))
    rig.on_message("gateway", order("O2", pump=24))
    effects = rig.on_message("gateway", order("O3", pump=24))
    assert sent(effects, OrderTaken) == []
    assert sent(rig.on_message("gateway", order("O1", pump=24)), OrderTaken) == [OrderTaken(order="O1")]
    rig.on_message("gateway", OrderCancelled(order="O1"))
    assert sent(rig.on_message("gateway", order("O3", pump=24)), OrderTaken) == [OrderTaken(order="O3")]


def test_a_strategist_that_has_lost_its_memory_shuts_the_gate_for_what_it_does_not_know() -> None:
    rig, goal = making()
    rig.arrive(goal, 5)
    again = StrategistRig(incarnation=2)
    again.arrived = rig.arrived
    again.start()
    assert again.admitted(goal) == 0
    effects = again.on_message("gateway", order(pump=19))
    [fact] = facts(effects, OrderAccepted)
    assert goal not in fact.goals
