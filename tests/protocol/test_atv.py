"""An autonomous transport vehicle: bids, carries, watches, charges itself (paper, 3.2)."""

from __future__ import annotations

import msgspec
import pytest
from kit import (
    KEYS,
    PLANT,
    VehicleRig,
    accepted,
    announcement,
    award,
    bid,
    deeds,
    facts,
    instructed,
    listening,
    mhb,
    production,
    published,
    rhb,
    sent,
    transport,
)
from seals import granted

from dray.body import (
    Charge,
    Drive,
    Drop,
    Hold,
    LimitSpeed,
    NodePassed,
    Pick,
    ProblemCleared,
    ProblemRaised,
    Unhold,
    WayDone,
)
from dray.errors import ProtocolViolation
from dray.messages import (
    Accepted,
    AtvHeartbeat,
    AtvStatus,
    BerthClaimed,
    Bid,
    CommandAnswered,
    CommandKind,
    Declined,
    Docked,
    DockHeld,
    DockOpened,
    GoalClosed,
    Handover,
    HandoverAccepted,
    Message,
    OrderReleased,
    Phase,
    Refusal,
    Release,
    Resigned,
    Role,
    Superseded,
    VehicleCommand,
    Withdrawn,
)
from dray.messages.fact import (
    AtvStatusChanged,
    BidRefused,
    CommandObeyed,
    ContractEnded,
    ContractTaken,
    PrimarySuspected,
)
from dray.protocol.berths import CONTEST_S
from dray.protocol.bidding import MAX_WATCHES
from dray.protocol.events import Effect
from dray.protocol.resting import CHARGED_FRAC, SETTLE_S
from dray.protocol.suspicion import WORKING_INTERVAL_S, bound_s

SETTLED_S = 7.0
"""By then ATV1 has looked for a place after it was switched on, and CONTEST_S have not passed yet."""


def parked(**options: object) -> VehicleRig:
    """ATV1 at parking place P3, started."""
    rig = VehicleRig(**options)  # type: ignore[arg-type]
    rig.start()
    return rig


def contracted(**options: object) -> VehicleRig:
    """ATV1 as the primary of M8-1, on its way to S3."""
    rig = parked(**options)
    rig.hear("M8", award())
    return rig


def unloading() -> VehicleRig:
    """ATV1 with its load, asking M8 for its dock."""
    rig = contracted()
    rig.arrive()
    rig.picked()
    rig.arrive()
    return rig


def handing_over() -> VehicleRig:
    rig = unloading()
    rig.hear("M8", DockOpened(task="M8-1", epoch=1, station="M8"))
    rig.dropped()
    return rig


def secondary(rig: VehicleRig, task: str = "M8-2", primary: str = "ATV2") -> list[Effect]:
    """ATV1 is asked to watch a task of M8."""
    return rig.hear("M8", award(task=task, role=Role.SECONDARY, primary=primary))


def command(
    rig: VehicleRig, kind: CommandKind, speed_frac: float | None = None, *, name: str = ""
) -> CommandAnswered:
    """Give a command; a new one unless it is given the name of one before."""
    name = name or f"C{len(facts(rig.all, CommandObeyed)) + 1}"
    message = VehicleCommand(command=name, kind=kind, speed_frac=speed_frac, issued_by="shift lead")
    [answer] = sent(rig.hear("gateway", granted("ATV1", message)), CommandAnswered, to="gateway")
    return answer


def last_beat(rig: VehicleRig) -> AtvHeartbeat:
    """The heartbeat that is due now, if one is; else the newest."""
    rig.run(rig.now_s)
    return rig.heartbeats(AtvHeartbeat)[-1]


# --- listening and bidding -----------------------------------------------------------------------


def test_a_vehicle_listens_to_the_announcements_for_its_own_cell() -> None:
    rig = parked(node="p3")
    cell = PLANT.cell_of(PLANT.nodes["p3"].x_m, PLANT.nodes["p3"].y_m)
    assert KEYS.transports(cell) in listening(rig.all)


def test_a_vehicle_takes_its_ears_along() -> None:
    rig = contracted(node="p8")
    before = {key for key in listening(rig.all) if "/task/" in key}
    rig.arrive()
    after = {key for key in listening(rig.all) if "/task/" in key}
    assert len(before) == len(after) == 1
    assert before != after


def test_an_idle_vehicle_bids() -> None:
    rig = parked()
    assert sent(rig.hear("M8", announcement()), Bid, to="M8")


def test_a_vehicle_that_charges_bids_as_far_as_its_battery_keeps_the_promise() -> None:
    rig = parked(node="ch2", battery_frac=0.5)
    rig.run(SETTLED_S)
    assert last_beat(rig).status is AtvStatus.CHARGING
    assert sent(rig.hear("M8", announcement()), Bid)
    rig.battery_frac = 0.1
    rig.run(rig.now_s + 6.0)
    [refused] = facts(rig.hear("M8", announcement()), BidRefused)
    assert refused.reason is Refusal.BATTERY


def test_a_working_vehicle_refuses_because_it_is_busy() -> None:
    rig = contracted()
    [refused] = facts(rig.hear("M7", announcement(task="M7-1")), BidRefused)
    assert (refused.reason, refused.detail) == (Refusal.BUSY, "M8-1")


