"""The strategist cancels orders, and takes production back that a manager wants to change."""

from __future__ import annotations

import pytest
from bureau import announced, beats, brief, contract, done, making, order, reborn, released
from effects import deeds, facts, instructed, sent
from msgspec.structs import replace
from rigs import StrategistRig
from spoken import goal_bid, mhb

from dray.body import Admit, GoodsArrived
from dray.messages import (
    CancellationTaken,
    OrderCancelled,
    OrderItem,
    OrderReleased,
    OrderRevoked,
    OrderTaken,
    Release,
    RevocationTaken,
    Withdrawn,
)
from dray.messages.base import COUNT_MAX
from dray.messages.fact import (
    GoalLost,
    GoalWithdrawn,
    OrderAccepted,
    OrderDropped,
    OrderFulfilled,
    OrderReturned,
)
from dray.messages.overtaken import OVERTAKES_S
from dray.protocol.liveness.suspicion import GOAL_SILENCE_S
from dray.protocol.runtime.events import NEVER_S

# --- cancelling -------------------------------------------------------------------------------------


def test_a_cancelled_order_withdraws_goals_that_are_taken_asked_for_and_waiting() -> None:
    rig = released(order(pump=24 * 5))
    [(first, _, _)] = announced(rig.all)
    [(second, _, _)] = announced(contract(rig, first, "M7"))
    rig.on_message("M8", goal_bid(second, 100.0))
    rig.run(rig.now_s + 0.6)
    effects = rig.on_message("gateway", OrderCancelled(order="O1"))
    assert [message.task for message in sent(effects, Withdrawn, to="M7")] == [first]
    assert [message.task for message in sent(effects, Release, to="M8")] == [second]
    assert [fact.order for fact in facts(effects, OrderDropped)] == ["O1"]
    assert announced(effects) == []
    assert rig.agent.wake_at_s == NEVER_S


def test_cancelling_makes_room_for_the_next_order() -> None:
    rig = released(order("O1", pump=240))
    rig.on_message("gateway", order("O2", pump=24))
    effects = rig.on_message("gateway", OrderCancelled(order="O1"))
    [(goal, _, quantity)] = announced(effects)
    assert goal.startswith("O2")
    assert quantity == 24


def test_a_cancellation_is_answered_as_often_as_it_is_asked_for() -> None:
    rig = released(order(pump=24))
    for _ in range(2):
        effects = rig.on_message("gateway", OrderCancelled(order="O1"))
        assert sent(effects, CancellationTaken, to="gateway") == [CancellationTaken(order="O1")]
    assert len(facts(rig.all, OrderDropped)) == 1


def test_an_order_that_is_cancelled_before_it_comes_is_never_begun() -> None:
    rig = released(order("O1", pump=24))
    effects = rig.on_message("gateway", OrderCancelled(order="O2"))
    assert sent(effects, CancellationTaken) == [CancellationTaken(order="O2")]
    effects = rig.on_message("gateway", order("O2", pump=24))
    assert facts(effects, OrderAccepted) == announced(effects) == []
    assert sent(effects, OrderTaken) == [OrderTaken(order="O2")]


def test_a_cancelled_order_that_is_released_again_is_not_made() -> None:
    rig = released(order(pump=24))
    rig.on_message("gateway", OrderCancelled(order="O1"))
    effects = rig.on_message("gateway", order(pump=24))
    assert announced(effects) == []
    assert sent(effects, OrderTaken) == [OrderTaken(order="O1")]


def test_an_order_that_is_cancelled_when_all_of_it_has_arrived_stays_fulfilled() -> None:
    rig, goal = making()
    rig.arrive(goal, 24)
    assert sent(rig.on_message("gateway", OrderCancelled(order="O1")), CancellationTaken)
    effects = rig.on_message("gateway", order(pump=24))
    assert sent(effects, OrderTaken) == [OrderTaken(order="O1", fulfilled=True)]


