"""The strategist: turns orders into goals, and never decides a transport (paper, 3.2)."""

from __future__ import annotations

import msgspec
import pytest
from bureau import announced, contract, contract_all, done, order, released
from defaults import KEYS, PLANT
from effects import deeds, facts, listening, published, sent
from rigs import StrategistRig
from spoken import announcement, award, declined, goal_bid, mhb, rhb

from dray.body import Repaired
from dray.errors import ProtocolViolation
from dray.messages import (
    Award,
    BillLine,
    Confirmed,
    Docked,
    DwellPointClaimed,
    GoalClosed,
    MachineCycle,
    OrderItem,
    OrderReleased,
    OrderTaken,
    ProductDefinition,
    Production,
    TaskAnnounced,
    Transport,
    Withdrawn,
)
from dray.messages.fact import GoodsDelivered, OrderAccepted, OrderFulfilled, TaskClosed
from dray.protocol.runtime.events import NEVER_S, Publish, Started

# --- orders become goals ----------------------------------------------------------------------------


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
    effects = rig.on_message("gateway", order(pump=24))
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
    effects = rig.on_message("gateway", OrderReleased(order="O1", items=items, due_s=3600.0))
    assert len(effects) == 1
    assert deeds(effects) == []


def test_all_machines_are_heard_from_the_beginning() -> None:
    rig = StrategistRig()
    assert listening(rig.start()) == {KEYS.all_machine_heartbeats}


# --- following --------------------------------------------------------------------------------------


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
    effects = rig.on_message("M7", mhb("M7", done(goal, 24)))
    assert facts(effects, TaskClosed) == []
    assert sent(effects, Confirmed, to="M7") == [Confirmed(task=goal, epoch=1, arrived=0)]


def test_a_machine_that_is_not_bound_is_told_so_once_the_goal_is_anothers() -> None:
    rig = released(order(pump=120))
    [(goal, _, quantity), *_] = announced(rig.all)
    assert deeds(rig.on_message("M8", mhb("M8", done(goal, quantity)))) == []
    contract(rig, goal, "M7")
    effects = rig.on_message("M8", mhb("M8", done(goal, quantity), seq=2))
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
    effects = rig.on_message(machine, mhb(machine, done(goal, quantity), seq=2))
    assert sent(effects, GoalClosed, to=machine) == [GoalClosed(goal=goal)]
    assert facts(effects, TaskClosed) == []


def test_a_goal_that_nobody_knows_is_over() -> None:
    rig = released(order(pump=24))
    effects = rig.on_message("M7", mhb("M7", done("X1", 24), done("X2", 24, delivered=23)))
    assert sent(effects, GoalClosed, to="M7") == [GoalClosed(goal="X1")]
    assert [message.task for message in sent(effects, Withdrawn, to="M7")] == ["X2"]


def test_a_fulfilled_order_that_is_released_again_is_said_to_be_so_and_not_made_again() -> None:
    rig = released(order(pump=24))
    [(goal, _, _)] = announced(rig.all)
    contract(rig, goal, "M7")
    rig.arrive(goal, 23)
    assert sent(rig.on_message("gateway", order(pump=24)), OrderTaken) == [OrderTaken(order="O1")]
    rig.arrive(goal, 1)
    effects = rig.on_message("gateway", order(pump=24))
    assert sent(effects, OrderTaken) == [OrderTaken(order="O1", fulfilled=True)]
    assert announced(effects) == []


# --- robustness -------------------------------------------------------------------------------------


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
        DwellPointClaimed(dwell_point="CH1", atv="ATV1", battery_frac=0.5, standing=False),
        goal_bid("G9", 1.0),
        declined("G9"),
    ):
        assert deeds(rig.on_message("X", message)) == [], message


def test_a_strategist_has_a_gate_and_no_other_body() -> None:
    with pytest.raises(ProtocolViolation, match="no body"):
        released(order(pump=24)).report(Repaired())
    with pytest.raises(ProtocolViolation, match="needs a gate"):
        StrategistRig().handle(Started(None))


def test_being_woken_for_nothing_is_harmless() -> None:
    assert released(order(pump=24)).wake() == []


NEW = ProductDefinition(
    lot=4,
    ability="tote",
    bill=(BillLine("shaft", 1),),
    revision=3,
    machines=(MachineCycle("M3", 10.0), MachineCycle("M4", 12.0)),
)


def new_order(definition: ProductDefinition | None = NEW) -> OrderReleased:
    return OrderReleased("O1", (OrderItem("new", 8, definition),), 7200.0)


def test_a_goal_carries_its_product_as_the_order_had_it() -> None:
    rig = released(new_order())
    work = published(rig.all, TaskAnnounced)[0].work
    assert isinstance(work, Production)
    assert (work.quantity, work.definition) == (4, NEW)


def test_machines_that_a_definition_names_are_asked_by_name() -> None:
    asked = {
        effect.key
        for effect in released(new_order()).all
        if isinstance(effect, Publish) and isinstance(effect.message, TaskAnnounced)
    }
    assert asked == {KEYS.goals("new"), KEYS.goals("M3"), KEYS.goals("M4")}


def test_a_product_of_the_plant_file_is_announced_once() -> None:
    rig = released(order(pump=24))
    keys = [
        effect.key
        for effect in rig.all
        if isinstance(effect, Publish) and isinstance(effect.message, TaskAnnounced)
    ]
    assert keys == [KEYS.goals("pump-p3")]


@pytest.mark.parametrize("definition", [None, msgspec.structs.replace(NEW, machines=())])
def test_an_order_for_what_nobody_makes_is_not_taken(definition: ProductDefinition | None) -> None:
    assert sent(released(new_order(definition)).all, OrderTaken) == []
