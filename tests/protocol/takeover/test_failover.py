"""When somebody fails: takeover, fencing, help, lost links and restarts (protocol, "When something fails")."""

from __future__ import annotations

import msgspec
import pytest
from kit import PLANT, VehicleRig, award, committed, facts, instructed, rhb, sent, transport
from office import Office, contracted, watched
from seals import granted

from dray.body import Drive, Drop, LinkNoticed, Pick, ProblemCleared, ProblemRaised
from dray.memory import AtvMemory
from dray.messages import (
    Accepted,
    AtvHeartbeat,
    AtvStatus,
    Brief,
    CommandAnswered,
    CommandKind,
    Confirmed,
    Declined,
    Docked,
    DockOpened,
    Handover,
    HelpWanted,
    Link,
    Phase,
    Release,
    Resigned,
    Role,
    Superseded,
    TakenOver,
    TaskAnnounced,
    VehicleCommand,
    Withdrawn,
)
from dray.messages.fact import CarrierChanged, ContractEnded, HelpAsked, HelpPromised, TaskClosed, TookOver
from dray.protocol.contract_net.task_state import TaskState
from dray.protocol.liveness.failure_detector import UNNAMED_S
from dray.protocol.liveness.suspicion import LATENESS_MAX_S, WORKING_INTERVAL_S, bound_s
from dray.protocol.machine.transports import ADOPT_S
from dray.protocol.runtime.events import Commit, Started
from dray.protocol.runtime.retransmission import ASK_AGAIN_S
from dray.protocol.takeover.failover import LOST_IN_TRANSIT_S, TAKEOVER_TIMEOUT_S
from dray.protocol.vehicle.assistance import PATIENCE_MAX_S, PATIENCE_MIN_S
from dray.protocol.vehicle.transport_job import GIVE_UP_AFTER

BOUND_S = bound_s(WORKING_INTERVAL_S)
GOODS = transport(item="pump-p3", quantity=24, sources=("M8",), destination="DELIVERY", goal="G8")


def beat(rig: VehicleRig, seq: int, *, phase: Phase = Phase.APPROACHING, **changes: object) -> None:
    """ATV2, the primary of M8-1, is heard now."""
    brief = Brief(task="M8-1", epoch=1, role=Role.PRIMARY, coordinator="M8", phase=phase)
    heartbeat = msgspec.structs.replace(rhb("ATV2", seq, rig.now_s, task="M8-1"), task=brief)
    rig.on_message("ATV2", msgspec.structs.replace(heartbeat, **changes))


def guard(**changes: object) -> VehicleRig:
    """ATV1, which watches ATV2 carrying M8-1, and has just heard of it."""
    rig = VehicleRig()
    rig.start()
    rig.on_message("M8", award(role=Role.SECONDARY, primary="ATV2", **changes))
    beat(rig, 1)
    return rig


def claims(rig: VehicleRig) -> list[TakenOver]:
    return sent(rig.all, TakenOver, to="M8")


# --- the secondary -------------------------------------------------------------------------------


def test_a_secondary_takes_over_as_soon_as_its_primary_has_been_silent_for_the_bound() -> None:
    rig = guard()
    rig.run(BOUND_S - 0.01)
    assert claims(rig) == []
    rig.run(BOUND_S)
    [claim] = claims(rig)
    assert (claim.task, claim.epoch, claim.primary, claim.source) == ("M8-1", 2, "ATV2", "S3")
    [took] = facts(rig.all, TookOver)
    assert (took.silent_s, took.reason) == (BOUND_S, "silent")
    assert rig.last(Drive).nodes[-1] == PLANT.node_of("S3")
    rig.run(rig.now_s)
    heartbeat = rig.heartbeats(AtvHeartbeat)[-1]
    assert heartbeat.status is AtvStatus.WORKING
    assert heartbeat.task is not None
    assert (heartbeat.task.task, heartbeat.task.epoch) == ("M8-1", 2)


def test_a_heartbeat_that_came_through_the_mesh_is_a_heartbeat() -> None:
    rig = guard()
    for seq in range(2, 40):
        rig.run(float(seq - 1))
        beat(rig, seq, link=Link.MESH, via=("ATV5",))
    assert claims(rig) == []


def test_it_says_so_until_the_machine_has_confirmed() -> None:
    rig = guard()
    rig.run(BOUND_S + 2.5 * ASK_AGAIN_S)
    assert len(claims(rig)) == 3
    rig.on_message("M8", Confirmed(task="M8-1", epoch=2))
    rig.run(rig.now_s + 5 * ASK_AGAIN_S)
    assert len(claims(rig)) == 3


