"""The benchmark that kills: its judgement finds what is planted."""

from __future__ import annotations

from dataclasses import replace

import msgspec
import pytest
from check_kit import opened
from losses_kit import GOAL, Told, closed, heartbeat, taken

from dray.messages import Reason, Role
from dray.messages.fact import (
    AwardAnswered,
    CarrierChanged,
    ContractEnded,
    GoodsDelivered,
    OrderFulfilled,
    PieceMade,
)
from dray.store.orders.orders import Item, Order
from dray.store.orders.progress import OrderStatus
from dray_sim.bench.losses.history import History
from dray_sim.bench.losses.judgement import ENDED, Aftermath, judge
from dray_sim.bodies.floor import Pieces

ORDER = Order(
    id="O-1",
    status=OrderStatus.DELIVERED,
    customer="Benchmark",
    token="t",
    items=(Item("pump-p3", 24),),
    created_at_s=0.0,
    reference="D1",
    due_at_s=900.0,
    delivered_at_s=600.0,
)

PIECES = Pieces(balance={"shaft": 100, "pump-p3": 0}, delivered={}, arrived={})


def handed_over(task: str) -> ContractEnded:
    return ContractEnded(task=task, epoch=1, role=Role.PRIMARY, reason=Reason.HANDED_OVER)


def arrived(goal: str, pieces: int) -> GoodsDelivered:
    return GoodsDelivered(
        goal=goal, order="O-1", item=0, product="pump-p3", quantity=pieces, delivered=pieces
    )


def whole() -> Told:
    """One order, made and delivered, with one transport of material."""
    told = Told()
    told.by("strategist", opened("G1", GOAL))
    told.by("M8", opened("M8-1"))
    told.by("ATV2", taken("M8-1"), handed_over("M8-1"))
    told.by("M8", closed("M8-1"))
    told.by("strategist", arrived("G1", 24), closed("G1", "M8"), OrderFulfilled(order="O-1"))
    return told


def aftermath(told: Told) -> Aftermath:
    """Of a factory in which nothing went wrong, but for what was told."""
    return Aftermath(
        history=told.history,
        unwritten=[],
        heartbeats=[heartbeat()],
        accepted={"D1": "O-1"},
        refused={},
        orders=[ORDER],
        first=PIECES,
        last=Pieces(balance=PIECES.balance, delivered={"pump-p3": 24}, arrived={"G1": 24}),
        starts={"M8": 2, "ATV2": 1},
        kills={"M8": 1},
    )


def found(after: Aftermath) -> set[str]:
    return {finding.what for finding in judge(after) if finding.seen}


def test_where_nothing_is_wrong_nothing_is_found() -> None:
    after = aftermath(whole())
    assert found(after) == set()
    assert all(finding.of for finding in judge(after))


def test_a_task_that_its_machine_has_forgotten_is_found() -> None:
    told = whole()
    told.by("M8", opened("M8-2"))
    assert found(aftermath(told)) == {"tasks lost"}


def test_a_finding_hides_no_other() -> None:
    told = whole()
    told.by("M9", closed("M9-1"), closed("M9-2"))
    lost = next(finding for finding in judge(aftermath(told)) if finding.what == "tasks lost")
    assert len(lost.seen) == 2


def test_a_task_that_two_vehicles_have_handed_over_is_found() -> None:
    told = whole()
    told.by("ATV3", taken("M8-1"), handed_over("M8-1"))
    assert found(aftermath(told)) == {"handovers doubled"}


def test_a_vehicle_that_was_primary_of_two_tasks_is_found_over_its_lives() -> None:
    told = whole()
    told.by("ATV3", taken("M8-1"))
    told.by("ATV3", taken("M9-1"), life=2)
    assert found(aftermath(told)) == {"vehicles with two tasks"}


def test_a_carrier_that_is_released_from_a_contract_that_it_had_is_found() -> None:
    accepted = AwardAnswered(task="M8-2", epoch=1, role=Role.PRIMARY, bidder="ATV2", answer="accepted")
    released = ContractEnded(task="M8-2", epoch=1, role=Role.PRIMARY, reason=Reason.RELEASED)
    told = whole()
    told.by("M8", opened("M8-2"), accepted)
    told.by("ATV2", taken("M8-2"), released)
    told.by("M8", closed("M8-2"))
    assert found(aftermath(told)) == {"contracts lost for nothing"}


def test_a_carrier_that_comes_back_when_its_load_was_counted_is_released_for_a_reason() -> None:
    """It was killed before it heard of that, and its machine has lived anew since."""
    accepted = AwardAnswered(task="M8-2", epoch=1, role=Role.PRIMARY, bidder="ATV2", answer="accepted")
    told = whole()
    told.by("M8", opened("M8-2"), accepted, closed("M8-2"))
    told.by(
        "ATV2", taken("M8-2"), ContractEnded(task="M8-2", epoch=1, role=Role.PRIMARY, reason=Reason.RELEASED)
    )
    assert found(aftermath(told)) == set()