def test_the_gate_is_shut_for_the_goals_of_a_cancelled_order() -> None:
    rig = released(order(pump=24))
    [(goal, _, _)] = announced(rig.all)
    contract(rig, goal, "M7")
    rig.on_message("gateway", OrderCancelled(order="O1"))
    assert rig.admitted(goal) == 0
    assert deeds(rig.gate_answers(goal)) == []
    effects = rig.on_message("M7", mhb("M7", done(goal, 24, delivered=0)))
    assert [message.task for message in sent(effects, Withdrawn, to="M7")] == [goal]
    assert facts(rig.all, OrderFulfilled) == []


# --- taking back ------------------------------------------------------------------------------------


REVOKED = OrderRevoked(order="O1", release=1)


def again(*quantities: int, release: int = 2) -> OrderReleased:
    """The order of pumps, released once more."""
    items = tuple(OrderItem(product="pump-p3", quantity=each) for each in quantities)
    return OrderReleased(order="O1", items=items, due_s=7200.0, release=release)


def test_an_order_that_is_taken_back_withdraws_what_nobody_makes_yet_and_says_so_at_once() -> None:
    rig = released(order(pump=24))
    [(goal, _, _)] = announced(rig.all)
    rig.on_message("M8", goal_bid(goal, 100.0))
    rig.run(rig.now_s + 0.6)
    effects = rig.on_message("gateway", REVOKED)
    assert [message.task for message in sent(effects, Release, to="M8")] == [goal]
    assert sent(effects, RevocationTaken, to="gateway") == [RevocationTaken("O1", 1, (24,))]
    assert facts(effects, OrderReturned) == [OrderReturned("O1", 1, (24,))]
    assert facts(effects, OrderFulfilled) == []
    assert rig.agent.wake_at_s == NEVER_S


def test_the_answer_to_taking_back_waits_for_the_gates_last_count() -> None:
    rig, goal = making()
    rig.arrive(goal, 5)
    rig.arrived[goal] = 7  # It has not told yet when the strategist shuts it.
    effects = rig.on_message("gateway", REVOKED)
    assert rig.admitted(goal) == 0
    assert sent(effects, RevocationTaken) == []
    assert sent(rig.report(GoodsArrived(goal=goal, arrived=6, admitted=24)), RevocationTaken) == []
    effects = rig.gate_answers(goal)
    assert sent(effects, Withdrawn, to="M7")
    assert facts(effects, GoalWithdrawn) == [GoalWithdrawn(goal=goal, machine="M7", arrived=7)]
    assert sent(effects, RevocationTaken, to="gateway") == [RevocationTaken("O1", 1, (17,))]
    assert facts(rig.all, GoalLost) == []


def test_an_order_whose_last_pieces_come_before_the_gate_is_shut_is_fulfilled_and_not_given_back() -> None:
    rig, goal = making()
    rig.arrived[goal] = 24
    rig.on_message("gateway", REVOKED)
    effects = rig.gate_answers(goal)
    assert facts(effects, OrderFulfilled) == [OrderFulfilled(order="O1")]
    assert sent(effects, RevocationTaken, to="gateway") == [RevocationTaken("O1", 1, (0,))]
    effects = rig.on_message("gateway", again(24))
    assert sent(effects, OrderTaken) == [OrderTaken(order="O1", release=2, fulfilled=True)]
    assert announced(effects) == []


def test_taking_back_is_answered_as_often_as_it_is_asked_for_and_with_the_same_count() -> None:
    rig, goal = making()
    rig.arrive(goal, 4)
    rig.on_message("gateway", REVOKED)
    assert sent(rig.on_message("gateway", REVOKED), RevocationTaken) == []
    rig.gate_answers(goal)
    for _ in range(2):
        assert sent(rig.on_message("gateway", REVOKED), RevocationTaken) == [RevocationTaken("O1", 1, (20,))]
    assert len(facts(rig.all, OrderReturned)) == 1


