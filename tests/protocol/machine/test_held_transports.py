"""A transport whose handover was disputed twice is given to nobody before a person has looked; that word decides."""

from __future__ import annotations

import pytest
from effects import award_number, committed, facts, published, sent
from m7 import FULL, NO_HOUSINGS, handover, m7
from msgspec.structs import replace
from rigs import MachineRig
from seals import granted
from spoken import accepted, bid, rhb

from dray.messages import (
    Award,
    CallState,
    CommandAnswered,
    CommandRefusal,
    Confirmed,
    Handover,
    HandoverAccepted,
    HelpCall,
    MachineCommand,
    MachineCommandKind,
    MachineHeartbeat,
    Phase,
    Reason,
    StockAsked,
    Superseded,
    TaskAnnounced,
    TaskBrief,
)
from dray.messages.fact import CarrierChanged, HandoverDisputed, TaskClosed
from dray.protocol.contract_net.task_state import TaskState
from dray.protocol.runtime.events import Effect
from dray.protocol.transports.receiving import COUNT_S

KIND = MachineCommandKind
LOT = 24
TASK = "M7-1"
AGES_S = 1800.0
"""Long beyond any round of any auction."""


def doubting(rig: MachineRig) -> MachineRig:
    """Let it look at handovers as it does in service; prices are plain numbers all the same."""
    machine = rig.agent
    machine._message_handlers = {
        **machine._message_handlers,
        Handover: machine._flow.message_handlers[Handover],
    }
    return rig


def hire(rig: MachineRig, atv: str, epoch: int, task: str = TASK) -> None:
    """A vehicle takes a task."""
    rig.on_message(atv, bid(50.0, task=task, epoch=epoch))
    effects: list[Effect] = []
    until_s = rig.now_s + 120.0
    while not sent(effects, Award, to=atv) and rig.now_s < until_s:
        effects = rig.run(rig.now_s + 0.1)
    rig.on_message(atv, accepted(task, epoch=epoch, number=award_number(effects, atv, task)))


def boasts(rig: MachineRig, atv: str, epoch: int, task: str = TASK, *, confirmed: bool = False) -> None:
    """A carrier says that its load is down, and nobody counts it."""
    pieces = work_of(rig, task).quantity
    rig.on_message(atv, handover(task, epoch, pieces))
    until_s, seq = rig.now_s + COUNT_S + 1.0, int(rig.now_s * 100)
    while rig.now_s < until_s:
        rig.run(rig.now_s + 1.0)
        seq += 1
        beat = rhb(atv, seq, rig.now_s, task=task, coordinator="M7")
        assert beat.task is not None
        brief = replace(beat.task, phase=Phase.HANDING_OVER, epoch=epoch)
        rig.on_message(atv, replace(beat, task=brief))
    if confirmed:
        rig.on_message("STRATEGIST", Confirmed("G1", 1, 0, ()))
    rig.on_message(atv, handover(task, epoch, pieces))


def work_of(rig: MachineRig, task: str = TASK):  # type: ignore[no-untyped-def]
    [opened] = [each for each in rig.agent._flow.tasks if each.id == task]
    return opened.work


def held() -> MachineRig:
    """M7 waits for housings that two vehicles have said to have brought."""
    rig = doubting(m7(NO_HOUSINGS, goal=LOT))
    rig.hire(TASK, "ATV2")
    boasts(rig, "ATV2", 1)
    hire(rig, "ATV3", 2)
    boasts(rig, "ATV3", 2)
    return rig


def told(rig: MachineRig) -> TaskBrief:
    rig.run(rig.now_s + 6.0)
    [brief] = [each for each in rig.heartbeats(MachineHeartbeat)[-1].tasks if each.task == TASK]
    return brief


def rounds(rig: MachineRig, task: str = TASK) -> int:
    return len([each for each in published(rig.all, TaskAnnounced) if each.task == task])


def calls(rig: MachineRig) -> list[HelpCall]:
    return [each for each in published(rig.all, HelpCall) if each.goods == TASK]


def says(
    rig: MachineRig, kind: MachineCommandKind, *, task: str = TASK, areas: tuple[str, ...] | None = None
) -> CommandRefusal | None:
    """A person's word; why it was refused."""
    command = MachineCommand(command=f"C{len(rig.all)}", kind=kind, task=task, issued_by="Maria")
    [answer] = sent(rig.on_message("gateway", granted("M7", command, areas=areas)), CommandAnswered)
    return answer.reason


