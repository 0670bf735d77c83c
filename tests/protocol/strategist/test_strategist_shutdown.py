"""The strategist that is asked to leave (paper, 4.2 case 6)."""

from __future__ import annotations

from effects import published, sent
from rigs import StrategistRig
from spoken import accepted, goal_bid

from dray.messages import OrderItem, OrderReleased, OrderTaken, TaskAnnounced

ORDER = OrderReleased(order="O1", items=(OrderItem(product="pump-p3", quantity=24),), due_s=7200.0)


def test_a_strategist_that_waits_for_nobody_leaves_at_once() -> None:
    rig = StrategistRig()
    rig.start()
    rig.leave()
    assert rig.has_left


def test_it_leaves_orders_unanswered_so_that_they_come_again() -> None:
    rig = StrategistRig()
    rig.start()
    rig.on_message("gateway", ORDER)
    rig.leave()
    assert not rig.has_left
    effects = rig.on_message("gateway", OrderReleased(order="O2", items=ORDER.items, due_s=7200.0))
    assert not sent(effects, OrderTaken)


def test_it_hears_the_answer_that_it_waits_for_and_puts_nothing_more_up() -> None:
    rig = StrategistRig()
    rig.start()
    items = (OrderItem(product="pump-p3", quantity=48),)
    rig.on_message("gateway", OrderReleased(order="O1", items=items, due_s=7200.0))
    [goal] = {said.task for said in published(rig.all, TaskAnnounced)}
    rig.leave()
    rig.on_message("M7", goal_bid(goal, 100.0))
    rig.run(1.0)
    rig.on_message("M7", accepted(goal))
    assert rig.has_left
    assert {said.task for said in published(rig.all, TaskAnnounced)} == {goal}
