"""A production machine goes on with what its earlier life has left."""

from __future__ import annotations

from typing import cast

import msgspec
import pytest
from effects import award_number, committed, facts, instructed, published, sent
from m7 import (
    FULL,
    NO_HOUSINGS,
    RELEASE,
    counted,
    delivered,
    docked,
    handover,
    m7,
    outgoing,
    status,
    supplied_by,
)
from rigs import MachineRig
from spoken import accepted, bid, production, rhb

from dray.body import CycleDone, StartCycle, WorkcellState
from dray.memory import WHOLE, MachineMemory
from dray.messages import (
    Accepted,
    Brief,
    Confirmed,
    DockOpened,
    HandoverAccepted,
    MachineHeartbeat,
    MachineStatus,
    Phase,
    Reason,
    Release,
    Resigned,
    Role,
    Superseded,
    TakenOver,
    TaskAnnounced,
)
from dray.messages.fact import PieceMade, TaskClosed
from dray.protocol.runtime.events import Commit
from dray.protocol.transports.transports import RECOVERY_WAIT_S


def reborn(rig: MachineRig, *, doubts: bool = False, **stock: int) -> MachineRig:
    """The machine is started again, with its workcell as it is and what it had written down."""
    stock = rig.stock | {key.replace("_", "-"): each for key, each in stock.items()}
    again = MachineRig("M7", stock, incarnation=2, doubts=doubts)
    again.memory, again.now_s = committed(rig.all), rig.now_s
    again.start()
    return again


def test_a_machine_goes_on_with_its_goals_and_asks_for_them_until_it_is_answered() -> None:
    rig = m7(goal=24)
    rig.cycles(5)
    again = reborn(rig)
    assert again.is_cycling
    assert counted(again) == [("G1", 5, 0)]
    asked = sent(again.all, Accepted, to="STRATEGIST")
    assert len(asked) > 1
    assert {(each.task, each.epoch) for each in asked} == {("G1", 1)}
    again.confirm_goal("G1")
    assert sent(again.run(again.now_s + 60.0), Accepted) == []
    again.cycles(19)
    assert outgoing(again.all) == [("G1", 24)]
    assert not again.is_cycling


def test_a_goal_that_others_have_got_meanwhile_ends_with_the_answer() -> None:
    rig = m7(goal=24)
    rig.cycles(5)
    again = reborn(rig)
    again.on_message("STRATEGIST", RELEASE)
    again.cycle()
    assert counted(again) == []
    again.take_goal("G2", production(quantity=6))
    assert outgoing(again.all) == [("G2", 6)]


def test_goods_on_the_way_are_neither_made_again_nor_counted_twice() -> None:
    rig = m7(goal=30)
    rig.cycles(25)
    first, *_ = [each.task for each in published(rig.all, TaskAnnounced) if each.work.goal]  # type: ignore[union-attr]
    rig.hire(first, "ATV2")
    rig.stocked("pump-p3", -24, "ATV2")
    again = reborn(rig)
    again.on_message(
        "STRATEGIST", Confirmed(task="G1", epoch=1, arrived=24)
    )  # It is in, and not handed over yet.
    assert counted(again) == [("G1", 25, 0)]
    again.on_message("ATV2", handover(first))
    assert counted(again) == [("G1", 25, 24)]
    again.stock |= FULL
    again.run(again.now_s + 5.0)
    again.cycles(5)
    assert outgoing(again.all)[-1] == ("G1", 6)
    assert not again.is_cycling


def test_goods_that_wait_for_a_vehicle_are_no_spare_pieces_in_the_next_life() -> None:
    rig = m7(goal=2)
    rig.cycles(2)
    again = reborn(rig)
    again.take_goal("G2", production(quantity=1))
    assert again.is_cycling


def test_a_piece_that_was_made_between_two_lives_serves_the_goal() -> None:
    rig = m7(goal=2)
    rig.cycle()
    again = reborn(rig, pump_p3=2)
    assert not again.is_cycling
    assert outgoing(again.all) == [("G1", 2)]


def test_what_was_handed_over_is_written_down_before_the_vehicle_is_told() -> None:
    rig = m7(goal=24)
    rig.cycles(24)
    [task] = [each.task for each in published(rig.all, TaskAnnounced) if each.work.goal]  # type: ignore[union-attr]
    effects = delivered(rig, task)
    assert isinstance(effects[0], Commit)
    note = committed(effects)[WHOLE]
    assert isinstance(note, MachineMemory)
    assert [(goal.made, goal.delivered) for goal in note.goals] == [(24, 24)]


