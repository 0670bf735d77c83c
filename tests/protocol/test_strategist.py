"""The strategist: turns orders into goals, and never decides a transport (paper, 3.2)."""

from __future__ import annotations

import msgspec
import pytest
from bureau import announced, beats, contract, contract_all, done, order, released
from kit import (
    KEYS,
    PLANT,
    StrategistRig,
    accepted,
    announcement,
    award,
    committed,
    declined,
    deeds,
    facts,
    goal_bid,
    instructed,
    listening,
    mhb,
    published,
    rhb,
    sent,
)

from dray.body import Admit, GoodsArrived, Repaired
from dray.errors import ProtocolViolation
from dray.memory import Memory
from dray.messages import (
    Award,
    BerthClaimed,
    CancellationTaken,
    Confirmed,
    Docked,
    GoalBrief,
    GoalClosed,
    MachineStatus,
    OrderCancelled,
    OrderItem,
    OrderReleased,
    OrderRevoked,
    OrderTaken,
    Release,
    RevocationTaken,
    TaskAnnounced,
    Transport,
    Withdrawn,
)
from dray.messages.fact import (
    GoalContracted,
    GoalLost,
    GoalWaits,
    GoalWithdrawn,
    GoodsDelivered,
    OrderAccepted,
    OrderDropped,
    OrderFulfilled,
    OrderReturned,
    TaskClosed,
)
from dray.protocol.events import NEVER_S, Commit, Started
from dray.protocol.machine_watch import BREAKDOWN_S, GOAL_SILENCE_S

# --- orders become goals -------------------------------------------------------------------------


def test_an_order_is_answered_as_taken() -> None:
    rig = released(order(pump=24))
    assert sent(rig.all, OrderTaken, to="gateway") == [OrderTaken(order="O1")]


def test_an_order_of_one_lot_is_one_goal() -> None:
    rig = released(order(pump=24))
    [(goal, product, quantity)] = announced(rig.all)
    assert (product, quantity) == ("pump-p3", 24)
    [taken] = facts(rig.all, OrderAccepted)
    assert taken.goals == (goal,)


@pytest.mark.parametrize("quantity", [1, 23, 24, 25, 100, 119, 120, 121, 1000])
def test_goals_add_up_to_the_order_in_whole_lots_for_no_more_than_the_capable_machines(quantity: int) -> None:
    rig = released(order(pump=quantity))
    sizes = [size for _, size in contract_all(rig).values()]
    assert sum(sizes) == quantity
    assert len(sizes) <= len(PLANT.machines_for("pump-p3"))
    assert all(size % PLANT.products["pump-p3"].lot == 0 for size in sizes[:-1])
    assert max(sizes) - min(sizes) <= max(sizes)
    assert min(sizes) > 0


def test_a_large_order_is_shared_among_all_capable_machines() -> None:
    machines = len(PLANT.machines_for("pump-p3"))
    rig = released(order(pump=24 * machines))
    assert [size for _, size in contract_all(rig).values()] == [24] * machines


def test_every_goal_has_a_name_of_its_own_in_every_life() -> None:
    names: list[str] = []
    for incarnation in (1, 2):
        rig = released(order(pump=240, g1=80), incarnation=incarnation)
        names += facts(rig.all, OrderAccepted)[0].goals
    assert len(names) == len(set(names))


def test_the_same_order_twice_is_one_order() -> None:
    rig = released(order(pump=24))
    effects = rig.hear("gateway", order(pump=24))
    assert sent(effects, OrderTaken) == [OrderTaken(order="O1")]
    assert announced(effects) == []
    assert len(facts(rig.all, OrderAccepted)) == 1


def test_an_order_of_nothing_is_fulfilled_at_once() -> None:
    rig = released(order())
    assert [fact.order for fact in facts(rig.all, OrderFulfilled)] == ["O1"]
    assert sent(rig.all, OrderTaken) == [OrderTaken(order="O1", fulfilled=True)]
    assert rig.agent.wake_at_s == NEVER_S


def test_an_item_of_nothing_is_left_out_of_its_order() -> None:
    rig = released(order(pump=0, g1=5))
    assert [(product, quantity) for _, product, quantity in announced(rig.all)] == [("gear-unit-g1", 5)]
    [taken] = facts(rig.all, OrderAccepted)
    assert len(taken.goals) == 1


