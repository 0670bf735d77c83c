"""Invariants of tasks, pieces and orders: every check can fail; it is shown what it must not accept."""

from __future__ import annotations

from collections.abc import Callable
from random import Random

import msgspec
import pytest
from makings import making
from msgspec.structs import replace
from watched import OPENED, Watched

from dray.messages import (
    HandoverAccepted,
    MachineHeartbeat,
    MachineStatus,
    OrderItem,
    OrderReleased,
    OrderTaken,
    Reason,
    Role,
)
from dray.messages.fact import (
    AwardAnswered,
    CarrierChanged,
    ContractEnded,
    ContractTaken,
    OrderDropped,
    OrderFulfilled,
    TaskClosed,
)
from dray_sim.factory.sim_factory import SimFactory

CLOSED = TaskClosed(task="M8-1", epoch=1, outcome="delivered", carrier="ATV2")


def machine_heartbeat() -> MachineHeartbeat:
    return MachineHeartbeat(machine="M8", incarnation=1, seq=1, at_s=0.0, status=MachineStatus.IDLE)


def test_a_whole_task_breaks_nothing(watched: Watched) -> None:
    watched.say("M8", OPENED)
    taken = ContractTaken(task="M8-1", epoch=1, role=Role.PRIMARY, coordinator="M8")
    watched.say("ATV2", taken)
    watched.say("M8", HandoverAccepted(task="M8-1", epoch=1), ">ATV2")
    watched.say("M8", HandoverAccepted(task="M8-1", epoch=1), ">ATV2")
    watched.say("M8", CLOSED)
    ended = ContractEnded(task="M8-1", epoch=1, role=Role.PRIMARY, reason=Reason.HANDED_OVER)
    watched.say("ATV2", ended)
    watched.say("M8", machine_heartbeat())
    assert watched.broken == 0


def test_a_forgotten_task_is_noticed(watched: Watched) -> None:
    watched.say("M8", OPENED)
    watched.say("M8", machine_heartbeat())
    assert watched.broken == 1


def test_a_task_that_ends_twice_is_noticed(watched: Watched) -> None:
    watched.say("M8", OPENED)
    watched.say("M8", CLOSED)
    watched.say("M8", CLOSED)
    assert watched.broken == 1


def test_a_handover_to_two_carriers_is_noticed(watched: Watched) -> None:
    watched.say("M8", HandoverAccepted(task="M8-1", epoch=1), ">ATV2")
    watched.say("M8", HandoverAccepted(task="M8-1", epoch=2), ">ATV3")
    assert watched.broken == 2


def test_what_two_carriers_have_written_down_as_theirs_is_noticed(watched: Watched) -> None:
    ended = ContractEnded(task="M8-1", epoch=1, role=Role.PRIMARY, reason=Reason.HANDED_OVER)
    watched.say("ATV2", ended)
    watched.say("M8", HandoverAccepted(task="M8-1", epoch=1), ">ATV2")
    assert watched.broken == 0
    watched.say("ATV3", ended)
    assert watched.broken == 2


def test_a_task_that_changes_its_carrier_within_an_epoch_is_noticed(watched: Watched) -> None:
    watched.say("M8", OPENED)
    answered = AwardAnswered(task="M8-1", epoch=1, role=Role.PRIMARY, bidder="ATV2", answer="accepted")
    watched.say("M8", answered)
    changed = CarrierChanged(task="M8-1", epoch=2, replaced="ATV2", carrier="", reason=Reason.SILENT)
    watched.say("M8", changed)
    watched.say("M8", replace(answered, epoch=2, bidder="ATV3"))
    assert watched.broken == 0
    watched.say("M8", replace(changed, replaced="ATV3"))
    assert watched.broken == 2


def _steal_from_a_storage(factory: SimFactory) -> None:
    factory.storages["S3"].stock["shaft"] -= 1


def _conjure_into_a_warehouse(factory: SimFactory) -> None:
    factory.delivery["DELIVERY"].arrived["gear-unit-g2"] += 1


def _lose_on_the_way(factory: SimFactory) -> None:
    factory.storages["S3"].take("", "shaft", 5)


def _set_aside_what_nobody_made(factory: SimFactory) -> None:
    factory.delivery["DELIVERY"].aside["gear-unit-g2"] += 1


def _take_in_hand_what_was_not_there(factory: SimFactory) -> None:
    factory.in_hands["shaft"] += 1