def test_a_cycle_that_an_earlier_life_has_begun_makes_a_piece_for_the_next_goal() -> None:
    rig = MachineRig("M7", FULL, incarnation=2)
    rig.start()
    rig.stock["pump-p3"], rig.seq = 1, 1
    rig.report(CycleDone(product="pump-p3", seq=rig.seq))
    assert facts(rig.all, PieceMade) == []
    effects = rig.take_goal("G1", production(quantity=3))
    assert [(fact.goal, fact.made) for fact in facts(effects, PieceMade)] == [("G1", 1)]
    rig.cycles(2)
    assert not rig.is_cycling
    assert outgoing(rig.all) == [("G1", 3)]


def test_a_machine_that_starts_in_the_middle_of_a_cycle_waits_for_its_end() -> None:
    class Running(MachineRig):
        def sense(self) -> WorkcellState:
            return WorkcellState(stock=dict(self.stock), seq=0, cycling="pump-p3", broken="")

    rig = Running("M7", FULL, incarnation=2)
    rig.start()
    rig.take_goal("G1", production(quantity=3))
    assert instructed(rig.all, StartCycle) == []
    rig.run(1.0)
    assert status(rig) is MachineStatus.PRODUCING
    assert instructed(rig.report(CycleDone(product="pump-p3", seq=1)), StartCycle)


def test_finished_pieces_that_lie_there_at_the_start_are_used_for_the_first_goals() -> None:
    rig = m7(FULL | {"pump-p3": 30})
    rig.take_goal("G1", production(quantity=24))
    assert outgoing(rig.all) == [("G1", 24)]
    assert not rig.is_cycling
    rig.take_goal("G2", production(quantity=10, order="O2"))
    rig.cycles(4)
    assert not rig.is_cycling
    assert outgoing(rig.all) == [("G1", 24), ("G2", 10)]


# --- contracts -----------------------------------------------------------------------------------


def carrier(rig: MachineRig) -> tuple[str, int]:
    """Who carries M7-1, and in which epoch, as the machine says it."""
    rig.run(rig.now_s)
    [brief] = [each for each in rig.heartbeats(MachineHeartbeat)[-1].tasks if each.task == "M7-1"]
    return brief.primary, brief.epoch


@pytest.mark.parametrize("number", [0, 1, 7])
def test_a_carrier_that_starts_after_its_machine_keeps_its_contract(number: int) -> None:
    again = reborn(supplied_by("ATV2"))
    effects = again.on_message("ATV2", accepted("M7-1", number=number))
    assert sent(effects, Release) == []
    assert carrier(again) == ("ATV2", 1)
    assert len(sent(again.on_message("ATV2", docked()), DockOpened)) == 1


def test_somebody_else_s_acceptance_is_released_by_the_award_that_it_names() -> None:
    again = reborn(supplied_by("ATV2"))
    [release] = sent(again.on_message("ATV3", accepted("M7-1", number=3)), Release, to="ATV3")
    assert release.number == 3
    assert carrier(again) == ("ATV2", 1)


def asking() -> MachineRig:
    """M7 needs housings, and asks for somebody who brings some."""
    return m7(NO_HOUSINGS, goal=24)


def test_an_acceptance_that_is_in_nobody_s_notes_but_the_vehicle_s_counts() -> None:
    again = reborn(asking())
    effects = again.on_message("ATV2", accepted("M7-1"))
    assert sent(effects, Release) == []
    assert carrier(again) == ("ATV2", 1)


def test_however_often_a_machine_starts_before_it_asks_anybody_the_carrier_of_its_task_is_taken_up() -> None:
    again = asking()
    for _ in range(3):
        again = reborn(again)
    again.on_message("ATV2", rhb("ATV2", 1, again.now_s, task="M7-1", coordinator="M7"))
    assert carrier(again) == ("ATV2", 1)


def test_once_others_were_asked_an_earlier_acceptance_is_over() -> None:
    again = reborn(asking())
    again.run(again.now_s + RECOVERY_WAIT_S)
    assert published(again.all, TaskAnnounced)[-1].epoch == 2
    later = reborn(again)
    assert sent(later.on_message("ATV2", accepted("M7-1")), Release, to="ATV2")
    assert carrier(later) == ("", 3)


