"""Goals for products that the machine was not set up for: the goal alone says what they are made of."""

from __future__ import annotations

import pytest
from effects import committed, instructed, published, sent
from m7 import FULL, incoming, m7, outgoing, transports
from msgspec.structs import replace
from rigs import MachineRig
from spoken import announcement, production

from dray.body import StartCycle
from dray.memory import WHOLE, MachineMemory
from dray.messages import (
    Accepted,
    Bid,
    BillLine,
    Declined,
    MachineCycle,
    ProductDefinition,
    Production,
    Refusal,
    TaskAnnounced,
)
from dray.messages.fact import BidRefused
from dray.protocol.runtime.events import Record

PUMP_OF_SHAFTS = ProductDefinition(
    lot=4,
    ability="pallet",
    bill=(BillLine("housing", 1), BillLine("shaft", 2)),
    name="Shaft pump",
    revision=3,
    machines=(MachineCycle("M7", 33.0),),
)


def goal(quantity: int = 4, definition: ProductDefinition = PUMP_OF_SHAFTS) -> Production:
    return Production("shaft-pump", quantity, "O1", 0, definition)


def put_up(work: Production) -> TaskAnnounced:
    return announcement(task="G1", coordinator="STRATEGIST", work=work)


def test_a_machine_bids_for_what_a_definition_says_it_can_make() -> None:
    [bid] = sent(m7(FULL | {"shaft": 8}).on_message("STRATEGIST", put_up(goal())), Bid)
    assert bid.cost.total_s == 4 * 33.0


def test_its_own_word_on_a_cycle_comes_first() -> None:
    own = production(quantity=1)
    told = replace(own, definition=replace(own.definition, machines=(MachineCycle("M7", 1.0),)))
    [bid] = sent(m7().on_message("STRATEGIST", put_up(told)), Bid)
    assert bid.cost.total_s == 50.0


def test_it_fetches_and_uses_what_the_goal_names() -> None:
    rig = m7(FULL)
    rig.take_goal("G1", goal())
    assert incoming(rig.all) == [("shaft", 40)]
    [cycle] = instructed(rig.stocked("shaft", 40), StartCycle)
    assert cycle == StartCycle(product="shaft-pump", bill=PUMP_OF_SHAFTS.bill, cycle_s=33.0)
    assert rig.stock["shaft"] == 38
    assert rig.stock["impeller"] == FULL["impeller"]


def test_goods_leave_in_the_containers_of_the_goal() -> None:
    rig = m7(FULL | {"shaft": 40})
    rig.take_goal("G1", goal(8))
    rig.cycles(4)
    assert outgoing(rig.all) == [("G1", 4)]
    assert [work.ability for work in transports(rig.all) if work.goal] == ["pallet"]
    rig.run(10.0)
    assert "shaft-pump" in {level.item for level in rig.reported_stock()[1]}


def test_a_goal_in_work_keeps_its_revision() -> None:
    rig = m7(FULL | {"shaft": 40})
    rig.take_goal("G1", goal(2), deadline_s=100.0)
    newer = replace(PUMP_OF_SHAFTS, bill=(BillLine("housing", 1),), revision=4)
    rig.take_goal("G2", goal(1, newer), deadline_s=200.0)
    rig.cycles(2)
    bills = [cycle.bill for cycle in instructed(rig.all, StartCycle)]
    assert bills == [PUMP_OF_SHAFTS.bill, PUMP_OF_SHAFTS.bill, newer.bill]


def test_the_next_life_knows_the_goal_and_what_lies_there() -> None:
    rig = m7(FULL | {"shaft": 40})
    rig.take_goal("G1", goal(2))
    rig.cycle()
    memory = committed(rig.all)
    kept = memory[WHOLE]
    assert isinstance(kept, MachineMemory)
    assert [(each.product, each.definition) for each in kept.products] == [("shaft-pump", PUMP_OF_SHAFTS)]
    again = MachineRig("M7", rig.stock, incarnation=2)
    again.memory, again.now_s = {WHOLE: replace(kept, goals=())}, rig.now_s
    again.start()
    again.run(again.now_s + 10.0)
    assert [
        (level.item, level.spare) for level in again.reported_stock()[1] if level.item == "shaft-pump"
    ] == [("shaft-pump", 1)]


@pytest.mark.parametrize(
    ("bill", "why"),
    [
        ((BillLine("gold", 1),), "no material gold"),
        ((BillLine("housing", 10_000),), "10000 housing do not fit into a buffer of 72"),
        ((BillLine("housing", 1), BillLine("housing", 1)), "housing is listed twice"),
    ],
)
def test_what_cannot_be_made_is_refused(bill: tuple[BillLine, ...], why: str) -> None:
    rig = m7()
    impossible = goal(definition=replace(PUMP_OF_SHAFTS, bill=bill))
    effects = rig.on_message("STRATEGIST", put_up(impossible))
    assert [
        (each.fact.reason, each.fact.detail)
        for each in effects
        if isinstance(each, Record) and isinstance(each.fact, BidRefused)
    ] == [(Refusal.ABILITY, why)]
    assert sent(effects, Bid) == []
    [declined] = sent(rig.award_goal("G1", impossible), Declined)
    assert declined.reason is Refusal.ABILITY


def test_a_goal_that_names_other_machines_is_none_of_its_business() -> None:
    others = goal(definition=replace(PUMP_OF_SHAFTS, machines=(MachineCycle("M8", 33.0),)))
    rig = m7()
    assert sent(rig.on_message("STRATEGIST", put_up(others)), Bid) == []
    assert sent(rig.award_goal("G1", others), Accepted) == []
    assert published(rig.all, TaskAnnounced) == []
