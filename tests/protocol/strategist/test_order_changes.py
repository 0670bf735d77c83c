"""An order in work is changed: at once where nobody has begun, else as far as machines can still spare it."""

from __future__ import annotations

import pytest
from bureau import announced, beats, brief, contract_all, making, order, reborn, released
from effects import facts, instructed, sent
from msgspec.structs import replace
from rigs import MachineRig, StrategistRig
from spoken import mhb, production

from dray.body import Admit
from dray.messages import (
    GoalRevised,
    GoalRevisionTaken,
    OrderReleased,
    OrderTaken,
)
from dray.messages.base import COUNT_MAX
from dray.messages.fact import GoalReduced, OrderChanged, OrderFulfilled
from dray.messages.overtaken import OVERTAKES_S
from dray.protocol.runtime.events import Effect
from dray.protocol.strategist.order_book import DELIVERY_S


def changed(message: OrderReleased, change: int = 1) -> OrderReleased:
    return replace(message, change=change)


def keeps(goal: str, asked: int, quantity: int) -> GoalRevisionTaken:
    return GoalRevisionTaken(task=goal, epoch=1, asked=asked, quantity=quantity)


def taken(effects: list[Effect]) -> list[tuple[int, tuple[int, ...]]]:
    return [(each.change, each.quantities) for each in sent(effects, OrderTaken)]


def test_what_nobody_has_taken_is_put_up_anew_as_it_is_wanted_now() -> None:
    rig = released(order(pump=24))
    effects = rig.on_message("gateway", changed(order(pump=10, due_s=3600.0)))
    [(_, _, quantity)] = announced(effects)
    assert (quantity, taken(effects)) == (10, [(1, (10,))])
    [said] = facts(effects, OrderChanged)
    assert said.quantities == (10,)


def test_more_is_another_goal_and_nobody_is_asked() -> None:
    rig, _ = making(24)
    effects = rig.on_message("gateway", changed(order(pump=40)))
    [(_, _, quantity)] = announced(effects)
    assert (quantity, taken(effects)) == (16, [(1, (40,))])
    assert sent(effects, GoalRevised) == []


def test_a_machine_is_asked_what_it_keeps_and_the_order_is_answered_with_that() -> None:
    rig, goal = making(24)
    effects = rig.on_message("gateway", changed(order(pump=10)))
    [asked] = sent(effects, GoalRevised, to="M7")
    assert (asked.quantity, taken(effects)) == (10, [])
    effects = rig.on_message("M7", keeps(goal, 10, 12))
    assert taken(effects) == [(1, (12,))]
    assert instructed(effects, Admit)[-1] == Admit(goal=goal, quantity=12)
    assert [fact.quantity for fact in facts(effects, GoalReduced)] == [12]


def test_what_is_lost_is_said_again_with_every_heartbeat_and_answered_once() -> None:
    rig, goal = making(24)
    rig.on_message("gateway", changed(order(pump=10)))
    effects = beats(rig, rig.now_s + 2.0, "M7", goals=(brief(goal),))
    assert [asked.quantity for asked in sent(effects, GoalRevised, to="M7")] == [10, 10]
    # Its answer was lost: its heartbeat tells the same.
    effects = beats(rig, rig.now_s + 2.0, "M7", goals=(brief(goal, quantity=10),))
    assert sent(effects, GoalRevised) == []
    assert taken(effects) == [(1, (10,))]
    assert taken(rig.on_message("gateway", changed(order(pump=10)))) == [(1, (10,))]


def test_no_more_is_spared_than_was_asked_whatever_is_lost_in_a_restart() -> None:
    rig = released(order(pump=72))
    goals = contract_all(rig)
    rig.on_message("gateway", changed(order(pump=50)))
    again = reborn(rig)
    effects = again.on_message("gateway", changed(order(pump=50)))
    [(last, (machine, quantity))] = list(goals.items())[-1:]
    [asked] = {(each.task, each.quantity) for each in sent(again.all, GoalRevised)}
    assert asked == (last, quantity - 22)
    effects = again.on_message(machine, keeps(last, quantity - 22, quantity - 22))
    assert taken(effects) == [(1, (50,))]


def test_what_one_machine_keeps_another_is_asked_to_spare() -> None:
    rig = released(order(pump=72))
    goals = contract_all(rig)
    rig.on_message("gateway", changed(order(pump=40)))
    (first, second) = list(reversed(goals.items()))[:2]
    [asked] = sent(rig.all, GoalRevised)
    assert (asked.task, asked.quantity) == (first[0], 0)
    effects = rig.on_message(first[1][0], keeps(first[0], 0, 20))
    [asked] = sent(effects, GoalRevised)
    assert (asked.task, asked.quantity) == (second[0], 0)
    effects = rig.on_message(second[1][0], keeps(second[0], 0, 6))
    [asked] = sent(effects, GoalRevised)
    assert asked.quantity == 24 - (32 - 4 - 18)