def test_who_was_told_that_it_has_lost_its_task_is_not_taken_up_by_the_next_life() -> None:
    rig = supplied_by("ATV2")
    gives_back = Resigned(task="M7-1", epoch=1, role=Role.PRIMARY, reason=Reason.PROBLEM)
    assert sent(rig.on_message("ATV2", gives_back), Superseded) == [Superseded(task="M7-1", epoch=2)]
    # With right of way nobody may have been asked since: one vehicle is hired after the other.
    notes = cast(MachineMemory, committed(rig.all)[WHOLE])
    unasked = tuple(msgspec.structs.replace(each, offered=False) for each in notes.tasks)
    again = MachineRig("M7", rig.stock, incarnation=2)
    again.memory, again.now_s = {WHOLE: msgspec.structs.replace(notes, tasks=unasked)}, rig.now_s
    again.start()
    again.on_message("ATV2", rhb("ATV2", 1, again.now_s, task="M7-1", coordinator="M7"))
    assert carrier(again) == ("", 2)


def test_whoever_is_asked_by_the_next_life_is_not_taken_at_its_word_for_the_load() -> None:
    again = reborn(asking(), doubts=True)
    again.run(again.now_s + RECOVERY_WAIT_S)
    finish_s = again.now_s + 120.0
    effects = again.on_message("ATV2", bid(90.0, task="M7-1", epoch=2, finish_s=finish_s, source="S1"))
    effects += again.run(published(again.all, TaskAnnounced)[-1].bids_until_s)
    again.on_message("ATV2", accepted("M7-1", epoch=2, number=award_number(effects, "ATV2", "M7-1")))
    assert carrier(again) == ("ATV2", 2)
    assert sent(again.on_message("ATV2", handover(epoch=2)), HandoverAccepted) == []
    again.stocked("housing", 24, "ATV2")
    assert sent(again.on_message("ATV2", handover(epoch=2)), HandoverAccepted, to="ATV2")


def test_a_machine_that_has_lost_its_notes_waits_for_the_word_of_those_who_ask_it() -> None:
    lost = MachineRig("M7", NO_HOUSINGS, incarnation=2)
    lost.start()
    assert sent(lost.on_message("ATV2", accepted("M7-1")), Release) == []
    assert sent(lost.on_message("ATV2", docked()), Superseded) == []
    lost.run(lost.now_s + RECOVERY_WAIT_S)
    assert sent(lost.on_message("ATV2", docked()), Superseded, to="ATV2")


def test_a_machine_that_has_lost_its_notes_takes_a_carrier_at_its_word_once_and_gives_its_task_no_other_epoch() -> (
    None
):
    lost = MachineRig("M7", NO_HOUSINGS, incarnation=2)
    lost.start()
    claim = TakenOver(task="M7-1", epoch=3, primary="ATV3")
    assert sent(lost.on_message("ATV2", claim), Superseded) == [], "its heartbeat tells more"
    named = rhb("ATV2", 1, lost.now_s, task="M7-1", coordinator="M7")
    carried = msgspec.structs.replace(
        cast(Brief, named.task), epoch=3, phase=Phase.CARRYING, item="housing", quantity=24
    )
    lost.on_message("ATV2", msgspec.structs.replace(named, task=carried))
    assert carrier(lost) == ("ATV2", 3)
    assert sent(lost.on_message("ATV2", claim), Confirmed, to="ATV2") == [Confirmed(task="M7-1", epoch=3)]
    lost.on_message(
        "ATV2", Resigned(task="M7-1", epoch=3, role=Role.PRIMARY, reason=Reason.GRACEFUL_SHUTDOWN)
    )
    assert [fact.outcome for fact in facts(lost.all, TaskClosed)] == ["withdrawn"]
    older = msgspec.structs.replace(named, atv="ATV3", task=msgspec.structs.replace(carried, epoch=2))
    lost.on_message("ATV3", older)
    assert lost.agent._flow.tasks.get("M7-1") is None  # type: ignore[attr-defined]


def test_a_goal_that_was_taken_and_not_confirmed_is_asked_for_in_the_next_life_and_not_begun() -> None:
    rig = m7()
    rig.award_goal("G1", production(quantity=24))
    again = reborn(rig)
    [asked] = sent(again.all, Accepted, to="STRATEGIST")
    assert (asked.task, asked.number) == ("G1", 1)
    assert not again.is_cycling
    again.confirm_goal("G1")
    assert again.is_cycling
