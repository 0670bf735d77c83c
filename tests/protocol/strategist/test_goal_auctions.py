"""Goals given out among the machines that can make them, one of each product at a time."""

from __future__ import annotations

from bureau import announced, beats, contract, order, released
from defaults import KEYS
from effects import facts, published, sent
from rigs import MachineRig, StrategistRig
from spoken import accepted, declined, goal_bid, mhb

from dray.messages import (
    Accepted,
    Award,
    Bid,
    Confirmed,
    MachineHeartbeat,
    OrderCancelled,
    Production,
    Release,
    TaskAnnounced,
)
from dray.messages.fact import (
    AwardGiven,
    GoalContracted,
    GoalWaits,
    OrderAccepted,
    OrderFulfilled,
)

# --- goals are put up ----------------------------------------------------------------------------


def test_goals_of_one_product_are_auctioned_one_after_another() -> None:
    rig = released(order(pump=240))
    [(first, _, _)] = announced(rig.all)
    [(second, _, _)] = announced(contract(rig, first, "M7"))
    assert first != second


def test_goals_of_different_products_are_auctioned_at_the_same_time() -> None:
    rig = released(order(pump=24, g1=40, motor=20))
    assert [product for _, product, _ in announced(rig.all)] == [
        "pump-p3",
        "gear-unit-g1",
        "motor-e4",
    ]


def test_a_second_order_waits_for_the_first_ones_goals_of_that_product() -> None:
    rig = released(order("O1", pump=24))
    assert announced(rig.on_message("gateway", order("O2", pump=24))) == []
    [(goal, _, _)] = announced(rig.all)
    [(second, _, _)] = announced(contract(rig, goal, "M7"))
    assert second.startswith("O2")


def test_what_is_wanted_first_is_put_up_first_whenever_it_came() -> None:
    rig = released(order("O1", pump=240, due_s=7200.0))
    assert announced(rig.on_message("gateway", order("O2", pump=24, due_s=900.0))) == []
    [(goal, _, _)] = announced(rig.all)
    [(second, _, _)] = announced(contract(rig, goal, "M7"))
    assert second.startswith("O2")


def test_goals_are_announced_to_the_machines_of_their_product_and_due_before_the_order() -> None:
    rig = released(order(pump=24, due_s=7200.0))
    [key] = [effect.key for effect in rig.all if published([effect], TaskAnnounced)]  # type: ignore[union-attr]
    assert key == KEYS.goals("pump-p3")
    [message] = published(rig.all, TaskAnnounced)
    assert 0.0 < message.deadline_s < 7200.0
    assert isinstance(message.work, Production)
    assert (message.work.order, message.work.item) == ("O1", 0)


# --- machines bid --------------------------------------------------------------------------------


def test_of_several_machines_the_cheapest_takes_the_goal() -> None:
    rig = released(order(pump=24))
    [(goal, _, _)] = announced(rig.all)
    for machine, cost_s in (("M7", 1500.0), ("M8", 1200.0), ("M9", 1300.0)):
        rig.on_message(machine, goal_bid(goal, cost_s))
    rig.run(0.5)
    assert [fact.bidder for fact in facts(rig.all, AwardGiven)] == ["M8"]
    rig.on_message("M8", declined(goal))
    assert [fact.bidder for fact in facts(rig.all, AwardGiven)] == ["M8", "M9"]
    effects = rig.on_message("M9", accepted(goal, number=2))
    assert sent(effects, Confirmed, to="M9") == [Confirmed(task=goal, epoch=1)]
    [contracted] = facts(rig.all, GoalContracted)
    assert (contracted.goal, contracted.machine, contracted.quantity) == (goal, "M9", 24)


def test_on_slow_links_the_cheapest_machine_is_waited_for_and_not_the_first_word() -> None:
    """Each message is under way for 0.6 s: no bid comes within the window of good links."""
    rig = StrategistRig()
    rig.start()
    for number in range(1, 30):
        for machine in ("M7", "M8", "M9"):
            rig.on_message(machine, mhb(machine, seq=number, at_s=rig.now_s - 0.6))
        rig.run(rig.now_s + 1.0)
    rig.on_message("gateway", order(pump=24))
    [(goal, _, _)] = announced(rig.all)
    asked_s = rig.now_s
    for after_s, machine, cost_s in ((1.20, "M7", 6000.0), (1.21, "M8", 1200.0), (1.25, "M9", 1300.0)):
        rig.run(asked_s + after_s)
        rig.on_message(machine, goal_bid(goal, cost_s))
    rig.run(asked_s + 1.5)
    assert [fact.bidder for fact in facts(rig.all, AwardGiven)] == ["M8"]


