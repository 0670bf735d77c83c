"""A handover is believed when the dock where the load was to go has counted it; the difference is told and has a price."""

from __future__ import annotations

import pytest
from bureau import contract_all, order, released
from effects import award_number, committed, facts, instructed, sent
from m7 import FULL, NO_HOUSINGS, handover, m7
from msgspec.structs import replace
from rigs import BlindRig, MachineRig
from spoken import accepted, bid, production, rhb

from dray.body import Book, GoodsArrived
from dray.messages import (
    Award,
    Brought,
    Confirmed,
    GoalClosed,
    Handover,
    HandoverAccepted,
    Phase,
    Reason,
    Superseded,
    Withdrawn,
)
from dray.messages.fact import ContractorRated, HandoverDisputed, TaskClosed
from dray.protocol.runtime.events import Effect
from dray.protocol.transports.receiving import COUNT_S

LOT = 24


def doubting(rig: MachineRig) -> MachineRig:
    """Let it look at handovers as it does in service; prices are plain numbers all the same."""
    machine = rig.agent
    machine._message_handlers = {
        **machine._message_handlers,
        Handover: machine._flow.message_handlers[Handover],
    }
    return rig


def supplied(atv: str = "ATV2") -> MachineRig:
    """M7 without housings; a vehicle is contracted to bring some (M7-1)."""
    rig = doubting(m7(NO_HOUSINGS, goal=LOT))
    rig.hire("M7-1", atv)
    return rig


def quantity(rig: MachineRig, task: str = "M7-1") -> int:
    [opened] = [each for each in rig.agent._flow.tasks if each.id == task]
    return opened.work.quantity


def beats(rig: MachineRig, until_s: float, *, task: str = "M7-1", phase: Phase = Phase.HANDING_OVER) -> None:
    """The carrier lives, comes nearer, and names its task."""
    seq = 1000
    while rig.now_s < until_s:
        rig.run(rig.now_s + 1.0)
        seq += 1
        beat = rhb("ATV2", seq, rig.now_s, task=task, coordinator="M7")
        assert beat.task is not None
        rig.on_message("ATV2", replace(beat, task=replace(beat.task, phase=phase)))


def says(rig: MachineRig, pieces: int, task: str = "M7-1", epoch: int = 1) -> list[Effect]:
    return rig.on_message("ATV2", handover(task, epoch, pieces))


def disputed(rig: MachineRig) -> list[tuple[str, int, int]]:
    return [(each.contractor, each.said, each.counted) for each in facts(rig.all, HandoverDisputed)]


# --- material ------------------------------------------------------------------------------------


def test_material_that_was_counted_is_accepted_at_once() -> None:
    rig = supplied()
    pieces = quantity(rig)
    rig.stocked("housing", pieces, "ATV2")
    assert sent(says(rig, pieces), HandoverAccepted, to="ATV2")
    assert disputed(rig) == []


def test_a_word_that_comes_before_the_count_waits_for_it_and_is_accepted_by_it() -> None:
    rig = supplied()
    pieces = quantity(rig)
    assert sent(says(rig, pieces), HandoverAccepted) == []
    effects = rig.stocked("housing", pieces, "ATV2")
    assert sent(effects, HandoverAccepted, to="ATV2")
    assert [each.outcome for each in facts(effects, TaskClosed)] == ["delivered"]
    assert disputed(rig) == []


def test_material_that_nobody_has_counted_is_disputed_and_brought_by_somebody_else() -> None:
    rig = supplied()
    pieces = quantity(rig)
    says(rig, pieces)
    beats(rig, rig.now_s + COUNT_S)
    answered = says(rig, pieces)
    assert disputed(rig) == [("ATV2", pieces, 0)]
    assert sent(answered, HandoverAccepted) == []
    assert [each.epoch for each in sent(answered, Superseded, to="ATV2")] == [2]
    assert facts(rig.all, TaskClosed) == []
    assert rig.agent._flow.tasks.reliability.is_restricted("ATV2", rig.now_s)
    rig.on_message("ATV3", bid(50.0, task="M7-1", epoch=2))
    effects: list[Effect] = []
    while not sent(effects, Award, to="ATV3") and rig.now_s < 60.0:
        effects = rig.run(rig.now_s + 0.1)
    rig.on_message("ATV3", accepted("M7-1", epoch=2, number=award_number(effects, "ATV3", "M7-1")))
    rig.stocked("housing", pieces, "ATV3")
    effects = rig.on_message("ATV3", handover("M7-1", 2, pieces))
    assert sent(effects, HandoverAccepted, to="ATV3")