def test_an_order_that_was_taken_back_is_made_again_when_it_is_released_again_and_not_by_an_old_release() -> (
    None
):
    rig, goal = making()
    rig.arrive(goal, 4)
    rig.on_message("gateway", REVOKED)
    rig.gate_answers(goal)
    late = rig.on_message("gateway", order(pump=24))
    assert announced(late) == []
    assert sent(late, OrderTaken) == [OrderTaken(order="O1", release=1)]
    effects = rig.on_message("gateway", again(20))
    assert sent(effects, OrderTaken) == [OrderTaken(order="O1", release=2)]
    [(successor, _, quantity)] = announced(effects)
    assert quantity == 20
    assert successor != goal
    assert rig.on_message("gateway", REVOKED)  # It comes late, and changes nothing.
    contract(rig, successor, "M8")
    assert rig.admitted(successor) == 20
    rig.arrive(successor, 20)
    assert facts(rig.all, OrderFulfilled) == [OrderFulfilled(order="O1")]
    asked_again = rig.on_message("gateway", again(20))
    assert sent(asked_again, OrderTaken) == [OrderTaken(order="O1", release=2, fulfilled=True)]


def test_a_release_that_overtakes_the_taking_back_of_the_one_before_is_not_taken_yet() -> None:
    rig, goal = making()
    effects = rig.on_message("gateway", again(24))
    assert sent(effects, OrderTaken) == announced(effects) == []
    rig.on_message("gateway", REVOKED)
    rig.gate_answers(goal)
    assert len(announced(rig.on_message("gateway", again(24)))) == 1


def test_an_order_that_is_taken_back_before_it_comes_is_begun_by_its_next_release_only() -> None:
    rig = StrategistRig()
    rig.start()
    assert sent(rig.on_message("gateway", REVOKED), RevocationTaken) == [RevocationTaken("O1", 1, ())]
    assert announced(rig.on_message("gateway", order(pump=24))) == []
    assert len(announced(rig.on_message("gateway", again(24)))) == 1


def test_taking_back_an_order_that_has_ended_says_that_nothing_is_known_of_it() -> None:
    rig, goal = making()
    rig.arrive(goal, 24)
    assert sent(rig.on_message("gateway", REVOKED), RevocationTaken) == [RevocationTaken("O1", 1, ())]
    rig.on_message("gateway", OrderCancelled(order="O2"))
    asked = OrderRevoked(order="O2", release=1)
    assert sent(rig.on_message("gateway", asked), RevocationTaken) == [RevocationTaken("O2", 1, ())]


def test_taking_back_one_order_leaves_the_others_to_go_on() -> None:
    rig = released(order("O1", pump=24))
    rig.on_message("gateway", order("O2", pump=24))
    [(goal, _, _)] = announced(rig.on_message("gateway", REVOKED))
    assert goal.startswith("O2")


def test_an_order_that_is_being_taken_back_may_be_cancelled() -> None:
    rig, goal = making()
    rig.on_message("gateway", REVOKED)
    effects = rig.on_message("gateway", OrderCancelled(order="O1"))
    assert facts(effects, OrderDropped) == [OrderDropped(order="O1")]
    assert deeds(rig.gate_answers(goal)) == []
    assert announced(rig.on_message("gateway", again(24))) == []


def test_a_gate_that_does_not_answer_is_shut_again_for_an_order_that_is_taken_back() -> None:
    rig, goal = making()
    rig.on_message("gateway", REVOKED)
    effects = beats(rig, rig.now_s + GOAL_SILENCE_S + 1.0, "M7", goals=(brief(goal),))
    assert [deed.quantity for deed in instructed(effects, Admit) if deed.goal == goal] == [0]


