"""Vehicle after vehicle stands at one dock in vain: the place is at fault, no vehicle, and a person is asked to look there."""

from __future__ import annotations

from typing import Any, cast

import pytest
from defaults import PLANT
from effects import award_number, committed, facts, published, sent
from m7 import FULL, NO_HOUSINGS, handover, m7
from msgspec.structs import replace
from rigs import MachineRig
from seals import granted
from spoken import accepted, bid, rhb

from dray.messages import (
    AtvHeartbeat,
    AtvStatus,
    Award,
    Brief,
    CallState,
    CommandAnswered,
    CommandRefusal,
    HelpCall,
    HelpWanted,
    Link,
    MachineCommand,
    MachineCommandKind,
    MachineHeartbeat,
    Phase,
    Reason,
    Resigned,
    Role,
    StockReserved,
    Superseded,
    TaskAnnounced,
    TaskBrief,
    Transport,
)
from dray.messages.fact import CarrierChanged, ContractorRated, TaskClosed
from dray.messages.problem import ProblemKind
from dray.protocol.contract_net.task import OpenTask
from dray.protocol.contract_net.task_state import TaskState
from dray.protocol.runtime.events import Effect

KIND = MachineCommandKind
LOT = 24
AGES_S = 1800.0
"""Long beyond any round of any auction."""


def watching(rig: MachineRig) -> MachineRig:
    """Let it look at its carriers' progress as it does in service; bids are plain numbers all the same."""
    tasks = rig.agent._flow.tasks
    tasks.failover._assessor = tasks._assessor
    return rig


def with_goods() -> tuple[MachineRig, str]:
    """M7 with a lot of pumps to be fetched, as far as its books say; and the name of their transport."""
    rig = watching(m7({item: 4 * pieces for item, pieces in FULL.items()}, goal=LOT))
    rig.cycles(LOT)
    [task] = [each.id for each in rig.agent._flow.tasks if each.is_of_goods]
    return rig, task


def lacking() -> tuple[MachineRig, str]:
    """M7 without housings, which are to be fetched; and the name of their transport."""
    return watching(m7(NO_HOUSINGS, goal=LOT)), "M7-1"


def task_of(rig: MachineRig, task: str) -> OpenTask:
    [opened] = [each for each in rig.agent._flow.tasks if each.id == task]
    return opened


def hire(rig: MachineRig, atv: str, task: str, source: str = "S1") -> None:
    """A vehicle takes a task, in whichever round."""
    opened, effects, until_s = task_of(rig, task), list[Effect](), rig.now_s + 300.0
    sources = cast(Transport, opened.work).sources
    while not sent(effects, Award, to=atv):
        assert rig.now_s < until_s, "it is not asked"
        if not opened.auction.asked:
            offer = bid(50.0, task=task, epoch=opened.epoch, round=opened.round, source=source)
            rig.on_message(atv, offer if source in sources else replace(offer, source=sources[0]))
        effects = rig.run(rig.now_s + 1.0)
    rig.on_message(atv, accepted(task, epoch=opened.epoch, number=award_number(effects, atv, task)))
    assert opened.primary == atv


def beat(rig: MachineRig, atv: str, task: str, phase: Phase, place: str, **changes: Any) -> None:
    """A second later the carrier tells that it stands at a dock."""
    rig.run(rig.now_s + 1.0)
    brief = Brief(task, task_of(rig, task).epoch, Role.PRIMARY, rig.agent.id, phase=phase)
    heartbeat: AtvHeartbeat = replace(
        rhb(atv, int(rig.now_s * 10), rig.now_s, task=task),
        task=brief,
        node=PLANT.node_of(place),
        **changes,
    )
    rig.on_message(atv, heartbeat)
    for station in PLANT.storages:  # The stations live.
        work = cast(Transport, task_of(rig, task).work)
        if station in work.sources:
            rig.on_message(station, StockReserved(task, brief.epoch, work.item, work.quantity))


def stands(rig: MachineRig, atv: str, task: str, phase: Phase, place: str, **changes: Any) -> None:
    """A carrier comes, and stands at a dock until it is not the carrier any more."""
    beat(rig, atv, task, Phase.APPROACHING, place)
    until_s = rig.now_s + 600.0
    while task_of(rig, task).primary == atv:
        assert rig.now_s < until_s, "it is left alone"
        beat(rig, atv, task, phase, place, **changes)


def fails(rig: MachineRig, atv: str, task: str, phase: Phase = Phase.LOADING, place: str = "M7") -> None:
    hire(rig, atv, task)
    stands(rig, atv, task, phase, place)


def surcharges(rig: MachineRig) -> dict[str, float]:
    """Who is charged more than others, as last told."""
    told = {each.contractor: each.surcharge_s for each in facts(rig.all, ContractorRated)}
    return {atv: surcharge_s for atv, surcharge_s in told.items() if surcharge_s}