def test_an_order_with_an_unknown_product_is_ignored_and_not_taken() -> None:
    rig = StrategistRig()
    rig.start()
    items = (OrderItem(product="pump-p3", quantity=24), OrderItem(product="nonsense", quantity=1))
    effects = rig.hear("gateway", OrderReleased(order="O1", items=items, due_s=3600.0))
    assert len(effects) == 1
    assert deeds(effects) == []


def test_all_machines_are_heard_from_the_beginning() -> None:
    rig = StrategistRig()
    assert listening(rig.start()) == {KEYS.all_machine_heartbeats}


# --- following -----------------------------------------------------------------------------------


def test_a_goal_is_closed_when_the_gate_has_counted_all_of_it_and_not_before() -> None:
    rig = released(order(pump=24))
    [(goal, _, _)] = announced(rig.all)
    contract(rig, goal, "M7")
    assert rig.admitted(goal) == 24
    [first] = facts(rig.arrive(goal, 20), GoodsDelivered)
    assert (first.goal, first.order, first.quantity, first.delivered) == (goal, "O1", 20, 20)
    assert deeds(rig.gate_answers(goal)) == []
    effects = rig.arrive(goal, 4)
    assert [fact.delivered for fact in facts(effects, GoodsDelivered)] == [24]
    assert sent(effects, GoalClosed, to="M7") == [GoalClosed(goal=goal)]
    assert [fact.outcome for fact in facts(effects, TaskClosed)] == ["delivered"]


def test_the_word_of_a_machine_closes_no_goal() -> None:
    rig = released(order(pump=24))
    [(goal, _, _)] = announced(rig.all)
    contract(rig, goal, "M7")
    effects = rig.hear("M7", mhb("M7", done(goal, 24)))
    assert facts(effects, TaskClosed) == []
    assert sent(effects, Confirmed, to="M7") == [Confirmed(task=goal, epoch=1, arrived=0)]


def test_a_machine_that_is_not_bound_is_told_so_once_the_goal_is_anothers() -> None:
    rig = released(order(pump=120))
    [(goal, _, quantity), *_] = announced(rig.all)
    assert deeds(rig.hear("M8", mhb("M8", done(goal, quantity)))) == []
    contract(rig, goal, "M7")
    effects = rig.hear("M8", mhb("M8", done(goal, quantity), seq=2))
    assert [message.task for message in sent(effects, Withdrawn, to="M8")] == [goal]
    assert facts(effects, TaskClosed) == []


def test_an_order_is_fulfilled_when_its_last_goal_is_delivered() -> None:
    rig = released(order(pump=240))
    taken = contract_all(rig)
    for number, (goal, (_, quantity)) in enumerate(taken.items(), start=1):
        assert facts(rig.all, OrderFulfilled) == []
        rig.arrive(goal, quantity)
        assert bool(facts(rig.all, OrderFulfilled)) is (number == len(taken))


def test_an_order_of_several_products_needs_them_all() -> None:
    rig = released(order(pump=24, g1=40))
    taken = contract_all(rig)
    assert len(taken) == 2
    for goal, (_, quantity) in taken.items():
        assert facts(rig.all, OrderFulfilled) == []
        rig.arrive(goal, quantity)
    assert [fact.order for fact in facts(rig.all, OrderFulfilled)] == ["O1"]


def test_the_closing_of_a_goal_is_said_again_while_the_machine_still_names_it() -> None:
    rig = released(order(pump=48 * 5))
    taken = contract_all(rig)
    goal, (machine, quantity) = next(iter(taken.items()))
    rig.arrive(goal, quantity)
    effects = rig.hear(machine, mhb(machine, done(goal, quantity), seq=2))
    assert sent(effects, GoalClosed, to=machine) == [GoalClosed(goal=goal)]
    assert facts(effects, TaskClosed) == []


def test_a_goal_that_nobody_knows_is_over() -> None:
    rig = released(order(pump=24))
    effects = rig.hear("M7", mhb("M7", done("X1", 24), done("X2", 24, delivered=23)))
    assert sent(effects, GoalClosed, to="M7") == [GoalClosed(goal="X1")]
    assert [message.task for message in sent(effects, Withdrawn, to="M7")] == ["X2"]