def test_a_confirmation_of_an_earlier_epoch_confirms_nothing() -> None:
    rig = guard()
    rig.run(BOUND_S)
    rig.on_message("M8", Confirmed(task="M8-1", epoch=1))
    rig.on_message("M3", Confirmed(task="M8-1", epoch=2))
    rig.run(BOUND_S + ASK_AGAIN_S)
    assert len(claims(rig)) == 2


def test_its_next_life_says_so_too_until_the_machine_has_confirmed() -> None:
    rig = guard()
    rig.run(BOUND_S)
    again = reborn(rig)
    assert claims(again) == claims(rig)
    again.on_message("M8", Confirmed(task="M8-1", epoch=2))
    again.run(again.now_s + 5 * ASK_AGAIN_S)
    assert len(claims(again)) == 1


def test_a_takeover_that_the_machine_refuses_ends() -> None:
    rig = guard()
    rig.run(BOUND_S)
    rig.on_message("M8", Release(task="M8-1", epoch=2, role=Role.PRIMARY, reason="ATV2 is heard"))
    assert facts(rig.all, ContractEnded)[-1].reason == "released"
    said = len(claims(rig))
    rig.run(rig.now_s + 10 * ASK_AGAIN_S)
    assert len(claims(rig)) == said


def test_what_is_carried_in_its_stead_is_written_down_before_it_is_said() -> None:
    rig = guard()
    effects = rig.run(BOUND_S)
    kinds = [type(effect) for effect in effects if isinstance(effect, Commit) or sent([effect], TakenOver)]
    assert kinds[0] is Commit
    [commit] = [effect for effect in effects if isinstance(effect, Commit)]
    assert isinstance(commit.note, AtvMemory)
    assert commit.note.contract is not None
    assert commit.note.contract.epoch == 2


@pytest.mark.parametrize("phase", [Phase.CARRYING, Phase.UNLOADING, Phase.HANDING_OVER])
def test_goods_that_are_on_board_cannot_be_fetched_by_another_one(phase: Phase) -> None:
    rig = guard(work=GOODS)
    beat(rig, 2, phase=phase)
    rig.run(60.0)
    assert claims(rig) == []


def test_goods_that_are_not_fetched_yet_can() -> None:
    rig = guard(work=GOODS)
    beat(rig, 2, phase=Phase.APPROACHING)
    rig.run(BOUND_S)
    assert len(claims(rig)) == 1


def test_one_that_cannot_carry_it_any_more_resigns_from_its_watch() -> None:
    rig = guard()
    rig.battery_frac = 0.05
    rig.run(60.0)
    assert claims(rig) == []
    [resigned] = sent(rig.all, Resigned, to="M8")
    assert (resigned.role, resigned.epoch) == (Role.SECONDARY, 1)


def test_of_two_tasks_it_takes_one_and_gives_the_other_back() -> None:
    rig = guard()
    rig.on_message("M9", award(task="M9-1", role=Role.SECONDARY, primary="ATV2"))
    rig.run(2 * BOUND_S)
    assert {claim.task for claim in sent(rig.all, TakenOver)} == {"M8-1"}
    assert len(sent(rig.all, Resigned)) == 1


# --- help ----------------------------------------------------------------------------------------


def test_a_primary_in_trouble_is_waited_for_as_long_as_it_says() -> None:
    rig = guard()
    for seq in range(2, 63):
        rig.run(float(seq - 1))
        beat(rig, seq, status=AtvStatus.ERROR, problem="way blocked", help=HelpWanted(until_s=60.0))
    [took] = facts(rig.all, TookOver)
    assert claims(rig)[0].reason.startswith("in error")
    assert took.silent_s < BOUND_S


def carrying() -> VehicleRig:
    """ATV1 as the primary of M8-1, due well before its deadline."""
    rig = VehicleRig()
    rig.start()
    rig.on_message("M8", award(deadline_s=3600.0))
    return rig


def newest(rig: VehicleRig) -> AtvHeartbeat:
    rig.run(rig.now_s)
    return rig.heartbeats(AtvHeartbeat)[-1]