def told(rig: MachineRig, task: str) -> TaskBrief:
    rig.run(rig.now_s + 6.0)
    [brief] = [each for each in rig.heartbeats(MachineHeartbeat)[-1].tasks if each.task == task]
    return brief


def calls(rig: MachineRig, task: str) -> list[HelpCall]:
    return [each for each in published(rig.all, HelpCall) if each.goods == task]


def rounds(rig: MachineRig, task: str) -> int:
    return len([each for each in published(rig.all, TaskAnnounced) if each.task == task])


def says(
    rig: MachineRig, kind: MachineCommandKind, task: str, *, areas: tuple[str, ...] | None = None
) -> CommandRefusal | None:
    """A person's word; why it was refused."""
    command = MachineCommand(command=f"C{len(rig.all)}", kind=kind, task=task, issued_by="Maria")
    [answer] = sent(rig.on_message("gateway", granted("M7", command, areas=areas)), CommandAnswered)
    return answer.reason


def held() -> tuple[MachineRig, str]:
    """M7, at which two vehicles could not load the pumps that lie there by its books."""
    rig, task = with_goods()
    fails(rig, "ATV2", task)
    fails(rig, "ATV3", task)
    rig.run(rig.now_s + 6.0)
    return rig, task


# --- the place is at fault -------------------------------------------------------------------------


def test_the_second_vehicle_that_loads_in_vain_is_followed_by_a_person_and_by_no_third_one() -> None:
    rig, task = held()
    asked = rounds(rig, task)
    assert sent(rig.all, Superseded, to="ATV3")
    rig.run(rig.now_s + AGES_S)
    assert rounds(rig, task) == asked
    brief = told(rig, task)
    assert (brief.primary, brief.trouble, brief.fails_at) == ("", Reason.DISPUTED, "M7")
    call = calls(rig, task)[-1]
    assert (call.problem.kind, call.problem.needs_person) == (ProblemKind.DOCK, True)
    assert call.reason == f"ATV2 and ATV3 could not load {LOT} pump-p3 for {brief.destination} at M7"
    assert (call.x_m, call.y_m) == PLANT.position_of("M7")


def test_what_is_the_places_fault_counts_against_no_vehicle() -> None:
    rig, task = with_goods()
    fails(rig, "ATV2", task)
    assert list(surcharges(rig)) == ["ATV2"]
    fails(rig, "ATV3", task)
    assert surcharges(rig) == {}
    assert [each.reason for each in facts(rig.all, ContractorRated)] == [Reason.STALLED, Reason.DISPUTED]
    assert [each.replaced for each in facts(rig.all, CarrierChanged)] == ["ATV2", "ATV3"]


def test_a_dock_where_nothing_can_be_put_down_is_found_in_the_same_way() -> None:
    rig, task = lacking()
    fails(rig, "ATV2", task, Phase.UNLOADING)
    fails(rig, "ATV3", task, Phase.UNLOADING)
    assert told(rig, task).fails_at == "M7"
    assert "could not unload" in calls(rig, task)[-1].reason
    assert surcharges(rig) == {}


def test_where_a_storage_is_at_fault_people_are_called_there() -> None:
    rig, task = lacking()
    fails(rig, "ATV2", task, place="S1")
    fails(rig, "ATV3", task, place="S1")
    assert told(rig, task).fails_at == "S1"
    call = calls(rig, task)[-1]
    assert (call.x_m, call.y_m) == PLANT.position_of("S1")
    elsewhere = PLANT.areas_near(*PLANT.position_of("M7"), 0.0)
    assert set(elsewhere).isdisjoint(PLANT.areas_near(*PLANT.position_of("S1"), 0.0))
    assert says(rig, KIND.LOAD_MISSING, task, areas=tuple(elsewhere)) is CommandRefusal.NOT_HERE
    there = PLANT.areas_near(*PLANT.position_of("S1"), 0.0)
    assert says(rig, KIND.LOAD_MISSING, task, areas=tuple(there)) is None


# --- a person's answer -----------------------------------------------------------------------------


def test_after_the_persons_word_the_load_is_carried_and_failures_are_counted_anew() -> None:
    rig, task = held()
    assert says(rig, KIND.LOAD_MISSING, task) is None
    rig.run(rig.now_s + 6.0)
    assert calls(rig, task)[-1].state is CallState.ENDED
    fails(rig, "ATV4", task)
    opened = task_of(rig, task)
    assert (opened.state, opened.fails_at) == (TaskState.UNASSIGNED, "")
    hire(rig, "ATV5", task)
    rig.stocked("pump-p3", -LOT, "ATV5")
    rig.on_message("ATV5", handover(task, opened.epoch, LOT))
    assert [(each.task, each.outcome) for each in facts(rig.all, TaskClosed)] == [(task, "delivered")]