def test_a_fulfilled_order_that_is_released_again_is_said_to_be_so_and_not_made_again() -> None:
    rig = released(order(pump=24))
    [(goal, _, _)] = announced(rig.all)
    contract(rig, goal, "M7")
    rig.arrive(goal, 23)
    assert sent(rig.hear("gateway", order(pump=24)), OrderTaken) == [OrderTaken(order="O1")]
    rig.arrive(goal, 1)
    effects = rig.hear("gateway", order(pump=24))
    assert sent(effects, OrderTaken) == [OrderTaken(order="O1", fulfilled=True)]
    assert announced(effects) == []


# --- when a machine fails (paper, case 1) --------------------------------------------------------


def making(quantity: int = 24) -> tuple[StrategistRig, str]:
    """M7 makes the only goal of an order of pumps; M8 and M9 could make it, too."""
    rig = released(order(pump=quantity))
    [(goal, _, _)] = announced(rig.all)
    contract(rig, goal, "M7")
    return rig, goal


def brief(goal: str, made: int = 5, delivered: int = 0, quantity: int = 24) -> GoalBrief:
    return GoalBrief(goal=goal, product="pump-p3", quantity=quantity, made=made, delivered=delivered)


def test_a_machine_that_names_its_goal_keeps_it_for_as_long_as_it_takes() -> None:
    rig, goal = making()
    beats(rig, 3600.0, "M7", "M8", goals=(brief(goal),))
    assert facts(rig.all, GoalLost) == []
    assert rig.admitted(goal) == 24


@pytest.mark.parametrize("delivered", [0, 10])
def test_what_has_not_arrived_from_a_silent_machine_is_put_up_under_a_new_name(delivered: int) -> None:
    rig, goal = making()
    if delivered:
        rig.arrive(goal, delivered)
    begun_s = rig.now_s
    effects = beats(rig, begun_s + GOAL_SILENCE_S + 1.0, "M8")
    assert rig.admitted(goal) == 0
    assert announced(effects) == []  # Not before the gate has said its last word.
    effects = rig.gate_answers(goal)
    [lost] = facts(effects, GoalLost)
    assert (lost.goal, lost.machine, lost.arrived) == (goal, "M7", delivered)
    assert announced(effects) == [(lost.successor, "pump-p3", 24 - delivered)]
    assert lost.successor != goal
    assert [fact.outcome for fact in facts(effects, TaskClosed)] == ["withdrawn"]
    contract(rig, lost.successor, "M8")
    assert rig.admitted(lost.successor) == 24 - delivered
    rig.arrive(lost.successor, 24 - delivered)
    assert [fact.order for fact in facts(rig.all, OrderFulfilled)] == ["O1"]


def test_pieces_that_get_in_before_the_gate_is_shut_count() -> None:
    rig, goal = making()
    rig.arrived[goal] = 4  # It has not told yet when the strategist shuts it.
    beats(rig, rig.now_s + GOAL_SILENCE_S + 1.0, "M8")
    late = GoodsArrived(goal=goal, arrived=3, admitted=24)
    assert facts(rig.report(late), GoalLost) == []
    [lost] = facts(rig.gate_answers(goal), GoalLost)
    assert lost.arrived == 4
    assert sum(fact.quantity for fact in facts(rig.all, GoodsDelivered)) == 4


def test_all_that_was_missing_may_get_in_before_the_gate_is_shut() -> None:
    rig, goal = making()
    rig.arrived[goal] = 24
    beats(rig, rig.now_s + GOAL_SILENCE_S + 1.0, "M8")
    effects = rig.gate_answers(goal)
    assert facts(effects, GoalLost) == []
    assert [fact.order for fact in facts(effects, OrderFulfilled)] == ["O1"]


def test_a_machine_that_comes_back_is_told_that_its_goal_is_anothers() -> None:
    rig, goal = making()
    beats(rig, rig.now_s + GOAL_SILENCE_S + 1.0, "M8")
    rig.gate_answers(goal)
    effects = rig.hear("M7", mhb("M7", brief(goal), seq=1000))
    assert [message.task for message in sent(effects, Withdrawn, to="M7")] == [goal]


def test_a_machine_that_has_forgotten_its_goal_may_bid_for_the_rest() -> None:
    rig, goal = making()
    beats(rig, rig.now_s + GOAL_SILENCE_S + 1.0, "M7")
    [lost] = facts(rig.gate_answers(goal), GoalLost)
    contract(rig, lost.successor, "M7")
    assert [fact.machine for fact in facts(rig.all, GoalContracted)] == ["M7", "M7"]