def restarted(rig: MachineRig) -> MachineRig:
    """Its next life, with what it has written down."""
    after = doubting(MachineRig("M7", NO_HOUSINGS, incarnation=2))
    after.memory, after.now_s = committed(rig.all), rig.now_s
    after.start()
    return after


def test_a_task_that_is_disputed_twice_is_announced_to_nobody_however_long_it_waits() -> None:
    rig = held()
    assert len(facts(rig.all, HandoverDisputed)) == 2
    asked = rounds(rig)
    assert sent(rig.all, Superseded, to="ATV3")[-1].epoch == 3
    assert [each.reason for each in facts(rig.all, CarrierChanged)][-1] is Reason.DISPUTED
    rig.run(rig.now_s + AGES_S)
    rig.on_message("ATV4", bid(5.0, task=TASK, epoch=3))
    rig.on_message("ATV4", accepted(TASK, epoch=3, number=1))
    rig.run(rig.now_s + AGES_S)
    assert rounds(rig) == asked
    brief = told(rig)
    assert (brief.primary, brief.trouble, brief.epoch) == ("", Reason.DISPUTED, 3)
    assert facts(rig.all, TaskClosed) == []


def test_nothing_is_set_aside_and_nothing_else_is_fetched_while_it_waits() -> None:
    rig = held()
    before = len(rig.all)
    rig.run(rig.now_s + AGES_S)
    assert [each for each in sent(rig.all[before:], StockAsked) if each.item == "housing"] == []
    assert [each.work_item for each in rig.agent._flow.tasks].count("housing") == 1


def test_a_person_is_called_to_look_where_the_load_was_to_go() -> None:
    rig = held()
    rig.run(rig.now_s + 6.0)
    call = calls(rig)[-1]
    assert call.problem.needs_person
    assert call.reason == f"{work_of(rig).quantity} housing for M7 said to be there twice, and not counted"
    says(rig, KIND.LOAD_MISSING)
    rig.run(rig.now_s + 6.0)
    assert calls(rig)[-1].state is CallState.ENDED


def test_a_load_that_a_person_has_seen_there_is_delivered() -> None:
    rig = held()
    assert says(rig, KIND.LOAD_THERE) is None
    assert [(each.task, each.outcome) for each in facts(rig.all, TaskClosed)] == [(TASK, "delivered")]
    assert says(rig, KIND.LOAD_THERE) is CommandRefusal.NOT_HELD


def doubted(rig: MachineRig) -> set[str]:
    """Who is charged more than others."""
    return {atv for atv in ("ATV2", "ATV3") if rig.agent._flow.tasks.reliability.surcharge_s(atv, rig.now_s)}


def test_who_has_brought_a_load_that_only_a_person_has_seen_is_not_doubted_any_more() -> None:
    rig = held()
    assert doubted(rig) == {"ATV2", "ATV3"}
    says(rig, KIND.LOAD_THERE)
    assert doubted(rig) == set()


def test_who_has_told_of_a_load_that_a_person_does_not_find_is_still_doubted() -> None:
    rig = held()
    says(rig, KIND.LOAD_MISSING)
    assert doubted(rig) == {"ATV2", "ATV3"}


def test_a_load_that_is_missing_is_fetched_again_and_disputes_are_counted_anew() -> None:
    rig = held()
    assert says(rig, KIND.LOAD_MISSING) is None
    hire(rig, "ATV4", 3)
    boasts(rig, "ATV4", 3)
    [task] = [each for each in rig.agent._flow.tasks if each.id == TASK]
    assert (task.state, task.epoch) == (TaskState.UNASSIGNED, 4)
    hire(rig, "ATV5", 4)
    boasts(rig, "ATV5", 4)
    assert task.state is TaskState.HELD


def test_a_machine_that_was_started_again_still_waits_for_the_word() -> None:
    rig = restarted(held())
    rig.run(rig.now_s + AGES_S)
    assert rounds(rig) == 0
    assert told(rig).trouble is Reason.DISPUTED
    assert calls(rig)
    assert says(rig, KIND.LOAD_MISSING) is None
    rig.run(rig.now_s + 1.0)
    assert {each.epoch for each in published(rig.all, TaskAnnounced) if each.task == TASK} == {3}