def test_a_dock_that_is_still_at_fault_is_looked_at_again() -> None:
    rig, task = held()
    says(rig, KIND.LOAD_MISSING, task)
    fails(rig, "ATV2", task)
    fails(rig, "ATV3", task)
    assert told(rig, task).fails_at == "M7"
    assert calls(rig, task)[-1].state is not CallState.ENDED


def test_what_people_have_brought_by_hand_is_delivered() -> None:
    rig, task = held()
    assert says(rig, KIND.LOAD_THERE, task) is None
    assert [(each.task, each.outcome) for each in facts(rig.all, TaskClosed)] == [(task, "delivered")]


def test_books_that_are_put_right_end_the_transport_and_the_pumps_are_made_again() -> None:
    rig, task = held()
    rig.stocked("pump-p3", -LOT)
    assert [(each.task, each.outcome) for each in facts(rig.all, TaskClosed)] == [(task, "withdrawn")]
    rig.run(rig.now_s + 6.0)
    assert calls(rig, task)[-1].state is CallState.ENDED
    assert rig.is_cycling


def test_the_next_life_of_the_machine_still_waits_for_the_word() -> None:
    before, task = held()
    rig = watching(MachineRig("M7", dict(before.stock), incarnation=2))
    rig.memory, rig.now_s = committed(before.all), before.now_s
    rig.start()
    rig.run(rig.now_s + AGES_S)
    assert rounds(rig, task) == 0
    assert told(rig, task).fails_at == "M7"
    assert calls(rig, task)[-1].reason.startswith("vehicles could not load")
    assert says(rig, KIND.LOAD_MISSING, task) is None
    rig.run(rig.now_s + 1.0)
    assert rounds(rig, task)


# --- what says nothing of a place ------------------------------------------------------------------


def test_one_vehicle_alone_is_charged_and_a_person_looks_once_nobody_else_takes_the_task() -> None:
    rig, task = with_goods()
    for _ in range(2):
        fails(rig, "ATV2", task)
    assert task_of(rig, task).state is TaskState.UNASSIGNED
    assert calls(rig, task) == []
    fails(rig, "ATV2", task)
    assert told(rig, task).fails_at == "M7"
    assert calls(rig, task)[-1].reason.startswith("ATV2 could not load")
    assert surcharges(rig)["ATV2"] > 400.0
    # It is looked at again, however little the vehicle is believed.
    assert says(rig, KIND.LOAD_MISSING, task) is None
    for _ in range(3):
        assert not task_of(rig, task).is_held
        fails(rig, "ATV2", task)
    assert told(rig, task).fails_at == "M7"


def test_one_vehicle_that_fails_with_one_task_after_another_accuses_no_place() -> None:
    rig, _ = lacking()
    for _ in range(4):
        [task] = [each.id for each in rig.agent._flow.tasks]
        fails(rig, "ATV2", task, place="S1")
        rig.agent._flow.withdraw(task_of(rig, task), rig.now_s)
        rig.run(rig.now_s + 5.0)
    assert [each for each in rig.agent._flow.tasks if each.is_held] == []


def test_a_vehicle_that_others_have_learned_to_doubt_accuses_no_place() -> None:
    rig, task = with_goods()
    rig.agent._flow.tasks.reliability.note_dropped("ATV2", "M7-0", Reason.NOT_COUNTED, rig.now_s)
    fails(rig, "ATV2", task)
    fails(rig, "ATV3", task)
    assert task_of(rig, task).state is TaskState.UNASSIGNED
    assert set(surcharges(rig)) == {"ATV2", "ATV3"}


def test_a_load_that_has_moved_there_in_between_clears_the_place() -> None:
    rig, task = lacking()
    fails(rig, "ATV2", task, place="S1")
    hire(rig, "ATV3", task)
    beat(rig, "ATV3", task, Phase.LOADING, "S1")
    stands(rig, "ATV3", task, Phase.CARRYING, "S1")
    fails(rig, "ATV4", task, place="S1")
    assert task_of(rig, task).state is TaskState.UNASSIGNED
    assert "ATV4" in surcharges(rig)


def test_another_load_at_the_same_dock_is_another_matter() -> None:
    rig = watching(m7(NO_HOUSINGS | {"impeller": 0}, goal=LOT))
    fails(rig, "ATV2", "M7-1", Phase.UNLOADING)
    fails(rig, "ATV3", "M7-2", Phase.UNLOADING)
    assert [each.id for each in rig.agent._flow.tasks if each.is_held] == []