@pytest.mark.parametrize(
    "tamper",
    [
        _steal_from_a_storage,
        _conjure_into_a_warehouse,
        _lose_on_the_way,
        _set_aside_what_nobody_made,
        _take_in_hand_what_was_not_there,
    ],
)
def test_a_piece_that_vanishes_or_appears_is_noticed(
    watched: Watched, tamper: Callable[[SimFactory], None]
) -> None:
    tamper(watched.factory)
    watched.say("M8", machine_heartbeat())
    assert watched.broken == 2


def test_what_people_carry_is_not_lost(watched: Watched) -> None:
    watched.factory.storages["S3"].take("", "shaft", 5)
    watched.factory.in_hands["shaft"] += 5
    watched.say("M8", machine_heartbeat())
    assert watched.broken == 0


def test_a_vehicle_with_two_tasks_is_noticed(watched: Watched) -> None:
    watched.say("ATV2", ContractTaken(task="M8-1", epoch=1, role=Role.PRIMARY, coordinator="M8"))
    watched.say("ATV2", ContractTaken(task="M9-1", epoch=1, role=Role.PRIMARY, coordinator="M9"))
    assert watched.broken == 3


def test_a_vehicle_may_watch_while_it_is_free(watched: Watched) -> None:
    watched.say("ATV2", ContractTaken(task="M8-1", epoch=1, role=Role.SECONDARY, coordinator="M8"))
    watched.say("ATV2", ContractTaken(task="M9-1", epoch=1, role=Role.SECONDARY, coordinator="M9"))
    assert watched.broken == 0


@pytest.fixture
def ordered(watched: Watched) -> Watched:
    """Forty-eight pumps were ordered, and M8 makes them all."""
    items = (OrderItem(product="pump-p3", quantity=48),)
    watched.say("desk", OrderReleased(order="O1", items=items, due_s=3600.0), ">strategist")
    watched.put_up("G1", 48)
    return watched


def test_an_order_that_is_delivered_to_the_piece_breaks_nothing(ordered: Watched) -> None:
    ordered.bring("G1", 24)
    ordered.bring("G1", 24)
    ordered.say("strategist", OrderFulfilled(order="O1"))
    assert ordered.broken == 0


def test_pieces_of_a_lost_goal_and_of_its_successor_add_up(ordered: Watched) -> None:
    ordered.bring("G1", 24)
    ordered.put_up("G2", 24)
    ordered.bring("G2", 24)
    ordered.say("strategist", OrderFulfilled(order="O1"))
    assert ordered.broken == 0


def test_more_than_was_ordered_is_noticed(ordered: Watched) -> None:
    ordered.bring("G1", 48)
    ordered.put_up("G2", 24)
    ordered.bring("G2", 24)
    assert ordered.broken == 4


def test_a_count_of_pieces_that_never_came_is_noticed(ordered: Watched) -> None:
    ordered.count("G1", 24)
    assert ordered.broken == 4


def test_a_goal_closed_too_early_is_noticed(ordered: Watched) -> None:
    ordered.bring("G1", 24)
    work = making("pump-p3", 48, "O1")
    ordered.say("strategist", msgspec.structs.replace(OPENED, task="G1", work=work))
    ordered.say("strategist", msgspec.structs.replace(CLOSED, task="G1"))
    assert ordered.broken == 4


def test_an_order_fulfilled_too_early_is_noticed(ordered: Watched) -> None:
    ordered.bring("G1", 47)
    ordered.say("strategist", OrderFulfilled(order="O1"))
    assert ordered.broken == 4


def test_an_order_that_is_said_to_be_fulfilled_and_is_not_is_noticed(ordered: Watched) -> None:
    ordered.bring("G1", 48)
    ordered.say("strategist", OrderTaken(order="O1"), ">desk")
    ordered.say("strategist", OrderFulfilled(order="O1"))
    ordered.say("strategist", OrderTaken(order="O1", fulfilled=True), ">desk")
    assert ordered.broken == 0
    ordered.say("strategist", OrderTaken(order="O2", fulfilled=True), ">desk")
    assert ordered.broken == 4


def test_an_order_that_was_dropped_is_not_counted(ordered: Watched) -> None:
    ordered.bring("G1", 24)
    ordered.say("strategist", OrderDropped(order="O1"))
    ordered.say("strategist", OrderFulfilled(order="O1"))
    assert ordered.broken == 0


def test_the_chances_of_a_factory_do_not_depend_on_one_another() -> None:
    """One generator per concern: drawing more of one leaves the others as they were."""
    assert Random("1 network").random() != Random("1 stock").random()