def test_while_nobody_else_lives_the_goal_stays_and_its_order_says_that_it_waits() -> None:
    rig, goal = making()
    rig.run(600.0)
    [waits] = facts(rig.all, GoalWaits)
    assert (waits.goal, waits.order) == (goal, "O1")
    assert "M7 is silent" in waits.reason
    assert rig.admitted(goal) == 24
    beats(rig, 700.0, "M7", goals=(brief(goal),))
    assert facts(rig.all, GoalLost) == []
    rig.arrive(goal, 24)
    assert facts(rig.all, OrderFulfilled)


def test_a_goal_that_waits_goes_on_with_whoever_comes_back_first() -> None:
    rig, goal = making()
    rig.run(600.0)
    beats(rig, 620.0, "M9")
    [lost] = facts(rig.gate_answers(goal), GoalLost)
    contract(rig, lost.successor, "M9")
    assert facts(rig.all, GoalContracted)[-1].machine == "M9"


@pytest.mark.parametrize(("broken_s", "loses"), [(BREAKDOWN_S - 60.0, False), (BREAKDOWN_S + 60.0, True)])
def test_a_broken_machine_keeps_its_goals_for_as_long_as_a_repair_takes(broken_s: float, loses: bool) -> None:
    rig, goal = making()
    begun_s = rig.now_s
    while rig.now_s < begun_s + broken_s:
        rig.run(rig.now_s + 1.0)
        seq = round(rig.now_s * 10)
        ill = msgspec.structs.replace(mhb("M7", brief(goal), seq=seq), status=MachineStatus.ERROR)
        rig.hear("M7", ill)
        rig.hear("M8", mhb("M8", seq=seq))
    if rig.admitted(goal) == 0:
        rig.gate_answers(goal)
    assert bool(facts(rig.all, GoalLost)) is loses


def test_a_machine_that_is_back_when_the_gate_is_shut_comes_too_late() -> None:
    rig, goal = making()
    beats(rig, rig.now_s + GOAL_SILENCE_S + 1.0, "M8")
    assert rig.admitted(goal) == 0
    beats(rig, rig.now_s + GOAL_SILENCE_S + 2.0, "M7", "M8", goals=(brief(goal),))
    assert rig.admitted(goal) == 0
    assert facts(rig.gate_answers(goal), GoalLost)


def test_a_gate_that_does_not_answer_is_shut_again_until_it_does() -> None:
    rig, _ = making()
    effects = beats(rig, rig.now_s + 5 * GOAL_SILENCE_S, "M8")
    assert len([admit for admit in instructed(effects, Admit) if not admit.quantity]) > 2
    assert facts(effects, GoalLost) == []


def test_an_old_heartbeat_keeps_no_goal() -> None:
    rig, goal = making()
    rig.hear("M7", mhb("M7", brief(goal), seq=50))
    for _ in range(20):
        rig.run(rig.now_s + 1.0)
        rig.hear("M7", mhb("M7", brief(goal), seq=49))
        rig.hear("M8", mhb("M8", seq=round(rig.now_s * 10)))
    assert rig.admitted(goal) == 0


# --- from life to life ---------------------------------------------------------------------------


def reborn(rig: StrategistRig, incarnation: int = 2) -> StrategistRig:
    """The strategist is started again, with its gate as it is and what it had written down."""
    again = StrategistRig(memory=committed(rig.all), incarnation=incarnation)
    again.arrived, again.now_s = rig.arrived, rig.now_s
    again.start()
    return again


def test_what_binds_the_strategist_is_written_down_before_it_is_said() -> None:
    rig = StrategistRig()
    rig.start()
    steps = [rig.hear("gateway", order(pump=24))]
    [(goal, _, _)] = announced(rig.all)
    rig.hear("M7", goal_bid(goal, 100.0))
    rig.run(1.0)
    steps += [rig.hear("M7", accepted(goal)), rig.arrive(goal, 10), rig.arrive(goal, 14)]
    for effects in steps:
        assert [isinstance(effect, Commit) for effect in effects] == [True] + [False] * (len(effects) - 1)
        assert len(effects) > 1


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
    rig.hear("M7", goal_bid(goal, 100.0))
    rig.run(1.0)
    again = reborn(rig)
    [message] = published(again.all, TaskAnnounced)
    assert (message.task, message.epoch) == (goal, 2)
    effects = again.hear("M7", accepted(goal))
    assert sent(effects, Confirmed) == []
    assert sent(effects, Release, to="M7")