@pytest.mark.parametrize("answer", ["silent", "accepted"])
def test_a_carrier_is_released_for_a_reason_when_it_was_silent_or_replaced(answer: str) -> None:
    answered = AwardAnswered(task="M8-2", epoch=1, role=Role.PRIMARY, bidder="ATV2", answer=answer)
    replaced = CarrierChanged(task="M8-2", epoch=2, replaced="ATV2", carrier="", reason=Reason.SILENT)
    told = whole()
    told.by("M8", opened("M8-2"), answered, *([replaced] if answer == "accepted" else []))
    told.by(
        "ATV2",
        taken("M8-2"),
        ContractEnded(task="M8-2", epoch=1, role=Role.PRIMARY, reason=Reason.RELEASED),
    )
    told.by("M8", closed("M8-2"))
    assert found(aftermath(told)) == set()


def test_a_carrier_that_was_silent_is_released_for_a_reason_though_it_is_asked_again_and_accepts() -> None:
    def answered(answer: str) -> AwardAnswered:
        return AwardAnswered(task="M8-2", epoch=1, role=Role.PRIMARY, bidder="ATV2", answer=answer)

    released = ContractEnded(task="M8-2", epoch=1, role=Role.PRIMARY, reason=Reason.RELEASED)
    told = whole()
    told.by("M8", opened("M8-2"), answered("silent"))
    told.by("ATV2", taken("M8-2"), released, taken("M8-2"))
    told.by("M8", answered("accepted"), closed("M8-2"))
    assert found(aftermath(told)) == set()


def test_a_carrier_that_comes_back_when_its_task_was_withdrawn_is_released_for_a_reason() -> None:
    accepted = AwardAnswered(task="M8-2", epoch=1, role=Role.PRIMARY, bidder="ATV2", answer="accepted")
    told = whole()
    told.by("M8", opened("M8-2"), accepted, closed("M8-2", outcome="withdrawn"))
    told.by(
        "ATV2",
        taken("M8-2"),
        ContractEnded(task="M8-2", epoch=1, role=Role.PRIMARY, reason=Reason.RELEASED),
    )
    assert found(aftermath(told)) == set()


def test_an_accepted_order_that_is_not_delivered_is_found() -> None:
    after = aftermath(whole())
    in_work = msgspec.structs.replace(ORDER, status=OrderStatus.IN_PRODUCTION)
    assert found(replace(after, orders=[in_work])) == {"accepted orders lost"}


def test_an_accepted_order_that_nobody_knows_is_found() -> None:
    after = aftermath(whole())
    assert found(replace(after, accepted={"D1": "O-1", "D2": "O-2"})) == {"accepted orders lost"}


def test_an_order_that_is_there_twice_is_found() -> None:
    after = aftermath(whole())
    twin = msgspec.structs.replace(ORDER, id="O-2", items=())
    assert found(replace(after, orders=[ORDER, twin])) == {"orders doubled"}


def test_an_order_that_was_refused_is_found() -> None:
    assert found(replace(aftermath(whole()), refused={"D2": "no"})) == {"orders refused"}


@pytest.mark.parametrize("pieces", [23, 25])
def test_a_piece_too_few_or_too_many_at_the_gate_is_found(pieces: int) -> None:
    after = aftermath(whole())
    last = Pieces(balance=PIECES.balance, delivered={"pump-p3": pieces}, arrived={"G1": pieces})
    assert found(replace(after, last=last)) == {"pieces too many or too few"}


def test_pieces_that_arrived_beside_the_gate_are_found() -> None:
    after = aftermath(whole())
    last = msgspec.structs.replace(after.last, delivered={"pump-p3": 25})
    assert found(replace(after, last=last)) == {"pieces too many or too few"}


@pytest.mark.parametrize("pieces", [99, 101])
def test_material_that_is_lost_or_made_of_nothing_is_found(pieces: int) -> None:
    after = aftermath(whole())
    last = msgspec.structs.replace(after.last, balance={"shaft": pieces, "pump-p3": 0})
    assert found(replace(after, last=last)) == {"pieces lost or made of nothing"}


def test_a_process_that_ended_by_itself_is_found() -> None:
    after = aftermath(whole())
    assert found(replace(after, starts={"M8": 3, "ATV2": 1})) == {ENDED}


def test_a_hole_in_a_history_is_found() -> None:
    told = whole()
    del told.events[2]
    assert found(aftermath(told)) == {"holes in histories"}
    assert told.history.holes == ["ATV2, life 1: 1"]


def test_a_long_hole_is_told_in_few_words() -> None:
    told = Told()
    told.by("M8", *(PieceMade(goal="G1", product="pump-p3", made=made) for made in range(1, 13)))
    del told.events[2:7], told.events[4]
    assert told.history.holes == ["M8, life 1: 3 to 7, 10"]


def test_a_fact_that_only_its_agent_has_is_found() -> None:
    told = whole()
    told.by("M9", *(PieceMade(goal="G2", product="pump-p3", made=made) for made in range(1, 4)))
    written = History()
    written.add(told.events[:-2])
    unwritten = written.lacking(told.events)
    assert unwritten == ["M9, life 1: 2 to 3"]
    assert found(replace(aftermath(whole()), unwritten=unwritten)) == {"facts not in the database"}


def test_what_the_database_and_a_journal_both_have_is_told_once() -> None:
    told = whole()
    history = told.history
    history.add(told.events)
    assert history.events == told.events