def test_what_is_missing_of_a_load_is_ordered_again_and_no_more() -> None:
    rig = supplied()
    pieces = quantity(rig)
    rig.stocked("housing", pieces - 4, "ATV2")
    says(rig, pieces)
    beats(rig, rig.now_s + COUNT_S)
    effects = says(rig, pieces)
    assert disputed(rig) == [("ATV2", pieces, pieces - 4)]
    assert sent(effects, HandoverAccepted, to="ATV2")
    assert [each.reason for each in facts(effects, ContractorRated)][-1] == Reason.NOT_COUNTED
    [level] = [each for each in rig.agent._supply.levels() if each.item == "housing"]
    assert level.on_order == sum(
        each.work.quantity for each in rig.agent._flow.tasks if each.work.item == "housing"
    )


def test_what_another_vehicle_has_brought_is_not_counted_for_the_one_that_says_so() -> None:
    rig = supplied()
    pieces = quantity(rig)
    rig.stocked("housing", pieces, "ATV9")
    assert sent(says(rig, pieces), HandoverAccepted) == []


# --- goods ---------------------------------------------------------------------------------------


def sending() -> tuple[MachineRig, str]:
    """M7 with a lot of pumps on board of ATV2; the machine, and the transport's name."""
    rig = doubting(m7(FULL, goal=2 * LOT))
    rig.cycles(LOT)
    [task] = [each.id for each in rig.agent._flow.tasks if each.work.goal == "G1"]
    rig.hire(task, "ATV2")
    rig.stocked("pump-p3", -LOT, "ATV2")
    return rig, task


def gate(rig: MachineRig, arrived: int, **brought: int) -> list[Effect]:
    """The strategist tells what the gate has counted."""
    by = tuple(Brought(vehicle, pieces) for vehicle, pieces in brought.items())
    return rig.on_message("STRATEGIST", Confirmed("G1", 1, arrived, by))


def test_goods_are_accepted_when_the_gate_has_counted_them() -> None:
    rig, task = sending()
    assert sent(says(rig, LOT, task), HandoverAccepted) == []
    assert sent(gate(rig, LOT, ATV2=LOT), HandoverAccepted, to="ATV2")
    assert rig.agent._goals.get("G1").delivered == LOT
    assert disputed(rig) == []


def test_the_last_goods_of_a_goal_are_accepted_when_it_is_closed() -> None:
    rig, task = sending()
    says(rig, LOT, task)
    effects = rig.on_message("STRATEGIST", GoalClosed(goal="G1"))
    assert sent(effects, HandoverAccepted, to="ATV2")


def test_goods_that_the_gate_has_not_counted_are_disputed_and_made_anew() -> None:
    rig, task = sending()
    says(rig, LOT, task)
    beats(rig, rig.now_s + COUNT_S, task=task)
    effects = gate(rig, 0) + says(rig, LOT, task)
    assert disputed(rig) == [("ATV2", LOT, 0)]
    assert sent(effects, HandoverAccepted) == []
    assert sent(effects, Withdrawn, to="ATV2")
    goal = rig.agent._goals.get("G1")
    assert (goal.delivered, goal.lost_in_transit, goal.to_make) == (0, LOT, 2 * LOT)


def test_nobody_is_credited_with_what_another_one_has_brought() -> None:
    rig, task = sending()
    says(rig, LOT, task)
    assert sent(gate(rig, LOT, ATV5=LOT), HandoverAccepted) == []


def test_what_the_gate_names_nobody_for_may_be_anybodys_and_counts_once() -> None:
    rig, task = sending()
    says(rig, LOT, task)
    assert sent(gate(rig, LOT), HandoverAccepted, to="ATV2")
    goal = rig.agent._goals.get("G1")
    assert goal.arrived_by("ATV3") == goal.arrived_by("ATV2") == 0


def test_while_the_strategist_is_away_a_carrier_is_let_go_on_its_word() -> None:
    rig, task = sending()
    says(rig, LOT, task)
    beats(rig, rig.now_s + COUNT_S, task=task)
    assert sent(says(rig, LOT, task), HandoverAccepted, to="ATV2")
    assert disputed(rig) == []


def test_goods_that_have_not_left_are_not_delivered_by_anybodys_word() -> None:
    rig = doubting(m7(FULL, goal=2 * LOT))
    rig.cycles(LOT)
    [task] = [each.id for each in rig.agent._flow.tasks if each.work.goal == "G1"]
    rig.hire(task, "ATV2")
    says(rig, LOT, task)
    beats(rig, rig.now_s + COUNT_S, task=task)
    says(rig, LOT, task)
    assert disputed(rig) == [("ATV2", LOT, 0)]