def test_a_bid_reserves_nothing() -> None:
    rig = parked()
    for task in ("M8-1", "M8-2", "M8-3"):
        assert sent(rig.hear("M8", announcement(task=task)), Bid)
    assert last_beat(rig).status is AtvStatus.IDLE


# --- the contract --------------------------------------------------------------------------------


def test_an_award_is_accepted_and_the_vehicle_sets_off() -> None:
    rig = parked()
    effects = rig.hear("M8", award())
    [answer] = sent(effects, Accepted, to="M8")
    assert (answer.task, answer.epoch, answer.role) == ("M8-1", 1, Role.PRIMARY)
    assert answer.finish_s > 0.0
    [drive] = instructed(effects, Drive)
    assert drive.nodes[-1] == "s3"
    assert len(facts(effects, ContractTaken)) == 1
    beat = last_beat(rig)
    assert beat.status is AtvStatus.WORKING
    assert beat.task is not None
    assert (beat.task.task, beat.task.phase, beat.task.role) == (
        "M8-1",
        Phase.APPROACHING,
        Role.PRIMARY,
    )


def test_the_source_that_was_bid_is_the_one_that_is_driven_to() -> None:
    work = transport(sources=("S3", "S8"))
    effects = parked().hear("M8", award(work=work, source="S8"))
    assert instructed(effects, Drive)[-1].nodes[-1] == "s8"


def test_a_vehicle_is_primary_of_one_task_and_declines_the_second() -> None:
    rig = contracted()
    [declined] = sent(rig.hear("M7", award(task="M7-1")), Declined, to="M7")
    assert declined.reason is Refusal.BUSY
    beat = last_beat(rig)
    assert beat.task is not None
    assert beat.task.task == "M8-1"


def test_an_award_that_comes_twice_is_accepted_twice_and_driven_once() -> None:
    rig = contracted()
    effects = rig.hear("M8", award())
    first, second = sent(rig.all, Accepted)
    assert first == second
    assert instructed(effects, Drive) == []
    assert facts(effects, ContractTaken) == []


def test_a_whole_transport_ends_with_a_free_vehicle() -> None:
    rig = handing_over()
    assert [handover.task for handover in sent(rig.all, Handover, to="M8")] == ["M8-1"]
    effects = rig.hear("M8", HandoverAccepted(task="M8-1", epoch=1))
    [ended] = facts(effects, ContractEnded)
    assert ended.reason == "handed_over"
    beat = last_beat(rig)
    assert (beat.status, beat.task, beat.load) == (AtvStatus.IDLE, None, "")
    assert sent(rig.hear("M7", announcement(task="M7-1")), Bid)


def test_the_heartbeat_tells_of_the_load() -> None:
    rig = contracted()
    rig.arrive()
    rig.picked()
    beat = last_beat(rig)
    assert (beat.load, beat.load_quantity) == ("shaft", 40)
    assert beat.way[-1] == "m8"


def test_every_answer_may_come_twice() -> None:
    rig = unloading()
    opened = DockOpened(task="M8-1", epoch=1, station="M8")
    rig.hear("M8", opened)
    rig.hear("M8", opened)
    assert len(instructed(rig.all, Drop)) == 1
    rig.dropped()
    rig.hear("M8", HandoverAccepted(task="M8-1", epoch=1))
    said = len(deeds(rig.all))
    for message in (
        opened,
        HandoverAccepted(task="M8-1", epoch=1),
        Superseded(task="M8-1", epoch=2),
        Release(task="M8-1", epoch=1, role=Role.PRIMARY, reason="no answer"),
        Withdrawn(task="M8-1", epoch=1, reason="not needed any more"),
    ):
        rig.hear("M8", message)
    assert len(deeds(rig.all)) == said


def test_answers_of_another_epoch_or_task_do_not_count() -> None:
    rig = unloading()
    for message in (
        DockOpened(task="M8-1", epoch=2, station="M8"),
        DockOpened(task="M8-9", epoch=1, station="M8"),
        HandoverAccepted(task="M8-1", epoch=2),
        Withdrawn(task="M8-1", epoch=2, reason="not needed any more"),
        Withdrawn(task="M8-9", epoch=1, reason="not needed any more"),
        Superseded(task="M8-9", epoch=2),
    ):
        rig.hear("M8", message)
    assert instructed(rig.all, Drop) == []
    assert facts(rig.all, ContractEnded) == []


def test_a_question_is_repeated_until_the_machine_answers() -> None:
    rig = unloading()
    rig.run(rig.now_s + 10.0)
    assert len(sent(rig.all, Docked)) == 4
    rig.hear("M8", DockHeld(task="M8-1", epoch=1, station="M8", reason="the buffer is full"))
    assert sent(rig.run(rig.now_s + 4.9), Docked) == []
    assert len(sent(rig.run(rig.now_s + 0.2), Docked)) == 1