def test_a_vehicle_with_a_problem_says_how_long_its_task_can_wait() -> None:
    rig = carrying()
    rig.report(ProblemRaised(reason="way blocked"))
    heartbeat = newest(rig)
    assert heartbeat.status is AtvStatus.ERROR
    assert heartbeat.help == HelpWanted(until_s=PATIENCE_MAX_S)
    [asked] = facts(rig.all, HelpAsked)
    assert (asked.task, asked.reason) == ("M8-1", "way blocked")
    rig.report(ProblemCleared())
    assert newest(rig).help is None
    assert newest(rig).status is AtvStatus.WORKING


def test_a_vehicle_that_a_person_has_stopped_lets_its_task_wait_and_asks_for_nobody_by_that() -> None:
    rig = carrying()
    rig.on_message("operator", granted("ATV1", VehicleCommand(command="C1", kind=CommandKind.STOP)))
    heartbeat = newest(rig)
    assert (heartbeat.status, heartbeat.help) == (AtvStatus.STOPPED, HelpWanted(until_s=PATIENCE_MAX_S))
    assert facts(rig.all, HelpAsked) == []
    rig.report(ProblemRaised(reason="way blocked"))
    [asked] = facts(rig.all, HelpAsked)
    assert (asked.reason, asked.until_s) == ("way blocked", PATIENCE_MAX_S)


def test_a_task_that_is_late_already_waits_a_little_all_the_same() -> None:
    rig = VehicleRig()
    rig.start()
    # A deadline that it can just keep.
    rig.on_message("M8", award(deadline_s=90.0))
    rig.run(80.0)
    rig.report(ProblemRaised(reason="way blocked"))
    help_wanted = newest(rig).help
    assert help_wanted is not None
    assert PATIENCE_MIN_S <= help_wanted.until_s - rig.now_s < PATIENCE_MAX_S


def test_an_idle_vehicle_with_a_problem_keeps_nobody_waiting() -> None:
    rig = VehicleRig()
    rig.start()
    rig.report(ProblemRaised(reason="way blocked"))
    assert newest(rig).help is None


def promise(rig: VehicleRig, wait_s: float | None) -> CommandAnswered:
    command = VehicleCommand(
        command="C1", kind=CommandKind.PROMISE, wait_s=wait_s, issued_by="operator north"
    )
    [answer] = sent(rig.on_message("operator-north", granted("ATV1", command)), CommandAnswered)
    return answer


def test_a_promise_holds_the_takeover_back() -> None:
    rig = carrying()
    rig.report(ProblemRaised(reason="way blocked"))
    assert promise(rig, 240.0).done
    assert newest(rig).help == HelpWanted(until_s=240.0, promised_by="operator north")
    assert [fact.until_s for fact in facts(rig.all, HelpPromised)] == [240.0]


@pytest.mark.parametrize("wait_s", [None, 0.0, -1.0, 1e9, float("nan")])
def test_a_promise_that_says_no_time_is_refused(wait_s: float | None) -> None:
    rig = carrying()
    rig.report(ProblemRaised(reason="way blocked"))
    answer = promise(rig, wait_s)
    assert not answer.done
    assert answer.reason
    assert newest(rig).help == HelpWanted(until_s=PATIENCE_MAX_S)


def test_a_promise_without_trouble_is_refused() -> None:
    assert not promise(carrying(), 60.0).done


def test_a_stop_lets_the_task_wait_too_and_a_resume_ends_that() -> None:
    rig = carrying()
    for kind, wanted in (
        (CommandKind.STOP, True),
        (CommandKind.ACKNOWLEDGE, True),
        (CommandKind.RESUME, False),
    ):
        rig.on_message("operator", granted("ATV1", VehicleCommand(command=kind.value, kind=kind)))
        assert (newest(rig).help is not None) is wanted


# --- the machine ---------------------------------------------------------------------------------


def takes_over(office: Office, atv: str = "ATV1", epoch: int = 2, primary: str = "ATV2") -> None:
    claim = TakenOver(task="T1", epoch=epoch, primary=primary, finish_s=200.0, source="S3")
    office.desk.on_taken_over(atv, claim, office.now_s)


def failed() -> Office:
    """T1 is watched by ATV1; its primary ATV2 has just become silent for the bound."""
    office = watched()
    office.run(20.0, "ATV1", "ATV2")
    office.run(20.0 + BOUND_S + 0.1, "ATV1")
    return office


