"""A machine obeys the strategist that holds an order with the highest epoch it has heard of."""

from __future__ import annotations

import pytest
from effects import remember, sent
from m7 import FULL, m7
from msgspec import UNSET
from msgspec.structs import replace
from rigs import MachineRig
from spoken import production

from dray.messages import (
    Accepted,
    Award,
    Confirmed,
    Declined,
    GoalClosed,
    HolderChanged,
    MachineHeartbeat,
    Reason,
    Refusal,
    Role,
    Withdrawn,
)
from dray.messages.base import COUNT_MAX
from dray.messages.overtaken import OVERTAKES_S

FIRST, SECOND, THIEF = "STRATEGIST", "strategist2", "strategist3"
WORK = production()


def named(rig: MachineRig) -> dict[str, object]:
    """The goals of its newest heartbeat, and with which epoch their orders are held."""
    rig.run(rig.now_s + 1.0)
    return {brief.goal: brief.held for brief in rig.heartbeats(MachineHeartbeat)[-1].goals}


def holder(rig: MachineRig) -> object:
    """Whom it obeys about its goal, by its newest heartbeat."""
    rig.run(rig.now_s + 1.0)
    [brief] = rig.heartbeats(MachineHeartbeat)[-1].goals
    return brief.holder


def taken_over() -> MachineRig:
    """Its goal was given by the first strategist, and the second one has taken the order over."""
    rig = m7()
    rig.take_goal("G1", WORK)
    assert named(rig) == {"G1": UNSET}
    rig.on_message(SECOND, HolderChanged(WORK.order, 2))
    return rig


def test_a_machine_says_with_which_epoch_its_order_is_held() -> None:
    assert named(taken_over()) == {"G1": 2}


def test_a_machine_obeys_who_holds_the_order_and_nobody_who_has_held_it() -> None:
    rig = taken_over()
    over = Withdrawn(task="G1", epoch=1, reason=Reason.NOT_NEEDED)
    rig.on_message(FIRST, over)
    rig.on_message(FIRST, GoalClosed(goal="G1"))
    rig.on_message(FIRST, HolderChanged(WORK.order, 1))
    assert named(rig) == {"G1": 2}
    rig.on_message(SECOND, over)
    assert named(rig) == {}


@pytest.mark.parametrize("epoch", [1, 2, 3], ids=["nobody has taken it over", "lower", "the same"])
@pytest.mark.parametrize("restarts", [False, True], ids=["this life", "the next life"])
def test_an_epoch_of_the_far_future_does_not_keep_the_holder_out_for_ever(epoch: int, restarts: bool) -> None:
    """A thief of a strategist's certificate has said it. The holder repeats its word while the machine names another one."""
    rig = taken_over()
    rig.on_message(THIEF, HolderChanged(WORK.order, 3 if epoch == 3 else COUNT_MAX))
    if restarts:
        again = MachineRig("M7", FULL, incarnation=2)
        again.memory, again.now_s = remember(rig.memory, rig.all), rig.now_s
        again.start()
        rig = again
    rig.on_message(SECOND, HolderChanged(WORK.order, epoch))
    assert holder(rig) == THIEF, "perhaps it came late"
    rig.run(rig.now_s + OVERTAKES_S + 0.1)
    rig.on_message(SECOND, HolderChanged(WORK.order, epoch))
    assert holder(rig) == SECOND
    rig.on_message(SECOND, GoalClosed(goal="G1"))
    assert named(rig) == {}


def test_who_holds_an_order_and_says_so_again_is_not_replaced_by_a_lower_epoch() -> None:
    rig = taken_over()
    for _ in range(3):
        rig.run(rig.now_s + 0.9 * OVERTAKES_S)
        rig.on_message(SECOND, HolderChanged(WORK.order, 2))
        rig.on_message(FIRST, HolderChanged(WORK.order, 1))
        assert holder(rig) == SECOND


def test_the_holder_of_another_order_changes_nothing() -> None:
    rig = m7()
    rig.take_goal("G1", WORK)
    rig.on_message(SECOND, HolderChanged("another", 2))
    rig.on_message(SECOND, Withdrawn(task="G1", epoch=1, reason=Reason.NOT_NEEDED))
    assert named(rig) == {"G1": UNSET}


def test_who_has_held_an_order_gives_no_more_goals_of_it_out() -> None:
    rig = taken_over()
    award = Award(task="G2", epoch=1, role=Role.PRIMARY, work=WORK, deadline_s=3600.0)
    [declined] = sent(rig.on_message(FIRST, award), Declined)
    assert declined.reason == Refusal.NOT_FIT
    assert sent(rig.on_message(SECOND, award), Accepted, to=SECOND)
    rig.on_message(SECOND, Confirmed(task="G2", epoch=1))
    assert named(rig) == {"G1": 2, "G2": 2}


def test_a_goal_that_nobody_has_confirmed_is_asked_for_where_the_order_is_held() -> None:
    rig = m7()
    rig.award_goal("G1", WORK)
    effects = rig.on_message(SECOND, HolderChanged(WORK.order, 2))
    assert sent(effects, Accepted, to=SECOND)


def test_a_machine_remembers_who_holds_an_order() -> None:
    rig = taken_over()
    again = MachineRig("M7", FULL, incarnation=2)
    again.memory = remember(rig.memory, rig.all)
    again.start()
    again.on_message(FIRST, Withdrawn(task="G1", epoch=1, reason=Reason.NOT_NEEDED))
    assert named(again) == {"G1": 2}
    other = replace(WORK, order="another")
    award = Award(task="G3", epoch=1, role=Role.PRIMARY, work=other, deadline_s=3600.0)
    assert sent(again.on_message(FIRST, award), Accepted, to=FIRST)