def test_a_released_vehicle_without_a_load_is_free_at_once() -> None:
    rig = contracted()
    release = Release(task="M8-1", epoch=1, role=Role.PRIMARY, reason="no answer")
    [ended] = facts(rig.hear("M8", release), ContractEnded)
    assert ended.reason == "released"
    assert deeds(rig.hear("M8", release)) == []
    assert last_beat(rig).status is AtvStatus.IDLE
    assert sent(rig.hear("M7", announcement(task="M7-1")), Bid)


def test_a_release_of_another_epoch_is_ignored() -> None:
    rig = contracted()
    release = Release(task="M8-1", epoch=2, role=Role.PRIMARY, reason="no")
    assert deeds(rig.hear("M8", release)) == []


@pytest.mark.parametrize(
    "message",
    [
        Release(task="M8-1", epoch=1, role=Role.PRIMARY, reason="no answer"),
        Withdrawn(task="M8-1", epoch=1, reason="not needed any more"),
        Superseded(task="M8-1", epoch=2),
        DockOpened(task="M8-1", epoch=1, station="M8"),
    ],
    ids=lambda message: type(message).__name__,
)
def test_a_contract_is_changed_by_its_coordinator_alone(message: Message) -> None:
    rig = unloading()
    effects = rig.hear("M3", message)
    assert deeds(effects) == []
    assert len(effects) == 1
    assert last_beat(rig).status is AtvStatus.WORKING


@pytest.mark.parametrize("change", [{"sources": ("nowhere",)}, {"destination": "nowhere"}])
def test_a_transport_from_or_to_an_unknown_place_is_refused_and_declined(change: dict[str, object]) -> None:
    rig, work = parked(), transport(**change)
    [refused] = facts(rig.hear("M8", announcement(work=work)), BidRefused)
    assert refused.reason is Refusal.NO_WAY
    [declined] = sent(rig.hear("M8", award(work=work)), Declined, to="M8")
    assert declined.reason is Refusal.NO_WAY


def test_an_answer_carries_the_number_of_its_award() -> None:
    rig = parked()
    [taken] = sent(rig.hear("M8", award(number=3)), Accepted)
    [again] = sent(rig.hear("M8", award(number=4)), Accepted)
    [declined] = sent(rig.hear("M7", award(task="M7-1", number=5)), Declined)
    assert (taken.number, again.number, declined.number) == (3, 4, 5)


@pytest.mark.parametrize(
    "message",
    [
        Superseded(task="M8-1", epoch=2),
        Withdrawn(task="M8-1", epoch=1, reason="not needed any more"),
        Release(task="M8-1", epoch=1, role=Role.PRIMARY, reason="withdrawn"),
    ],
    ids=lambda message: type(message).__name__,
)
def test_a_carrier_without_a_contract_brings_its_load_to_a_storage_before_it_is_free(
    message: Superseded | Withdrawn | Release,
) -> None:
    rig = unloading()
    rig.hear("M8", message)
    assert facts(rig.all, ContractEnded) == []
    assert [declined.reason for declined in sent(rig.hear("M7", award(task="M7-1")), Declined)] == [
        Refusal.BUSY
    ]
    beat = last_beat(rig)
    assert beat.task is not None
    assert beat.task.phase is Phase.RETURNING
    rig.arrive()
    assert rig.last(Drop).station in PLANT.storages_of("shaft")
    rig.dropped()
    assert len(facts(rig.all, ContractEnded)) == 1
    assert last_beat(rig).status is AtvStatus.IDLE


def test_a_failed_pick_is_tried_again_and_a_failed_way_too() -> None:
    rig = contracted()
    rig.failed(Drive, "the lane is closed")
    rig.run(rig.now_s + 6.0)
    assert len(instructed(rig.all, Drive)) == 2
    rig.arrive()
    rig.failed(Pick, "the fork is stuck")
    rig.run(rig.now_s + 6.0)
    assert len(instructed(rig.all, Pick)) == 2
    rig.picked()
    assert rig.last(Drive).nodes[-1] == "m8"


def test_reports_of_older_ways_are_ignored() -> None:
    rig = contracted()
    old = rig.last(Drive)
    rig.report(NodePassed(order=old.order, node=old.nodes[1], index=1, battery_frac=0.9))
    rig.hear("M8", Release(task="M8-1", epoch=1, role=Role.PRIMARY, reason="no answer"))
    rig.hear("M8", award(task="M8-2", work=transport(sources=("S8",))))
    assert rig.last(Drive).order > old.order
    rig.report(WayDone(order=old.order, node="s3"))
    assert instructed(rig.all, Pick) == []


# --- watching ------------------------------------------------------------------------------------


def test_a_secondary_is_not_reserved() -> None:
    rig = parked()
    [answer] = sent(secondary(rig), Accepted, to="M8")
    assert answer.role is Role.SECONDARY
    beat = last_beat(rig)
    assert (beat.status, beat.task) == (AtvStatus.IDLE, None)
    assert [brief.task for brief in beat.watches] == ["M8-2"]
    assert instructed(rig.all, Drive) == []
    assert sent(rig.hear("M7", announcement(task="M7-1")), Bid)


def test_a_secondary_that_wins_work_resigns_all_its_watches() -> None:
    rig = parked()
    secondary(rig, "M8-2")
    secondary(rig, "M8-3")
    effects = rig.hear("M7", award(task="M7-1"))
    assert [message.task for message in sent(effects, Resigned, to="M8")] == ["M8-2", "M8-3"]
    assert last_beat(rig).watches == ()
    assert KEYS.atv_heartbeat("ATV2") not in listening(rig.all)