def test_the_machine_accepts_a_takeover_and_the_old_carrier_is_superseded() -> None:
    office = failed()
    takes_over(office)
    assert (office.task.primary, office.task.epoch, office.task.contract.promised_s) == ("ATV1", 2, 200.0)
    assert sent(office.out, Confirmed, to="ATV1") == [Confirmed(task="T1", epoch=2)]
    assert sent(office.out, Superseded, to="ATV2") == [Superseded(task="T1", epoch=2)]
    [changed] = facts(office.out, CarrierChanged)
    assert (changed.replaced, changed.carrier, changed.reason) == ("ATV2", "ATV1", "silent")
    assert changed.silent_s >= BOUND_S
    assert office.task.secondary == ""
    assert office.asked(Role.SECONDARY)[-1] == "ATV1", "it is not asked to watch itself"


def test_a_takeover_that_is_said_again_is_confirmed_again() -> None:
    office = failed()
    takes_over(office)
    takes_over(office)
    assert len(sent(office.out, Confirmed, to="ATV1")) == 2
    assert len(facts(office.out, CarrierChanged)) == 1


def test_two_takeovers_of_one_epoch_leave_one_carrier() -> None:
    office = failed()
    takes_over(office, "ATV1")
    takes_over(office, "ATV4")
    assert office.task.primary == "ATV1"
    assert sent(office.out, Superseded, to="ATV4") == [Superseded(task="T1", epoch=2)]


def test_a_takeover_is_refused_while_the_machine_hears_the_primary_itself() -> None:
    office = watched()
    office.run(20.0, "ATV1", "ATV2")
    takes_over(office)
    assert office.task.primary == "ATV2"
    assert office.released()[-1] == ("ATV1", Role.PRIMARY)


def test_a_takeover_of_a_closed_task_is_superseded() -> None:
    office = failed()
    office.desk.close(office.task, "delivered")
    takes_over(office)
    assert sent(office.out, Superseded, to="ATV1") == [Superseded(task="T1", epoch=2)], "it believes in 2"


def test_when_nobody_takes_over_the_task_is_announced_anew() -> None:
    office = failed()
    office.run(office.now_s + TAKEOVER_TIMEOUT_S + 0.2, "ATV1")
    assert (office.task.primary, office.task.epoch) == ("", 2)
    [changed] = facts(office.out, CarrierChanged)
    assert (changed.replaced, changed.carrier) == ("ATV2", "")
    assert office.released()[-1] == ("ATV1", Role.SECONDARY)
    takes_over(office)
    assert office.task.primary == "", "its grace is over, and somebody else may have been asked"
    office.bids(epoch=2, ATV4=50.0)
    office.run(office.now_s + 1.0)
    office.accepts("ATV4", epoch=2)
    assert office.task.primary == "ATV4"


def test_a_secondary_that_has_never_heard_the_primary_is_asked_and_not_waited_for() -> None:
    office = watched()
    office.run(20.0, "ATV1", "ATV2")
    office.run(21.0, "ATV1")
    office.resigns("ATV1")
    office.bids(role=Role.SECONDARY, ATV4=60.0)
    office.run(22.5)
    office.accepts("ATV4", Role.SECONDARY)
    assert (office.task.primary, office.task.secondary) == ("ATV2", "ATV4"), (
        "it watches somebody who is silent already"
    )
    office.run(20.0 + BOUND_S + 0.1, "ATV4")
    assert office.asked(Role.PRIMARY)[-1] == "ATV4"
    assert not any(effect.to == "ATV4" for effect in office.out if sent([effect], Superseded))
    office.accepts("ATV4", epoch=2)
    assert (office.task.primary, office.task.epoch) == ("ATV4", 2)


def test_without_a_secondary_it_is_announced_anew_at_once() -> None:
    office = contracted()
    office.run(20.0, "ATV2")
    office.run(20.0 + BOUND_S + 0.2)
    assert office.task.epoch == 2


def test_a_primary_that_speaks_again_in_time_keeps_its_task() -> None:
    office = failed()
    office.run(60.0, "ATV1", "ATV2")
    assert (office.task.primary, office.task.epoch) == ("ATV2", 1)


def test_a_primary_that_gives_its_task_back_is_replaced() -> None:
    office = watched()
    resigned = Resigned(task="T1", epoch=1, role=Role.PRIMARY, reason="its load was taken off")
    office.desk.on_resigned("ATV2", resigned, office.now_s)
    assert (office.task.primary, office.task.epoch) == ("", 2)