def test_a_contract_survives_the_strategist_and_is_confirmed_when_it_is_asked_for() -> None:
    rig, goal = making()
    again = reborn(rig)
    assert announced(again.all) == []
    assert again.admitted(goal) == 24
    effects = again.hear("M7", accepted(goal, number=7))
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
    effects = once_more.hear("M7", accepted(goal))
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
        rig.hear("gateway", order(f"O{incarnation}", g1=40))
        fresh = {goal, *facts(rig.all, OrderAccepted)[-1].goals}
        assert not names & fresh
        names |= fresh


def test_the_next_life_knows_which_ended_orders_were_fulfilled() -> None:
    rig, goal = making()
    rig.arrive(goal, 24)
    rig.hear("gateway", OrderCancelled(order="O2"))
    later = reborn(reborn(rig), 3)
    effects = later.hear("gateway", order(pump=24)) + later.hear("gateway", order("O2", pump=24))
    assert sent(effects, OrderTaken) == [OrderTaken(order="O1", fulfilled=True), OrderTaken(order="O2")]
    assert announced(effects) == []


def test_an_order_whose_end_was_not_written_down_how_is_not_said_to_be_fulfilled() -> None:
    rig, goal = making()
    rig.arrive(goal, 24)
    written = msgspec.to_builtins(committed(rig.all))
    del written["fulfilled"]  # As the version before has left it.
    later = StrategistRig(memory=msgspec.convert(written, Memory), incarnation=2)
    later.start()
    effects = later.hear("gateway", order(pump=24))
    assert sent(effects, OrderTaken) == [OrderTaken(order="O1")]
    assert announced(effects) == []


# --- cancelling ----------------------------------------------------------------------------------


def test_a_cancelled_order_withdraws_goals_that_are_taken_asked_for_and_waiting() -> None:
    rig = released(order(pump=24 * 5))
    [(first, _, _)] = announced(rig.all)
    [(second, _, _)] = announced(contract(rig, first, "M7"))
    rig.hear("M8", goal_bid(second, 100.0))
    rig.run(rig.now_s + 0.6)
    effects = rig.hear("gateway", OrderCancelled(order="O1"))
    assert [message.task for message in sent(effects, Withdrawn, to="M7")] == [first]
    assert [message.task for message in sent(effects, Release, to="M8")] == [second]
    assert [fact.order for fact in facts(effects, OrderDropped)] == ["O1"]
    assert announced(effects) == []
    assert rig.agent.wake_at_s == NEVER_S


def test_cancelling_makes_room_for_the_next_order() -> None:
    rig = released(order("O1", pump=240))
    rig.hear("gateway", order("O2", pump=24))
    effects = rig.hear("gateway", OrderCancelled(order="O1"))
    [(goal, _, quantity)] = announced(effects)
    assert goal.startswith("O2")
    assert quantity == 24


def test_a_cancellation_is_answered_as_often_as_it_is_asked_for() -> None:
    rig = released(order(pump=24))
    for _ in range(2):
        effects = rig.hear("gateway", OrderCancelled(order="O1"))
        assert sent(effects, CancellationTaken, to="gateway") == [CancellationTaken(order="O1")]
    assert len(facts(rig.all, OrderDropped)) == 1


def test_an_order_that_is_cancelled_before_it_comes_is_never_begun() -> None:
    rig = released(order("O1", pump=24))
    effects = rig.hear("gateway", OrderCancelled(order="O2"))
    assert sent(effects, CancellationTaken) == [CancellationTaken(order="O2")]
    effects = rig.hear("gateway", order("O2", pump=24))
    assert facts(effects, OrderAccepted) == announced(effects) == []
    assert sent(effects, OrderTaken) == [OrderTaken(order="O2")]


def test_a_cancelled_order_that_is_released_again_is_not_made() -> None:
    rig = released(order(pump=24))
    rig.hear("gateway", OrderCancelled(order="O1"))
    effects = rig.hear("gateway", order(pump=24))
    assert announced(effects) == []
    assert sent(effects, OrderTaken) == [OrderTaken(order="O1")]


def test_an_order_that_is_cancelled_when_all_of_it_has_arrived_stays_fulfilled() -> None:
    rig, goal = making()
    rig.arrive(goal, 24)
    assert sent(rig.hear("gateway", OrderCancelled(order="O1")), CancellationTaken)
    effects = rig.hear("gateway", order(pump=24))
    assert sent(effects, OrderTaken) == [OrderTaken(order="O1", fulfilled=True)]