def test_the_contract_is_accepted_before_the_watches_are_given_back() -> None:
    rig = parked()
    secondary(rig)
    effects = rig.hear("M7", award(task="M7-1"))
    order = [
        bool(sent([effect], Accepted))
        for effect in effects
        if sent([effect], Accepted) or sent([effect], Resigned)
    ]
    assert order == [True, False]


def test_a_watch_that_is_awarded_twice_is_taken_once() -> None:
    rig = parked()
    secondary(rig)
    effects = secondary(rig)
    assert sent(effects, Accepted)
    assert facts(effects, ContractTaken) == []
    assert len(last_beat(rig).watches) == 1


def test_a_vehicle_watches_three_tasks_at_most() -> None:
    rig = parked()
    for number in range(3):
        assert sent(secondary(rig, f"M8-{number}"), Accepted)
    [declined] = sent(secondary(rig, "M8-9"), Declined)
    assert declined.reason is Refusal.WATCHING_ENOUGH


def test_a_vehicle_does_not_watch_itself() -> None:
    [declined] = sent(secondary(parked(), primary="ATV1"), Declined)
    assert declined.reason is Refusal.IS_PRIMARY


def test_a_watch_is_not_bid_for_twice() -> None:
    rig = parked()
    secondary(rig, "M8-2")
    again = announcement(task="M8-2", role=Role.SECONDARY, primary="ATV2")
    assert rig.hear("M8", again) == []


def test_a_released_watch_is_over_and_releasing_it_twice_is_harmless() -> None:
    rig = parked()
    secondary(rig, "M8-2")
    release = Release(task="M8-2", epoch=1, role=Role.SECONDARY, reason="the task has ended")
    assert len(facts(rig.hear("M8", release), ContractEnded)) == 1
    assert deeds(rig.hear("M8", release)) == []


def test_a_watch_is_released_by_its_coordinator_and_not_by_a_stale_word() -> None:
    rig = parked()
    rig.hear("M8", award(role=Role.SECONDARY, primary="ATV2", epoch=2))
    stale = Release(task="M8-1", epoch=1, role=Role.SECONDARY, reason="silent")
    strange = Release(task="M8-1", epoch=2, role=Role.SECONDARY, reason="silent")
    for sender, release in (("M8", stale), ("M3", strange)):
        effects = rig.hear(sender, release)
        assert deeds(effects) == []
        assert len(effects) == 1
    assert len(last_beat(rig).watches) == 1


def test_a_watch_is_renewed_for_a_newer_epoch_however_many_there_are() -> None:
    rig = parked()
    for number in range(MAX_WATCHES):
        secondary(rig, f"M8-{number}")
    newer = {"task": "M8-0", "epoch": 2, "role": Role.SECONDARY, "primary": "ATV3"}
    assert sent(rig.hear("M8", announcement(**newer)), Bid)
    assert sent(rig.hear("M8", award(**newer)), Accepted)
    assert len(last_beat(rig).watches) == MAX_WATCHES


def test_a_watched_primary_that_falls_silent_is_suspected_within_the_bound() -> None:
    rig = parked()
    secondary(rig, "M8-2", "ATV2")
    rig.now_s = 1.0
    rig.hear("ATV2", rhb("ATV2", 1, 1.0, task="M8-2"))
    effects = rig.run(1.0 + bound_s(WORKING_INTERVAL_S))
    [suspected] = facts(effects, PrimarySuspected)
    assert (suspected.task, suspected.primary) == ("M8-2", "ATV2")


def test_a_stopped_or_broken_vehicle_gives_its_watches_back() -> None:
    stopped, broken = parked(), parked()
    for rig in (stopped, broken):
        secondary(rig, "M8-2")
    command(stopped, CommandKind.STOP)
    broken.report(ProblemRaised(reason="a wheel is stuck"))
    for rig in (stopped, broken):
        assert len(sent(rig.all, Resigned, to="M8")) == 1


# --- people's commands ---------------------------------------------------------------------------


def test_a_stop_is_obeyed_at_once_and_answered() -> None:
    rig = contracted()
    answer = command(rig, CommandKind.STOP)
    assert (answer.done, answer.command) == (True, "C1")
    assert len(instructed(rig.all, Hold)) == 1
    assert last_beat(rig).status is AtvStatus.STOPPED
    [obeyed] = facts(rig.all, CommandObeyed)
    assert (obeyed.what, obeyed.done, obeyed.issued_by) == ("stop", True, "shift lead")


def test_a_vehicle_that_is_held_when_it_starts_is_stopped() -> None:
    rig = VehicleRig(battery_frac=0.5)
    rig.held = True
    rig.start()
    [declined] = sent(rig.hear("M8", award()), Declined)
    assert declined.reason is Refusal.NOT_FIT
    rig.run(60.0)
    assert instructed(rig.all, Drive) == []
    command(rig, CommandKind.ACKNOWLEDGE)
    assert command(rig, CommandKind.RESUME).done
    assert sent(rig.hear("M8", award()), Accepted)