def test_a_primary_that_does_not_name_its_task_has_lost_it() -> None:
    office = watched()
    office.run(20.0, "ATV1", "ATV2")
    for seq in range(1000, 1000 + int(UNNAMED_S) + 2):
        office.now_s += 1.0
        office.desk.on_heartbeat(rhb("ATV2", seq, office.now_s), office.now_s)
    assert office.task.epoch == 2


def test_a_secondary_that_does_not_name_its_watch_is_replaced() -> None:
    office = watched()
    office.run(20.0, "ATV1", "ATV2")
    for seq in range(1000, 1000 + int(UNNAMED_S) + 2):
        office.now_s += 1.0
        office.desk.on_heartbeat(rhb("ATV1", seq, office.now_s), office.now_s)
    assert office.task.secondary == ""


def test_goods_on_board_of_a_silent_vehicle_are_waited_for_and_then_given_up() -> None:
    office = failed()
    office.task.states.enter(TaskState.IN_TRANSIT)
    office.run(office.now_s + TAKEOVER_TIMEOUT_S + 1.0, "ATV1")
    assert (office.task.primary, office.task.epoch) == ("ATV2", 1)
    assert "with the load on board" in office.task.trouble
    takes_over(office)
    assert office.task.primary == "ATV2"
    task = office.task
    office.run(office.now_s + LOST_IN_TRANSIT_S)
    assert office.desk.get("T1") is None
    assert [fact.outcome for fact in facts(office.out, TaskClosed)] == ["withdrawn"]
    assert sent(office.out, Withdrawn, to="ATV2")
    assert task.id == "T1"


def test_a_restored_task_goes_on_with_the_carrier_that_names_it() -> None:
    memory = watched().task.memory()
    office = Office()
    office.desk.restore(memory, 0.0)
    office.run(60.0, "ATV2")
    assert (office.task.primary, office.task.epoch) == ("ATV2", 1)


def test_a_restored_task_whose_carrier_is_gone_is_announced_anew() -> None:
    memory = watched().task.memory()
    office = Office()
    office.desk.restore(memory, 0.0)
    office.run(60.0)
    assert office.task.epoch >= 2


def test_a_restored_task_without_a_carrier_gets_a_higher_epoch() -> None:
    office = Office()
    office.open()
    restored = Office()
    restored.desk.restore(office.task.memory(), 0.0)
    assert restored.task.epoch == 2
    restored.run(ADOPT_S)
    assert [said.epoch for effect in restored.out for said in _announced([effect])] == [2]


def _announced(effects: list[object]) -> list[TaskAnnounced]:
    return [
        effect.message for effect in effects if isinstance(getattr(effect, "message", None), TaskAnnounced)
    ]


# --- the radio mesh ------------------------------------------------------------------------------


def test_a_vehicle_on_the_mesh_keeps_its_task_and_takes_nothing_else() -> None:
    rig = carrying()
    rig.on_message("M9", award(task="M9-1", role=Role.SECONDARY, primary="ATV2"))
    rig.report(LinkNoticed(link=Link.MESH))
    assert newest(rig).link is Link.MESH
    assert newest(rig).task is not None
    declined = sent(rig.on_message("M9", award(task="M9-2", role=Role.SECONDARY, primary="ATV2")), Declined)
    assert len(declined) == 1


def test_a_watch_is_given_back_on_the_mesh_and_taken_again_after_the_repair() -> None:
    rig = guard()
    rig.report(LinkNoticed(link=Link.MESH))
    assert len(sent(rig.all, Resigned, to="M8")) == 1
    rig.report(LinkNoticed(link=Link.WLAN))
    answers = sent(rig.on_message("M8", award(task="M8-7", role=Role.SECONDARY, primary="ATV2")), Accepted)
    assert len(answers) == 1


# --- silent machines -----------------------------------------------------------------------------


def test_a_load_for_a_silent_machine_goes_back_to_a_storage() -> None:
    rig = carrying()
    rig.arrive()
    rig.picked()
    rig.arrive()
    rig.run(rig.now_s + GIVE_UP_AFTER * ASK_AGAIN_S + 1.0)
    assert len(sent(rig.all, Docked, to="M8")) == GIVE_UP_AFTER
    assert len(sent(rig.all, Resigned, to="M8")) == 1
    assert rig.last(Drive).nodes[-1] in {PLANT.node_of(each) for each in PLANT.storages_of("shaft")}
    rig.arrive()
    rig.dropped()
    assert newest(rig).status is AtvStatus.IDLE