def test_the_gate_is_shut_for_the_goals_of_a_cancelled_order() -> None:
    rig = released(order(pump=24))
    [(goal, _, _)] = announced(rig.all)
    contract(rig, goal, "M7")
    rig.hear("gateway", OrderCancelled(order="O1"))
    assert rig.admitted(goal) == 0
    assert deeds(rig.gate_answers(goal)) == []
    effects = rig.hear("M7", mhb("M7", done(goal, 24, delivered=0)))
    assert [message.task for message in sent(effects, Withdrawn, to="M7")] == [goal]
    assert facts(rig.all, OrderFulfilled) == []


# --- taking back ---------------------------------------------------------------------------------

REVOKED = OrderRevoked(order="O1", release=1)


def again(*quantities: int, release: int = 2) -> OrderReleased:
    """The order of pumps, released once more."""
    items = tuple(OrderItem(product="pump-p3", quantity=each) for each in quantities)
    return OrderReleased(order="O1", items=items, due_s=7200.0, release=release)


def test_an_order_that_is_taken_back_withdraws_what_nobody_makes_yet_and_says_so_at_once() -> None:
    rig = released(order(pump=24))
    [(goal, _, _)] = announced(rig.all)
    rig.hear("M8", goal_bid(goal, 100.0))
    rig.run(rig.now_s + 0.6)
    effects = rig.hear("gateway", REVOKED)
    assert [message.task for message in sent(effects, Release, to="M8")] == [goal]
    assert sent(effects, RevocationTaken, to="gateway") == [RevocationTaken("O1", 1, (24,))]
    assert facts(effects, OrderReturned) == [OrderReturned("O1", 1, (24,))]
    assert facts(effects, OrderFulfilled) == []
    assert rig.agent.wake_at_s == NEVER_S


def test_the_answer_to_taking_back_waits_for_the_gates_last_count() -> None:
    rig, goal = making()
    rig.arrive(goal, 5)
    rig.arrived[goal] = 7  # It has not told yet when the strategist shuts it.
    effects = rig.hear("gateway", REVOKED)
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
    rig.hear("gateway", REVOKED)
    effects = rig.gate_answers(goal)
    assert facts(effects, OrderFulfilled) == [OrderFulfilled(order="O1")]
    assert sent(effects, RevocationTaken, to="gateway") == [RevocationTaken("O1", 1, (0,))]
    effects = rig.hear("gateway", again(24))
    assert sent(effects, OrderTaken) == [OrderTaken(order="O1", release=2, fulfilled=True)]
    assert announced(effects) == []


def test_taking_back_is_answered_as_often_as_it_is_asked_for_and_with_the_same_count() -> None:
    rig, goal = making()
    rig.arrive(goal, 4)
    rig.hear("gateway", REVOKED)
    assert sent(rig.hear("gateway", REVOKED), RevocationTaken) == []
    rig.gate_answers(goal)
    for _ in range(2):
        assert sent(rig.hear("gateway", REVOKED), RevocationTaken) == [RevocationTaken("O1", 1, (20,))]
    assert len(facts(rig.all, OrderReturned)) == 1


def test_an_order_that_was_taken_back_is_made_again_when_it_is_released_again_and_not_by_an_old_release() -> (
    None
):
    rig, goal = making()
    rig.arrive(goal, 4)
    rig.hear("gateway", REVOKED)
    rig.gate_answers(goal)
    late = rig.hear("gateway", order(pump=24))
    assert announced(late) == []
    assert sent(late, OrderTaken) == [OrderTaken(order="O1", release=1)]
    effects = rig.hear("gateway", again(20))
    assert sent(effects, OrderTaken) == [OrderTaken(order="O1", release=2)]
    [(successor, _, quantity)] = announced(effects)
    assert quantity == 20
    assert successor != goal
    assert rig.hear("gateway", REVOKED)  # It comes late, and changes nothing.
    contract(rig, successor, "M8")
    assert rig.admitted(successor) == 20
    rig.arrive(successor, 20)
    assert facts(rig.all, OrderFulfilled) == [OrderFulfilled(order="O1")]
    asked_again = rig.hear("gateway", again(20))
    assert sent(asked_again, OrderTaken) == [OrderTaken(order="O1", release=2, fulfilled=True)]