def test_a_stop_holds_until_an_acknowledge_and_then_a_resume() -> None:
    rig = contracted()
    command(rig, CommandKind.STOP)
    refused = command(rig, CommandKind.RESUME)
    assert (refused.done, refused.reason) == (False, "acknowledge the stop first")
    assert command(rig, CommandKind.ACKNOWLEDGE).done
    assert instructed(rig.all, Unhold) == []
    assert last_beat(rig).status is AtvStatus.STOPPED
    assert command(rig, CommandKind.RESUME).done
    assert len(instructed(rig.all, Unhold)) == 1
    assert last_beat(rig).status is AtvStatus.WORKING


def test_a_stop_that_comes_again_after_the_resume_stops_nothing() -> None:
    rig = contracted()
    for kind in (CommandKind.STOP, CommandKind.ACKNOWLEDGE, CommandKind.RESUME):
        command(rig, kind)
    assert command(rig, CommandKind.STOP, name="C1").done
    assert len(instructed(rig.all, Hold)) == 1
    assert len(facts(rig.all, CommandObeyed)) == 3
    assert last_beat(rig).status is AtvStatus.WORKING


def test_a_resume_whose_answer_was_lost_is_answered_as_before() -> None:
    rig = contracted()
    for kind in (CommandKind.STOP, CommandKind.ACKNOWLEDGE, CommandKind.RESUME):
        command(rig, kind)
    assert command(rig, CommandKind.RESUME, name="C3").done


def test_commands_of_two_people_are_told_apart_by_who_gave_them() -> None:
    rig = contracted()
    command(rig, CommandKind.STOP)
    acknowledge = VehicleCommand(command="C1", kind=CommandKind.ACKNOWLEDGE)
    rig.hear("gateway", granted("ATV1", acknowledge, person="operator-north"))
    assert command(rig, CommandKind.RESUME).done


def test_a_second_stop_needs_an_acknowledge_of_its_own() -> None:
    rig = contracted()
    command(rig, CommandKind.STOP)
    command(rig, CommandKind.ACKNOWLEDGE)
    command(rig, CommandKind.STOP)
    assert not command(rig, CommandKind.RESUME).done
    assert instructed(rig.all, Unhold) == []


def test_an_acknowledge_before_the_stop_counts_for_nothing() -> None:
    rig = contracted()
    assert not command(rig, CommandKind.ACKNOWLEDGE).done
    command(rig, CommandKind.STOP)
    assert not command(rig, CommandKind.RESUME).done


def test_what_is_not_stopped_can_be_neither_acknowledged_nor_resumed() -> None:
    rig = contracted()
    for kind in (CommandKind.ACKNOWLEDGE, CommandKind.RESUME):
        answer = command(rig, kind)
        assert (answer.done, answer.reason) == (False, "it is not stopped")
    assert instructed(rig.all, Unhold) == []


def test_a_fault_that_is_still_there_cannot_be_acknowledged() -> None:
    rig = contracted()
    rig.report(ProblemRaised(reason="the load has shifted"))
    command(rig, CommandKind.STOP)
    refused = command(rig, CommandKind.ACKNOWLEDGE)
    assert (refused.done, refused.reason) == (False, "its sensors still report: the load has shifted")
    assert not command(rig, CommandKind.RESUME).done
    rig.report(ProblemCleared())
    assert command(rig, CommandKind.ACKNOWLEDGE).done
    assert command(rig, CommandKind.RESUME).done


def test_a_fault_that_comes_after_the_acknowledge_takes_it_back() -> None:
    rig = contracted()
    for kind in (CommandKind.STOP, CommandKind.ACKNOWLEDGE):
        command(rig, kind)
    rig.report(ProblemRaised(reason="the load has shifted"))
    rig.report(ProblemCleared())
    assert command(rig, CommandKind.RESUME).reason == "acknowledge the stop first"
    assert instructed(rig.all, Unhold) == []


def test_a_stopped_vehicle_tells_whether_it_was_acknowledged() -> None:
    rig = contracted()
    told = []
    for kind in (CommandKind.STOP, CommandKind.ACKNOWLEDGE, CommandKind.RESUME):
        command(rig, kind)
        told.append(last_beat(rig).acknowledged)
    assert told == [False, True, False]


def test_no_message_but_a_resume_moves_a_stopped_vehicle() -> None:
    rig = parked()
    command(rig, CommandKind.STOP)
    rig.held = True
    [declined] = sent(rig.hear("M8", award()), Declined)
    assert declined.reason is Refusal.NOT_FIT
    [refused] = facts(rig.hear("M8", announcement()), BidRefused)
    assert refused.reason is Refusal.NOT_FIT
    rig.battery_frac = 0.2
    effects = rig.run(300.0)
    assert instructed(effects, Drive) == instructed(effects, Unhold) == []


def test_a_stop_ends_no_contract() -> None:
    rig = contracted()
    command(rig, CommandKind.STOP)
    beat = last_beat(rig)
    assert beat.task is not None
    assert beat.task.task == "M8-1"
    assert sent(rig.hear("M8", award()), Accepted)
    command(rig, CommandKind.ACKNOWLEDGE)
    command(rig, CommandKind.RESUME)
    rig.arrive()
    assert len(instructed(rig.all, Pick)) == 1