def test_a_handover_that_nobody_answers_ends() -> None:
    rig = carrying()
    rig.arrive()
    rig.picked()
    rig.arrive()
    rig.on_message("M8", DockOpened(task="M8-1", epoch=1, station="M8"))
    rig.dropped()
    rig.run(rig.now_s + GIVE_UP_AFTER * ASK_AGAIN_S + 1.0)
    assert len(sent(rig.all, Handover)) == GIVE_UP_AFTER
    assert newest(rig).status is AtvStatus.IDLE


def test_goods_that_the_gate_refuses_are_set_aside() -> None:
    rig = VehicleRig()
    rig.start()
    rig.on_message("M8", award(work=GOODS, deadline_s=3600.0))
    rig.arrive()
    rig.on_message("M8", DockOpened(task="M8-1", epoch=1, station="M8"))
    rig.picked()
    rig.arrive()
    for _ in range(3):
        rig.failed(Drop, "not admitted")
        rig.run(rig.now_s + 6.0)
    assert [drop.goal for drop in instructed(rig.all, Drop)] == ["G8", "G8", "G8", ""]
    assert len(sent(rig.all, Resigned, to="M8")) == 1
    rig.dropped()
    assert newest(rig).status is AtvStatus.IDLE


# --- restarts ------------------------------------------------------------------------------------


def reborn(rig: VehicleRig) -> VehicleRig:
    """The same vehicle after a restart of its software."""
    again = VehicleRig(node=rig.node, battery_frac=rig.battery_frac)
    again.load, again.held, again.now_s = rig.load, rig.held, rig.now_s
    again.handle(Started(again.sense(), committed(rig.all)))
    return again


def test_a_vehicle_that_is_restarted_empty_goes_on_to_its_source() -> None:
    rig = reborn(carrying())
    assert rig.last(Drive).nodes[-1] == PLANT.node_of("S3")
    assert newest(rig).status is AtvStatus.WORKING


def test_a_vehicle_that_is_restarted_with_its_load_carries_it_on() -> None:
    rig = carrying()
    rig.arrive()
    rig.picked()
    again = reborn(rig)
    assert again.last(Drive).nodes[-1] == PLANT.node_of("M8")
    again.arrive()
    assert sent(again.all, Docked, to="M8") == [Docked(task="M8-1", epoch=1, station="M8")]


def test_a_vehicle_that_is_restarted_after_unloading_hands_over() -> None:
    rig = carrying()
    rig.arrive()
    rig.picked()
    rig.arrive()
    rig.on_message("M8", DockOpened(task="M8-1", epoch=1, station="M8"))
    rig.dropped()
    again = reborn(rig)
    assert len(sent(again.all, Handover, to="M8")) == 1


def test_a_vehicle_whose_load_was_taken_off_meanwhile_fetches_another_one() -> None:
    rig = carrying()
    rig.arrive()
    rig.picked()
    rig.load = ("", 0)
    again = reborn(rig)
    assert len(instructed(again.all, Pick)) == 1, "it stands at the storage"


def test_a_stopped_vehicle_is_stopped_after_a_restart() -> None:
    rig = carrying()
    rig.on_message("operator", granted("ATV1", VehicleCommand(command="C1", kind=CommandKind.STOP)))
    rig.on_message("operator", granted("ATV1", VehicleCommand(command="C2", kind=CommandKind.ACKNOWLEDGE)))
    rig.held = True
    again = reborn(rig)
    assert newest(again).status is AtvStatus.STOPPED
    resume = VehicleCommand(command="C3", kind=CommandKind.RESUME)
    [answer] = sent(again.on_message("operator", granted("ATV1", resume)), CommandAnswered)
    assert answer.done, "it was acknowledged before"


def test_a_load_that_nobody_remembers_is_brought_back() -> None:
    rig = VehicleRig()
    rig.load = ("shaft", 40)
    rig.start()
    assert rig.last(Drive).nodes[-1] in {PLANT.node_of(each) for each in PLANT.storages_of("shaft")}
    rig.arrive()
    rig.dropped()
    assert newest(rig).status is AtvStatus.IDLE


def test_the_bound_of_a_vehicle_that_was_never_heard_allows_for_the_slowest_link() -> None:
    rig = VehicleRig()
    rig.start()
    rig.on_message("M8", award(role=Role.SECONDARY, primary="ATV2"))
    rig.run(LATENESS_MAX_S + BOUND_S - 0.1)
    assert claims(rig) == []
    rig.run(LATENESS_MAX_S + BOUND_S)
    assert len(claims(rig)) == 1