def test_a_release_that_overtakes_the_taking_back_of_the_one_before_is_not_taken_yet() -> None:
    rig, goal = making()
    effects = rig.hear("gateway", again(24))
    assert sent(effects, OrderTaken) == announced(effects) == []
    rig.hear("gateway", REVOKED)
    rig.gate_answers(goal)
    assert len(announced(rig.hear("gateway", again(24)))) == 1


def test_an_order_that_is_taken_back_before_it_comes_is_begun_by_its_next_release_only() -> None:
    rig = StrategistRig()
    rig.start()
    assert sent(rig.hear("gateway", REVOKED), RevocationTaken) == [RevocationTaken("O1", 1, ())]
    assert announced(rig.hear("gateway", order(pump=24))) == []
    assert len(announced(rig.hear("gateway", again(24)))) == 1


def test_taking_back_an_order_that_has_ended_says_that_nothing_is_known_of_it() -> None:
    rig, goal = making()
    rig.arrive(goal, 24)
    assert sent(rig.hear("gateway", REVOKED), RevocationTaken) == [RevocationTaken("O1", 1, ())]
    rig.hear("gateway", OrderCancelled(order="O2"))
    asked = OrderRevoked(order="O2", release=1)
    assert sent(rig.hear("gateway", asked), RevocationTaken) == [RevocationTaken("O2", 1, ())]


def test_taking_back_one_order_leaves_the_others_to_go_on() -> None:
    rig = released(order("O1", pump=24))
    rig.hear("gateway", order("O2", pump=24))
    [(goal, _, _)] = announced(rig.hear("gateway", REVOKED))
    assert goal.startswith("O2")


def test_an_order_that_is_being_taken_back_may_be_cancelled() -> None:
    rig, goal = making()
    rig.hear("gateway", REVOKED)
    effects = rig.hear("gateway", OrderCancelled(order="O1"))
    assert facts(effects, OrderDropped) == [OrderDropped(order="O1")]
    assert deeds(rig.gate_answers(goal)) == []
    assert announced(rig.hear("gateway", again(24))) == []


def test_a_gate_that_does_not_answer_is_shut_again_for_an_order_that_is_taken_back() -> None:
    rig, goal = making()
    rig.hear("gateway", REVOKED)
    effects = beats(rig, rig.now_s + GOAL_SILENCE_S + 1.0, "M7", goals=(brief(goal),))
    assert [deed.quantity for deed in instructed(effects, Admit) if deed.goal == goal] == [0]


def test_the_next_life_goes_on_taking_back_and_never_opens_the_gate_again() -> None:
    rig, goal = making()
    rig.arrive(goal, 3)
    rig.hear("gateway", REVOKED)
    rig.arrived[goal] = 9
    later = reborn(rig)
    assert [deed.quantity for deed in instructed(later.all, Admit)] == [0]
    effects = later.gate_answers(goal)
    assert sent(effects, RevocationTaken, to="gateway") == [RevocationTaken("O1", 1, (15,))]
    last = reborn(later, 3)
    assert sent(last.hear("gateway", REVOKED), RevocationTaken) == [RevocationTaken("O1", 1, (15,))]
    assert announced(last.hear("gateway", order(pump=24))) == []
    assert len(announced(last.hear("gateway", again(15)))) == 1


# --- robustness ----------------------------------------------------------------------------------


def test_a_strategist_decides_no_transport() -> None:
    rig = released(order(pump=240))
    contract_all(rig)
    works = [message.work for message in (*published(rig.all, TaskAnnounced), *sent(rig.all, Award))]
    assert works
    assert not any(isinstance(work, Transport) for work in works)


def test_what_is_not_meant_for_a_strategist_is_ignored() -> None:
    rig = released(order(pump=24))
    for message in (
        announcement(),
        award(),
        rhb("ATV1", 1, 0.0),
        Docked(task="M8-1", epoch=1, station="M8"),
        GoalClosed(goal="G1"),
        BerthClaimed(berth="CH1", atv="ATV1", battery_frac=0.5, standing=False),
        goal_bid("G9", 1.0),
        declined("G9"),
    ):
        assert deeds(rig.hear("X", message)) == [], message


def test_a_strategist_has_a_gate_and_no_other_body() -> None:
    with pytest.raises(ProtocolViolation, match="no body"):
        released(order(pump=24)).report(Repaired())
    with pytest.raises(ProtocolViolation, match="needs a gate"):
        StrategistRig().handle(Started(None))


def test_being_woken_for_nothing_is_harmless() -> None:
    assert released(order(pump=24)).wake() == []