@pytest.mark.parametrize("speed_frac", [None, 0.0, -0.1, 1.01, float("inf"), float("nan")])
def test_a_speed_outside_of_0_to_1_is_refused(speed_frac: float | None) -> None:
    rig = parked()
    answer = command(rig, CommandKind.SET_SPEED, speed_frac)
    assert not answer.done
    assert "above 0" in answer.reason
    assert instructed(rig.all, LimitSpeed) == []
    assert last_beat(rig).speed_limit_frac == 1.0


@pytest.mark.parametrize("speed_frac", [0.01, 0.5, 1.0])
def test_a_speed_limit_is_kept_and_told(speed_frac: float) -> None:
    rig = parked()
    assert command(rig, CommandKind.SET_SPEED, speed_frac).done
    assert instructed(rig.all, LimitSpeed) == [LimitSpeed(speed_frac=speed_frac)]
    assert last_beat(rig).speed_limit_frac == speed_frac


def test_a_refused_command_is_a_fact_too() -> None:
    rig = parked()
    command(rig, CommandKind.RESUME)
    [obeyed] = facts(rig.all, CommandObeyed)
    assert (obeyed.done, obeyed.reason) == (False, "it is not stopped")


# --- problems ------------------------------------------------------------------------------------


def test_a_vehicle_with_a_problem_is_in_error_says_why_and_takes_nothing() -> None:
    rig = parked()
    rig.report(ProblemRaised(reason="a wheel is stuck"))
    beat = last_beat(rig)
    assert (beat.status, beat.problem) == (AtvStatus.ERROR, "a wheel is stuck")
    [refused] = facts(rig.hear("M8", announcement()), BidRefused)
    assert (refused.reason, refused.detail) == (Refusal.NOT_FIT, "a wheel is stuck")


def test_a_problem_ends_no_contract_and_work_goes_on_after_it() -> None:
    rig = contracted()
    rig.report(ProblemRaised(reason="a wheel is stuck"))
    rig.report(ProblemCleared())
    beat = last_beat(rig)
    assert (beat.status, beat.problem) == (AtvStatus.WORKING, "")
    rig.arrive()
    assert len(instructed(rig.all, Pick)) == 1


def test_a_stop_is_seen_before_a_problem_and_a_problem_before_work() -> None:
    rig = contracted()
    rig.report(ProblemRaised(reason="a wheel is stuck"))
    assert last_beat(rig).status is AtvStatus.ERROR
    command(rig, CommandKind.STOP)
    assert last_beat(rig).status is AtvStatus.STOPPED
    assert last_beat(rig).problem == "a wheel is stuck"


# --- charging and parking ------------------------------------------------------------------------


def test_a_vehicle_with_a_low_battery_claims_a_charger_waits_drives_and_charges() -> None:
    rig = parked(node="p8", battery_frac=0.5)
    rig.run(SETTLED_S)
    claim = published(rig.all, BerthClaimed)[-1]
    assert claim.berth in PLANT.chargers
    assert instructed(rig.all, Drive) == []
    rig.run(SETTLED_S + CONTEST_S)
    assert rig.last(Drive).nodes[-1] == PLANT.node_of(claim.berth)
    rig.arrive()
    assert rig.last(Charge).charger == claim.berth
    beat = last_beat(rig)
    assert (beat.status, beat.berth) == (AtvStatus.CHARGING, claim.berth)


def test_a_parked_vehicle_whose_battery_gets_low_goes_to_charge_by_itself() -> None:
    rig = parked(node="p8", battery_frac=0.9)
    assert instructed(rig.run(120.0), Drive) == []
    rig.battery_frac = 0.55
    [drive] = instructed(rig.run(130.0), Drive)
    assert drive.nodes[-1] in {charger.node for charger in PLANT.chargers.values()}


def test_a_full_vehicle_leaves_the_charger_and_parks_out_of_the_way() -> None:
    rig = parked(node="ch2", battery_frac=0.5)
    rig.run(SETTLED_S)
    effects = rig.charged()
    assert [fact.status for fact in facts(effects, AtvStatusChanged)] == [AtvStatus.IDLE]
    rig.run(rig.now_s + CONTEST_S)
    assert rig.last(Drive).nodes[-1] in {place.node for place in PLANT.parkings.values()}
    assert KEYS.berth("CH2") not in listening(rig.all)
    rig.arrive()
    assert instructed(rig.run(600.0), Drive) == []


def test_a_vehicle_that_has_done_its_work_waits_a_moment_and_then_parks() -> None:
    rig = handing_over()
    rig.hear("M8", HandoverAccepted(task="M8-1", epoch=1))
    drives = len(instructed(rig.all, Drive))
    rig.run(rig.now_s + 3.9)
    assert len(instructed(rig.all, Drive)) == drives
    rig.run(rig.now_s + 2.0)
    assert rig.last(Drive).nodes[-1] in {place.node for place in PLANT.parkings.values()}