def test_the_next_life_goes_on_taking_back_and_never_opens_the_gate_again() -> None:
    rig, goal = making()
    rig.arrive(goal, 3)
    rig.on_message("gateway", REVOKED)
    rig.arrived[goal] = 9
    later = reborn(rig)
    assert [deed.quantity for deed in instructed(later.all, Admit)] == [0]
    effects = later.gate_answers(goal)
    assert sent(effects, RevocationTaken, to="gateway") == [RevocationTaken("O1", 1, (15,))]
    last = reborn(later, 3)
    assert sent(last.on_message("gateway", REVOKED), RevocationTaken) == [RevocationTaken("O1", 1, (15,))]
    assert announced(last.on_message("gateway", order(pump=24))) == []
    assert len(announced(last.on_message("gateway", again(15)))) == 1


# --- what a thief of a gateway's certificate says ----------------------------------------------------


@pytest.mark.parametrize("restarts", [False, True], ids=["this life", "the next life"])
def test_a_cancellation_that_no_gateway_knows_of_ends_no_order_for_ever(restarts: bool) -> None:
    """A thief has sent it. The gateway goes on releasing the order, as its database has it."""
    rig, goal = making()
    rig.on_message("gateway2", OrderCancelled(order="O1"))
    if restarts:
        rig = reborn(rig)
    assert announced(rig.on_message("gateway", order(pump=24))) == []
    rig.run(rig.now_s + OVERTAKES_S + 0.1)
    effects = rig.on_message("gateway", order(pump=20))
    assert sent(effects, OrderTaken) == [OrderTaken(order="O1")]
    [(successor, _, quantity)] = announced(effects)
    assert (quantity, successor != goal) == (20, True)
    contract(rig, successor, "M8")
    rig.arrive(successor, 20)
    assert facts(rig.all, OrderFulfilled) == [OrderFulfilled(order="O1")]


def test_an_order_stays_cancelled_while_a_gateway_says_so() -> None:
    rig, _ = making()
    for _ in range(4):
        rig.on_message("gateway", OrderCancelled(order="O1"))
        rig.run(rig.now_s + 0.9 * OVERTAKES_S)
        assert announced(rig.on_message("gateway2", order(pump=24))) == []


def test_a_fulfilled_order_is_not_made_again_however_late_it_is_released() -> None:
    rig, goal = making()
    rig.arrive(goal, 24)
    rig.on_message("gateway", OrderCancelled(order="O1"))
    rig.run(rig.now_s + 2 * OVERTAKES_S)
    effects = rig.on_message("gateway", order(pump=24))
    assert announced(effects) == []
    assert sent(effects, OrderTaken) == [OrderTaken(order="O1", fulfilled=True)]


def test_a_revocation_of_a_release_of_the_far_future_does_not_end_an_order_for_ever() -> None:
    rig = StrategistRig()
    rig.start()
    rig.on_message("gateway2", OrderRevoked("O1", COUNT_MAX))
    assert announced(rig.on_message("gateway", order(pump=24))) == []
    rig.run(rig.now_s + OVERTAKES_S + 0.1)
    assert len(announced(rig.on_message("gateway", order(pump=24)))) == 1


def test_a_release_that_was_taken_back_is_not_made_again_however_late_it_comes() -> None:
    rig, goal = making()
    rig.on_message("gateway", REVOKED)
    rig.gate_answers(goal)
    rig.run(rig.now_s + 2 * OVERTAKES_S)
    assert announced(rig.on_message("gateway", order(pump=24))) == []


def test_a_release_of_the_far_future_can_be_taken_back() -> None:
    rig = released(replace(order(pump=24), release=COUNT_MAX))
    rig.on_message("gateway", order(pump=24))
    assert sent(rig.on_message("gateway", REVOKED), RevocationTaken) == [], "perhaps it came late"
    rig.run(rig.now_s + OVERTAKES_S + 0.1)
    assert sent(rig.on_message("gateway", REVOKED), RevocationTaken) == [RevocationTaken("O1", 1, (24,))]
    assert len(announced(rig.on_message("gateway", again(24)))) == 1