# --- a body that does not count ------------------------------------------------------------------


def test_where_the_body_does_not_count_the_carriers_word_is_booked() -> None:
    rig = BlindRig("M7", NO_HOUSINGS)
    rig.start()
    rig.take_goal("G1", production(quantity=LOT))
    rig = doubting(rig)
    rig.hire("M7-1", "ATV2")
    pieces = quantity(rig)
    effects = says(rig, pieces)
    assert instructed(effects, Book) == [Book("ATV2", "housing", pieces, task="M7-1", epoch=1)]
    assert sent(rig.stocked("housing", pieces, "ATV2"), HandoverAccepted, to="ATV2")
    assert instructed(says(rig, pieces), Book) == []


def test_no_carrier_is_believed_that_it_has_brought_more_than_it_was_given() -> None:
    rig = BlindRig("M7", NO_HOUSINGS)
    rig.start()
    rig.take_goal("G1", production(quantity=LOT))
    rig = doubting(rig)
    rig.hire("M7-1", "ATV2")
    pieces = quantity(rig)
    effects = says(rig, 2**53)
    assert instructed(effects, Book) == [Book("ATV2", "housing", pieces, task="M7-1", epoch=1)]
    rig.stocked("housing", pieces, "ATV2")
    assert disputed(rig) == [("ATV2", 2**53, pieces)]


def blind_with_goods() -> tuple[BlindRig, str]:
    """M7, which does not count, with a lot of goods that ATV2 is to fetch; and the task."""
    rig = BlindRig("M7", FULL)
    rig.start()
    rig.take_goal("G1", production(quantity=LOT))
    doubting(rig).cycles(LOT)
    [task] = [each.id for each in rig.agent._flow.tasks if each.work.goal == "G1"]
    rig.hire(task, "ATV2")
    return rig, task


def test_where_the_body_does_not_count_goods_are_booked_out_once_their_carrier_has_them() -> None:
    rig, task = blind_with_goods()
    beats(rig, rig.now_s + 3.0, task=task, phase=Phase.LOADING)
    assert instructed(rig.all, Book) == []
    beats(rig, rig.now_s + 3.0, task=task, phase=Phase.CARRYING)
    says(rig, LOT, task)
    assert instructed(rig.all, Book) == [Book("ATV2", "pump-p3", -LOT, task=task, epoch=1)]


@pytest.mark.parametrize("is_answered", [True, False])
def test_goods_that_were_booked_out_are_booked_out_no_more_by_the_next_life(*, is_answered: bool) -> None:
    first, task = blind_with_goods()
    beats(first, first.now_s + 3.0, task=task, phase=Phase.CARRYING)
    if is_answered:
        first.stocked("pump-p3", -LOT, "ATV2")
    # Its body's memory was damaged meanwhile, and people have counted: it knows of no report.
    rig = BlindRig("M7", first.stock, incarnation=2)
    rig.memory, rig.now_s = committed(first.all), first.now_s
    rig.start()
    beats(rig, rig.now_s + 3.0, task=task, phase=Phase.CARRYING)
    says(doubting(rig), LOT, task)
    again = [] if is_answered else [Book("ATV2", "pump-p3", -LOT, task=task, epoch=1)]
    assert instructed(rig.all, Book) == again


def test_goods_whose_carrier_was_not_heard_on_its_way_are_booked_out_by_its_handover() -> None:
    rig, task = blind_with_goods()
    assert instructed(says(rig, LOT, task), Book) == [Book("ATV2", "pump-p3", -LOT, task=task, epoch=1)]


def test_material_is_booked_in_by_its_handover_and_not_by_a_carrier_that_is_on_its_way() -> None:
    rig = BlindRig("M7", NO_HOUSINGS)
    rig.start()
    rig.take_goal("G1", production(quantity=LOT))
    doubting(rig).hire("M7-1", "ATV2")
    beats(rig, rig.now_s + 3.0, phase=Phase.CARRYING)
    assert instructed(rig.all, Book) == []


# --- the strategist tells whose goods have come in -------------------------------------------------


@pytest.mark.parametrize("vehicle", ["ATV2", ""])
def test_the_machine_hears_at_once_what_the_gate_has_counted_and_by_whom(vehicle: str) -> None:
    rig = released(order(pump=LOT))
    [(goal, (machine, _))] = contract_all(rig).items()
    effects = rig.report(GoodsArrived(goal=goal, arrived=4, admitted=LOT, vehicle=vehicle))
    [told] = sent(effects, Confirmed, to=machine)
    assert told.arrived == 4
    assert told.brought == ((Brought(vehicle, 4),) if vehicle else ())