def test_work_ends_the_charge_and_the_berth_is_free() -> None:
    rig = parked(node="ch2", battery_frac=0.5)
    rig.run(SETTLED_S)
    rig.hear("M8", award())
    assert KEYS.berth("CH2") not in listening(rig.all)
    beat = last_beat(rig)
    assert (beat.status, beat.berth) == (AtvStatus.WORKING, "")
    rig.arrive()
    rig.run(rig.now_s + 60.0)
    assert len(instructed(rig.all, Charge)) == 1


def test_a_claim_that_is_lost_is_followed_by_another() -> None:
    rig = parked(node="p8", battery_frac=0.5)
    rig.run(SETTLED_S)
    first = published(rig.all, BerthClaimed)[-1].berth
    rival = BerthClaimed(berth=first, atv="ATV7", battery_frac=0.3, standing=False)
    rig.hear("ATV7", rival)
    rig.run(SETTLED_S + 0.1)
    second = published(rig.all, BerthClaimed)[-1].berth
    assert second in PLANT.chargers
    assert second != first
    rig.run(SETTLED_S + 0.1 + CONTEST_S)
    assert rig.last(Drive).nodes[-1] == PLANT.node_of(second)


def test_a_claim_that_is_lost_on_the_way_is_followed_by_another() -> None:
    rig = parked(node="p8", battery_frac=0.5)
    rig.run(SETTLED_S + CONTEST_S)
    first = last_beat(rig).berth
    rig.hear("ATV7", BerthClaimed(berth=first, atv="ATV7", battery_frac=0.5, standing=True))
    rig.run(SETTLED_S + 2 * CONTEST_S)
    second = last_beat(rig).berth
    assert second != first
    assert rig.last(Drive).nodes[-1] == PLANT.node_of(second)


def test_who_charges_is_never_driven_out() -> None:
    rig = parked(node="ch2", battery_frac=0.5)
    rig.run(SETTLED_S)
    rig.battery_frac = 0.9
    rival = BerthClaimed(berth="CH2", atv="ATV0", battery_frac=0.01, standing=False)
    [objection] = published(rig.hear("ATV0", rival), BerthClaimed)
    assert objection.standing
    rig.run(60.0)
    assert instructed(rig.all, Drive) == []
    assert last_beat(rig).berth == "CH2"


def test_when_every_charger_is_taken_the_vehicle_asks_again_later_and_does_not_spin() -> None:
    rig = parked(node="p8", battery_frac=0.5)
    rig.run(SETTLED_S)
    for _ in PLANT.chargers:
        rig.run(rig.now_s + 0.1)
        berth = published(rig.all, BerthClaimed)[-1].berth
        rig.hear("ATV7", BerthClaimed(berth=berth, atv="ATV7", battery_frac=0.1, standing=True))
    rig.run(rig.now_s + 0.1)
    claims = len([effect for effect in rig.all if published([effect], BerthClaimed)])
    rig.run(rig.now_s + 20.0)
    assert len([effect for effect in rig.all if published([effect], BerthClaimed)]) == claims
    rig.run(rig.now_s + 90.0)
    assert len([effect for effect in rig.all if published([effect], BerthClaimed)]) > claims


def test_a_vehicle_that_finds_no_charger_keeps_the_parking_place_it_stands_in() -> None:
    rig = parked(node="p3", battery_frac=0.5)
    rig.run(SETTLED_S)
    for _ in PLANT.chargers:
        for berth in PLANT.chargers:
            rig.hear("ATV7", BerthClaimed(berth=berth, atv="ATV7", battery_frac=0.1, standing=True))
        rig.run(rig.now_s + 0.1)
    assert KEYS.berth("P3") in listening(rig.all)
    [objection] = published(
        rig.hear("ATV8", BerthClaimed(berth="P3", atv="ATV8", battery_frac=0.1, standing=False)), BerthClaimed
    )
    assert objection.standing


def test_two_that_believe_to_stand_in_one_berth_do_not_argue_for_ever() -> None:
    rigs = [VehicleRig("ATV1", node="p3", battery_frac=0.9), VehicleRig("ATV2", node="p3", battery_frac=0.8)]
    claims = [(rig, claim) for rig in rigs for claim in published(rig.start(), BerthClaimed)]
    heard = 0
    while claims and heard < 100:
        speaker, claim = claims.pop(0)
        heard += 1
        for rig in rigs:
            if rig is not speaker:
                effects = rig.hear(speaker.agent.id, claim) + rig.run(rig.now_s)
                claims += [(rig, answer) for answer in published(effects, BerthClaimed)]
    assert heard < 10
    rigs[0].run(SETTLED_S)
    assert rigs[0].last(Drive).nodes[-1] != "p3"


def test_a_vehicle_that_arrives_elsewhere_does_not_stand_in_the_berth_that_it_has_claimed() -> None:
    rig = contracted()
    rig.hear("M8", Release(task="M8-1", epoch=1, role=Role.PRIMARY, reason="no answer"))
    claim = published(rig.run(rig.now_s + SETTLE_S), BerthClaimed)[-1]
    rig.arrive()
    assert rig.node == "s3"
    rival = BerthClaimed(berth=claim.berth, atv="ATV9", battery_frac=0.1, standing=False)
    assert not any(claim.standing for claim in published(rig.hear("ATV9", rival), BerthClaimed))