def test_every_acceptance_of_the_bound_machine_is_confirmed_and_no_other() -> None:
    rig = released(order(pump=24))
    [(goal, _, _)] = announced(rig.all)
    contract(rig, goal, "M7")
    again = rig.on_message("M7", accepted(goal))
    assert sent(again, Confirmed, to="M7") == [Confirmed(task=goal, epoch=1)]
    assert facts(again, GoalContracted) == []
    stranger = rig.on_message("M8", accepted(goal))
    assert sent(stranger, Confirmed) == []
    assert sent(stranger, Release, to="M8")


def test_an_acceptance_of_a_goal_that_has_ended_is_released_and_not_confirmed() -> None:
    rig = released(order(pump=24))
    [(goal, _, _)] = announced(rig.all)
    contract(rig, goal, "M7")
    rig.on_message("gateway", OrderCancelled(order="O1"))
    effects = rig.on_message("M7", accepted(goal))
    assert sent(effects, Confirmed) == []
    assert sent(effects, Release, to="M7")


def test_a_machine_whose_acceptance_was_lost_makes_nothing_of_the_goal_that_another_one_got() -> None:
    rig = released(order(pump=24))
    stock = {"housing": 72, "impeller": 90, "seal-kit": 120}
    machines = {"M7": MachineRig("M7", stock), "M8": MachineRig("M8", stock)}
    [asked] = published(rig.all, TaskAnnounced)
    for name, machine in machines.items():
        machine.start()
        [offer] = sent(machine.on_message("STRATEGIST", asked), Bid)
        rig.on_message(name, offer)
    rig.run(0.5)
    [first] = [name for name in machines if sent(rig.all, Award, to=name)]
    [second] = [name for name in machines if name != first]
    assert sent(machines[first].on_message("STRATEGIST", sent(rig.all, Award)[0]), Accepted)  # It is lost.
    effects = rig.run(2.0)  # The release of the first is lost, too.
    [answer] = sent(machines[second].on_message("STRATEGIST", sent(effects, Award, to=second)[0]), Accepted)
    [confirmed] = sent(rig.on_message(second, answer), Confirmed, to=second)
    machines[second].on_message("STRATEGIST", confirmed)
    [repeated] = sent(machines[first].run(4.0), Accepted)
    for message in sent(rig.on_message(first, repeated), Release, to=first):
        machines[first].on_message("STRATEGIST", message)
    machines[first].run(60.0)
    assert machines[second].is_cycling
    assert not machines[first].is_cycling
    assert machines[first].heartbeats(MachineHeartbeat)[-1].goals == ()


def test_a_silent_machine_is_released_and_the_next_one_asked() -> None:
    rig = released(order(pump=24))
    [(goal, _, _)] = announced(rig.all)
    rig.on_message("M7", goal_bid(goal, 100.0))
    rig.on_message("M8", goal_bid(goal, 200.0))
    rig.run(2.0)
    assert sent(rig.all, Release, to="M7")
    assert sent(rig.all, Award, to="M8")


def test_a_goal_for_which_no_machine_bids_stays_announced() -> None:
    rig = released(order(pump=24))
    rig.run(3600.0)
    rounds = published(rig.all, TaskAnnounced)
    assert len(rounds) > 50
    goal = rounds[0].task
    contract(rig, goal, "M7")
    assert len(facts(rig.all, GoalContracted)) == 1


def test_no_secondary_is_sought_for_a_goal() -> None:
    rig = released(order(pump=24))
    [(goal, _, _)] = announced(rig.all)
    rig.on_message("M8", goal_bid(goal, 200.0))
    contract(rig, goal, "M7")
    assert sent(rig.run(600.0), Award) == []


# --- when nobody could take them -----------------------------------------------------------------


def test_a_goal_that_nobody_alive_can_take_waits_and_says_so_once() -> None:
    rig = StrategistRig()
    rig.start()
    rig.run(60.0)
    rig.on_message("gateway", order(pump=24 * 5))
    rig.run(600.0)
    waiting = [fact.goal for fact in facts(rig.all, GoalWaits)]
    assert len(waiting) == len(set(waiting)) == len(facts(rig.all, OrderAccepted)[0].goals)


def test_an_order_that_can_be_made_does_not_wait_for_one_that_cannot() -> None:
    rig = StrategistRig()
    rig.start()
    beats(rig, 60.0, "M10")  # Which makes motors and nothing else.
    rig.on_message("gateway", order("O1", pump=24))
    rig.on_message("gateway", order("O2", motor=20))
    assert [fact.order for fact in facts(rig.all, GoalWaits)] == ["O1"]
    [motor] = [goal for goal, product, _ in announced(rig.all) if product == "motor-e4"]
    contract(rig, motor, "M10")
    rig.arrive(motor, 20)
    assert [fact.order for fact in facts(rig.all, OrderFulfilled)] == ["O2"]