def both_fail(rig: MachineRig, task: str, place: str, phase: Phase = Phase.LOADING) -> None:
    for atv in ("ATV2", "ATV3"):
        fails(rig, atv, task, phase, place)


def test_two_insiders_have_one_place_looked_at_and_pay_at_every_further_one() -> None:
    rig = watching(m7(NO_HOUSINGS | {"impeller": 0}, goal=LOT))
    both_fail(rig, "M7-1", "S1")
    assert told(rig, "M7-1").fails_at == "S1"
    assert surcharges(rig) == {}
    both_fail(rig, "M7-2", "M7", Phase.UNLOADING)
    both_fail(rig, "M7-2", "M7", Phase.UNLOADING)
    assert [each.id for each in rig.agent._flow.tasks if each.is_held] == ["M7-1"]
    reliability = rig.agent._flow.tasks.reliability
    assert all(reliability.is_restricted(atv, rig.now_s) for atv in ("ATV2", "ATV3"))


def test_once_a_person_has_looked_the_same_two_may_find_another_place_that_fails() -> None:
    rig = watching(m7(NO_HOUSINGS | {"impeller": 0}, goal=LOT))
    both_fail(rig, "M7-1", "S1")
    assert says(rig, KIND.LOAD_MISSING, "M7-1") is None
    both_fail(rig, "M7-2", "M7", Phase.UNLOADING)
    assert told(rig, "M7-2").fails_at == "M7"


HELD_UP: dict[str, dict[str, Any]] = {
    "it is in error": {"problem": "fork blocked", "status": AtvStatus.ERROR},
    "it asks for help": {"help": HelpWanted(until_s=0.0)},
    "a person has stopped it": {"status": AtvStatus.STOPPED},
    "it is cut off": {"link": Link.MESH},
}


@pytest.mark.parametrize("why", HELD_UP)
def test_vehicles_that_are_held_up_by_something_of_their_own_accuse_no_place(why: str) -> None:
    rig, task = with_goods()
    for atv in ("ATV2", "ATV3", "ATV4"):
        hire(rig, atv, task)
        stands(rig, atv, task, Phase.LOADING, "M7", **HELD_UP[why])
    assert task_of(rig, task).state is TaskState.UNASSIGNED
    assert len(surcharges(rig)) == 3


def test_vehicles_that_an_obstacle_keeps_on_the_road_accuse_no_place() -> None:
    rig, task = with_goods()
    for atv in ("ATV2", "ATV3", "ATV4"):
        fails(rig, atv, task, Phase.APPROACHING, "S1")
    for atv in ("ATV5", "ATV6"):
        fails(rig, atv, task, Phase.LOADING, "S1")
    assert task_of(rig, task).state is TaskState.UNASSIGNED


def test_vehicles_that_fall_silent_at_a_dock_accuse_no_place() -> None:
    rig, task = with_goods()
    for atv in ("ATV2", "ATV3", "ATV4"):
        hire(rig, atv, task)
        beat(rig, atv, task, Phase.LOADING, "M7")
        rig.run(rig.now_s + 60.0)
        assert task_of(rig, task).primary == ""
    assert not task_of(rig, task).is_held


# --- a storage that holds its dock -----------------------------------------------------------------


def gives_back(rig: MachineRig, atv: str) -> None:
    """A vehicle waited in vain for what S1 has promised; its task is withdrawn, and the housings are ordered anew."""
    [task] = [each.id for each in rig.agent._flow.tasks]
    hire(rig, atv, task)
    epoch = task_of(rig, task).epoch
    rig.on_message(atv, Resigned(task, epoch, Role.PRIMARY, Reason.DOCK_HELD, short="S1"))
    rig.run(rig.now_s + 5.0)


def test_two_vehicles_that_a_storage_keeps_waiting_are_not_charged_and_nobody_is_called() -> None:
    rig, _ = lacking()
    gives_back(rig, "ATV2")
    assert list(surcharges(rig)) == ["ATV2"]
    gives_back(rig, "ATV3")
    assert surcharges(rig) == {}
    assert [each for each in rig.agent._flow.tasks if each.is_held] == []


def test_a_vehicle_that_gives_back_alone_what_a_storage_has_promised_is_charged() -> None:
    rig, _ = lacking()
    for _ in range(3):
        gives_back(rig, "ATV2")
    assert surcharges(rig)["ATV2"] > 80.0


def test_a_storage_that_keeps_one_vehicle_waiting_is_not_accused_when_another_one_stalls_there() -> None:
    rig, _ = lacking()
    gives_back(rig, "ATV2")
    [task] = [each.id for each in rig.agent._flow.tasks]
    fails(rig, "ATV3", task, place="S1")
    assert task_of(rig, task).state is TaskState.UNASSIGNED
    assert set(surcharges(rig)) == {"ATV2", "ATV3"}