def test_another_time_is_told_to_whoever_makes_it_until_its_heartbeat_shows_it() -> None:
    rig, goal = making(24)
    effects = rig.on_message("gateway", changed(order(pump=24, due_s=900.0)))
    assert [said.deadline_s for said in sent(effects, GoalRevised, to="M7")] == [900.0 - DELIVERY_S]
    assert taken(effects) == [(1, (24,))]
    old = replace(brief(goal), deadline_s=7200.0 - DELIVERY_S)
    assert sent(rig.on_message("M7", mhb("M7", old, seq=1)), GoalRevised)
    new = replace(old, deadline_s=900.0 - DELIVERY_S)
    assert sent(rig.on_message("M7", mhb("M7", new, seq=2)), GoalRevised) == []


def test_an_older_change_alters_nothing_and_is_answered_with_the_newer_one() -> None:
    rig, _ = making(24)
    rig.on_message("gateway", changed(order(pump=40), 2))
    assert taken(rig.on_message("gateway", changed(order(pump=90), 1))) == [(2, (40,))]


@pytest.mark.parametrize("restarts", [False, True], ids=["this life", "the next life"])
def test_a_change_with_a_number_of_the_far_future_does_not_bind_people_for_ever(restarts: bool) -> None:
    """A thief of a gateway's certificate has sent it. The gateway repeats what people want until it is answered so."""
    rig, _ = making(24)
    rig.on_message("gateway2", changed(order(pump=90), COUNT_MAX))
    if restarts:
        rig = reborn(rig)
    assert taken(rig.on_message("gateway", changed(order(pump=40), 1))) == [(COUNT_MAX, (90,))]
    rig.run(rig.now_s + OVERTAKES_S + 0.1)
    assert taken(rig.on_message("gateway", changed(order(pump=40), 1))) == [(1, (40,))]
    assert taken(rig.on_message("gateway", changed(order(pump=30), 2))) == [(2, (30,))]


def test_an_older_change_alters_nothing_while_a_gateway_repeats_the_newer_one() -> None:
    """Another gateway has not heard of it yet."""
    rig, _ = making(24)
    for _ in range(4):
        assert taken(rig.on_message("gateway", changed(order(pump=40), 2))) == [(2, (40,))]
        rig.run(rig.now_s + 0.9 * OVERTAKES_S)
        assert taken(rig.on_message("gateway2", changed(order(pump=90), 1))) == [(2, (40,))]


def test_a_change_of_an_earlier_release_alters_nothing_however_late_it_comes() -> None:
    rig = released(changed(replace(order(pump=24), release=2), 3))
    rig.run(rig.now_s + 2 * OVERTAKES_S)
    rig.on_message("gateway", changed(order(pump=90), 1))
    assert taken(rig.on_message("gateway", changed(replace(order(pump=24), release=2), 3)))[0][0] == 3
    assert facts(rig.all, OrderChanged) == []


def test_what_was_spared_and_is_wanted_back_is_made_by_another_goal() -> None:
    rig, goal = making(24)
    rig.on_message("gateway", changed(order(pump=10)))
    assert taken(rig.on_message("gateway", changed(order(pump=24), 2))) == [(2, (24,))]
    effects = beats(rig, rig.now_s + 1.0, "M7", goals=(brief(goal, quantity=10),))
    [(_, _, quantity)] = announced(effects)
    assert quantity == 14


def test_an_order_of_which_all_that_is_still_wanted_has_arrived_is_fulfilled() -> None:
    rig, goal = making(24)
    _arrive(rig, goal, 12)
    rig.on_message("gateway", changed(order(pump=10)))
    effects = rig.on_message("M7", keeps(goal, 12, 12))
    assert facts(effects, OrderFulfilled)
    assert facts(effects, OrderChanged)[0].quantities == (12,)
    [answer] = sent(rig.on_message("gateway", changed(order(pump=10))), OrderTaken)
    assert (answer.fulfilled, answer.quantities) == (True, (12,))


def test_a_change_that_comes_when_all_has_arrived_is_too_late() -> None:
    rig, goal = making(24)
    _arrive(rig, goal, 24)
    [answer] = sent(rig.on_message("gateway", changed(order(pump=40))), OrderTaken)
    assert (answer.fulfilled, answer.change) == (True, 0)


def _arrive(rig: StrategistRig, goal: str, pieces: int) -> list[Effect]:
    return rig.arrive(goal, pieces)


# --- the machine's side ---


def _machine(made: int = 0) -> MachineRig:
    """M7 makes 24 pumps, of which so many are made and one is being made."""
    rig = MachineRig("M7", {"housing": 72, "impeller": 90, "seal-kit": 120})
    rig.start()
    rig.take_goal("G1", production(quantity=24))
    rig.cycles(made)
    return rig


def test_a_machine_keeps_what_it_has_made_and_what_it_is_making() -> None:
    rig = _machine(made=3)
    effects = rig.on_message("STRATEGIST", GoalRevised("G1", 1, 2, 500.0))
    [kept] = sent(effects, GoalRevisionTaken)
    assert (kept.asked, kept.quantity) == (2, 4)
    [kept] = sent(rig.on_message("STRATEGIST", GoalRevised("G1", 1, 24, 500.0)), GoalRevisionTaken)
    assert kept.quantity == 4


def test_a_machine_takes_no_change_from_anybody_but_whoever_gave_it_the_goal() -> None:
    rig = _machine()
    assert sent(rig.on_message("M9", GoalRevised("G1", 1, 2, 500.0)), GoalRevisionTaken) == []
