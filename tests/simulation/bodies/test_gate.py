"""The gate of the delivery warehouses: how many pieces of a goal get in, and what is told about it."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from yard import Yard

from dray.body import Admit, GoodsArrived, Hold, Report
from dray_sim.bodies.gate import KEPT_GOALS, NOT_ADMITTED, Gate


@pytest.fixture
def gate(yard: Yard) -> Gate:
    gate = Gate(yard.clock)
    yard.listen("strategist", gate)
    return gate


def admit(goal: str, quantity: int) -> Admit:
    return Admit(goal=goal, quantity=quantity)


def arrived(goal: str, quantity: int, *, of: int) -> GoodsArrived:
    return GoodsArrived(goal=goal, arrived=quantity, admitted=of)


def test_nothing_gets_in_that_nobody_has_admitted(gate: Gate) -> None:
    assert gate.enter("G1", 1) == NOT_ADMITTED
    assert gate.sense().arrived == {}


def test_a_lot_gets_in_wholly_or_not_at_all(gate: Gate) -> None:
    gate.instruct(admit("G1", 12))
    assert gate.enter("G1", 10) == ""
    assert gate.enter("G1", 3) == NOT_ADMITTED
    assert gate.enter("G1", 2) == ""
    assert gate.sense().arrived == {"G1": 12}


def test_a_goal_uses_up_its_own_permit_only(gate: Gate) -> None:
    gate.instruct(admit("G1", 5))
    gate.instruct(admit("G2", 5))
    assert gate.enter("G1", 5) == ""
    assert gate.enter("G2", 5) == ""
    assert gate.enter("G1", 1) == NOT_ADMITTED


def test_every_admit_and_every_arrival_is_answered_with_what_is_in(yard: Yard, gate: Gate) -> None:
    assert yard.do(gate, admit("G1", 5)) == [arrived("G1", 0, of=5)]
    assert gate.enter("G1", 3) == ""
    assert yard.do(gate) == [arrived("G1", 3, of=5)]
    assert yard.do(gate, admit("G1", 6)) == [arrived("G1", 3, of=6)]


def test_no_report_comes_inside_an_instruction_or_an_arrival(yard: Yard, gate: Gate) -> None:
    gate.instruct(admit("G1", 5))
    gate.enter("G1", 3)
    assert yard.said == []
    assert yard.do(gate) == [arrived("G1", 0, of=5), arrived("G1", 3, of=5)]


def test_what_is_refused_is_not_told(yard: Yard, gate: Gate) -> None:
    gate.enter("G1", 1)
    assert yard.do(gate) == []


def test_a_shut_gate_tells_what_is_in_and_lets_nothing_more_in(yard: Yard, gate: Gate) -> None:
    yard.do(gate, admit("G1", 10))
    gate.enter("G1", 4)
    yard.do(gate)
    assert yard.do(gate, admit("G1", 0)) == [arrived("G1", 4, of=0)]
    assert gate.enter("G1", 1) == NOT_ADMITTED


def test_a_goal_that_is_shut_before_its_first_piece_stays_shut(yard: Yard, gate: Gate) -> None:
    assert yard.do(gate, admit("G1", 0)) == [arrived("G1", 0, of=0)]
    assert gate.enter("G1", 1) == NOT_ADMITTED


def test_a_new_agent_senses_what_arrived_while_nobody_listened(yard: Yard) -> None:
    gate = Gate(yard.clock)
    gate.instruct(admit("G1", 5))
    gate.enter("G1", 5)
    yard.run(1.0)
    heard: list[Report] = []
    gate.attach(heard.append)
    assert gate.sense().arrived == {"G1": 5}
    yard.run(2.0)
    assert heard == []


def test_a_full_memory_forgets_the_finished_goal_that_was_quiet_the_longest(yard: Yard) -> None:
    gate = Gate(yard.clock, kept=3)
    for goal in ("open", "first", "second"):
        gate.instruct(admit(goal, 1))
    gate.enter("second", 1)
    gate.enter("first", 1)
    gate.instruct(admit("new", 1))
    assert gate.sense().arrived == {"open": 0, "first": 1, "new": 0}


def test_a_full_memory_of_open_goals_forgets_the_quietest(yard: Yard) -> None:
    gate = Gate(yard.clock, kept=2)
    gate.instruct(admit("one", 5))
    gate.instruct(admit("two", 5))
    gate.enter("one", 1)
    gate.instruct(admit("three", 5))
    assert gate.sense().arrived == {"one": 1, "three": 0}


def test_the_goods_of_a_forgotten_goal_stay_outside(yard: Yard) -> None:
    gate = Gate(yard.clock, kept=1)
    gate.instruct(admit("one", 5))
    gate.instruct(admit("two", 5))
    assert gate.enter("one", 1) == NOT_ADMITTED


def test_the_memory_is_bounded(gate: Gate) -> None:
    for number in range(KEPT_GOALS + 10):
        gate.instruct(admit(f"G{number}", 1))
    assert len(gate.sense().arrived) == KEPT_GOALS


def test_what_only_a_vehicle_can_do_is_no_business_of_a_gate(yard: Yard, gate: Gate) -> None:
    assert yard.do(gate, Hold(), for_s=10.0) == []


GOALS = st.sampled_from(["G1", "G2", "G3"])


@given(st.lists(st.tuples(st.booleans(), GOALS, st.integers(0, 9)), max_size=60))
def test_no_goal_ever_gets_more_in_than_was_admitted_at_some_time(deeds: list[tuple[bool, str, int]]) -> None:
    gate = Gate(Yard().clock)
    most: dict[str, int] = {}
    inside: dict[str, int] = {}
    for admits, goal, quantity in deeds:
        if admits:
            gate.instruct(admit(goal, quantity))
            most[goal] = max(most.get(goal, 0), quantity)
            inside.setdefault(goal, 0)
        elif not gate.enter(goal, quantity):
            inside[goal] += quantity
            assert inside[goal] <= most[goal]
        assert gate.sense().arrived == inside