def test_the_first_dispute_is_remembered_over_a_restart() -> None:
    rig = doubting(m7(NO_HOUSINGS, goal=LOT))
    rig.hire(TASK, "ATV2")
    boasts(rig, "ATV2", 1)
    after = restarted(rig)
    after.run(after.now_s + 20.0)
    [task] = [each for each in after.agent._flow.tasks if each.id == TASK]
    assert task.disputes == 1


@pytest.mark.parametrize("kind", [KIND.LOAD_THERE, KIND.LOAD_MISSING])
def test_nobody_is_believed_about_what_is_not_held_or_elsewhere(kind: MachineCommandKind) -> None:
    rig = held()
    assert says(rig, kind, task="M7-99") is CommandRefusal.NOT_HELD
    assert says(rig, kind, areas=("no such area",)) is CommandRefusal.NOT_HERE
    assert told(rig).trouble is Reason.DISPUTED


# --- finished goods --------------------------------------------------------------------------------


def goods_held() -> tuple[MachineRig, str]:
    """Two lots of pumps have left M7 one after the other, and the gate has seen neither; the machine, and the second one's name."""
    rig = doubting(m7({item: 4 * pieces for item, pieces in FULL.items()}, goal=LOT))
    task = ""
    for atv in ("ATV2", "ATV3"):
        rig.cycles(LOT)
        [task] = [each.id for each in rig.agent._flow.tasks if each.work.goal == "G1"]
        hire(rig, atv, 1, task)
        rig.stocked("pump-p3", -LOT, atv)
        boasts(rig, atv, 1, task, confirmed=True)
    return rig, task


def test_goods_that_the_gate_has_missed_twice_are_not_made_a_third_time() -> None:
    rig, task = goods_held()
    rig.run(rig.now_s + AGES_S)
    goal = rig.agent._goals.get("G1")
    assert (goal.to_make, goal.stranded, rig.is_cycling) == (0, LOT, False)
    assert [each.id for each in rig.agent._flow.tasks if each.is_held] == [task]
    assert says(rig, KIND.LOAD_MISSING, task=task) is None
    assert (goal.to_make, goal.stranded) == (LOT, 0)
    assert rig.is_cycling


def test_goods_that_were_counted_after_all_begin_the_count_anew() -> None:
    rig = doubting(m7({item: 4 * pieces for item, pieces in FULL.items()}, goal=2 * LOT))
    rig.cycles(LOT)
    [task] = [each.id for each in rig.agent._flow.tasks if each.work.goal == "G1"]
    hire(rig, "ATV2", 1, task)
    rig.stocked("pump-p3", -LOT, "ATV2")
    boasts(rig, "ATV2", 1, task, confirmed=True)
    goal = rig.agent._goals.get("G1")
    assert goal.disputes == 1
    rig.cycles(LOT)
    [task] = [each.id for each in rig.agent._flow.tasks if each.work.goal == "G1"]
    hire(rig, "ATV3", 1, task)
    rig.stocked("pump-p3", -LOT, "ATV3")
    rig.on_message("ATV3", handover(task, 1, LOT))
    rig.on_message("STRATEGIST", Confirmed("G1", 1, LOT, ()))
    assert (goal.disputes, goal.delivered) == (0, LOT)


def test_where_people_count_at_the_gate_a_carrier_goes_on_by_its_word_and_nothing_is_made_again() -> None:
    rig = doubting(m7({item: 4 * pieces for item, pieces in FULL.items()}, goal=LOT))
    rig.on_message("STRATEGIST", Confirmed("G1", 1, by_people=True))
    rig.cycles(LOT)
    [task] = [each.id for each in rig.agent._flow.tasks if each.work.goal == "G1"]
    hire(rig, "ATV2", 1, task)
    rig.stocked("pump-p3", -LOT, "ATV2")
    effects = rig.on_message("ATV2", handover(task, 1, LOT))
    assert sent(effects, HandoverAccepted, to="ATV2")
    goal = rig.agent._goals.get("G1")
    rig.run(rig.now_s + AGES_S)
    rig.on_message("STRATEGIST", Confirmed("G1", 1, arrived=1, by_people=True))
    assert (goal.delivered, goal.to_make, goal.disputes) == (LOT, 0, 0)
    # A later life of the strategist has not heard of it yet.
    rig.on_message("STRATEGIST", Confirmed("G1", 1, arrived=1))
    assert (goal.delivered, goal.to_make) == (LOT, 0)
    assert goal.memory().by_people