def test_a_nearly_full_vehicle_leaves_the_charger_to_others() -> None:
    rig = parked(node="ch2", battery_frac=0.5)
    rig.run(SETTLED_S)
    rig.battery_frac = CHARGED_FRAC - 0.01
    assert instructed(rig.run(30.0), Drive) == []
    rig.battery_frac = CHARGED_FRAC
    [drive] = instructed(rig.run(40.0), Drive)
    assert drive.nodes[-1] in {place.node for place in PLANT.parkings.values()}
    assert last_beat(rig).status is AtvStatus.IDLE


def test_vehicles_that_start_together_do_not_look_for_a_charger_together() -> None:
    claims_s = set()
    for atv in PLANT.fleet:
        rig = VehicleRig(atv, node="p8", battery_frac=0.5)
        rig.start()
        while not any(claim.berth in PLANT.chargers for claim in published(rig.all, BerthClaimed)):
            rig.run(rig.agent.wake_at_s)
        claims_s.add(rig.now_s)
    assert min(claims_s) >= SETTLE_S
    assert max(claims_s) <= 2 * SETTLE_S
    assert len(claims_s) > len(PLANT.fleet) / 2


def test_a_charge_that_fails_is_given_up_and_sought_anew() -> None:
    rig = parked(node="ch2", battery_frac=0.5)
    rig.run(SETTLED_S)
    rig.failed(Charge, "no contact")
    assert last_beat(rig).status is AtvStatus.IDLE
    effects = rig.run(rig.now_s + 30.0)
    assert published(effects, BerthClaimed)


# --- heartbeats ----------------------------------------------------------------------------------


@pytest.mark.parametrize(("rig", "interval_s"), [(parked, 5.0), (contracted, 1.0)])
def test_an_idle_vehicle_beats_every_five_seconds_and_a_working_one_every_second(
    rig: object, interval_s: float
) -> None:
    vehicle: VehicleRig = rig()  # type: ignore[operator]
    vehicle.run(60.0)
    vehicle.all.clear()
    vehicle.run(120.0)
    times_s = [beat.at_s for beat in vehicle.heartbeats(AtvHeartbeat)]
    gaps_s = [round(after - before, 6) for before, after in zip(times_s, times_s[1:], strict=False)]  # noqa: RUF007
    assert set(gaps_s) == {interval_s}
    assert len(gaps_s) >= 60 / interval_s - 2


def test_vehicles_that_start_together_do_not_beat_together() -> None:
    seconds_s = set()
    for atv in PLANT.fleet:
        rig = VehicleRig(atv)
        rig.start()
        rig.run(30.0)
        seconds_s.add(round(rig.heartbeats(AtvHeartbeat)[-1].at_s % 5.0, 3))
    assert len(seconds_s) > len(PLANT.fleet) / 2


def test_a_change_of_status_is_told_at_once() -> None:
    rig = parked()
    rig.run(12.0)
    rig.now_s = 12.1
    rig.hear("M8", award())
    beat = last_beat(rig)
    assert (beat.at_s, beat.status) == (12.1, AtvStatus.WORKING)


def test_heartbeats_are_numbered_without_a_gap_in_their_life() -> None:
    rig = contracted()
    rig.run(30.0)
    beats = rig.heartbeats(AtvHeartbeat)
    assert [beat.seq for beat in beats] == list(range(1, len(beats) + 1))
    assert {beat.incarnation for beat in beats} == {1}


# --- robustness ----------------------------------------------------------------------------------


def test_what_is_not_meant_for_a_vehicle_is_ignored() -> None:
    rig = contracted()
    for message in (
        bid(1.0),
        accepted(),
        mhb("M8"),
        rhb("ATV9", 1, 0.0),
        GoalClosed(goal="G1"),
        OrderReleased(order="O1", items=(), due_s=1.0),
        Docked(task="M8-1", epoch=1, station="M8"),
        Handover(task="M8-1", epoch=1, quantity=1),
        BerthClaimed(berth="CH1", atv="ATV9", battery_frac=0.1, standing=False),
    ):
        assert deeds(rig.hear("X", message)) == [], message


def test_a_goal_is_not_for_vehicles() -> None:
    rig = parked()
    [refused] = facts(rig.hear("S", announcement(work=production())), BidRefused)
    assert refused.reason is Refusal.ABILITY
    [declined] = sent(rig.hear("S", award(work=production())), Declined)
    assert declined.reason is Refusal.ABILITY


def test_a_vehicle_without_a_body_is_our_own_bug() -> None:
    class Ghost(VehicleRig):
        def sense(self) -> None:  # type: ignore[override]
            return None

    with pytest.raises(ProtocolViolation, match="needs a vehicle's body"):
        Ghost().start()


def test_being_woken_for_nothing_is_harmless() -> None:
    rig = contracted()
    rig.run(10.0)
    assert rig.wake() == []
    assert rig.wake() == []


def test_a_vehicle_leaves_what_it_is_told_as_it_is() -> None:
    rig = contracted()
    body = rig.sense()
    before = msgspec.json.encode(body)
    rig.run(30.0)
    rig.arrive()
    assert msgspec.json.encode(body) == before
