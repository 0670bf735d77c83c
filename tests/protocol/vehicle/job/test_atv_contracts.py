"""A vehicle bids for work, and carries out what it is contracted for (paper, 3.2)."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from atv1 import SETTLED_S, contracted, handing_over, last_beat, parked, unloading
from defaults import KEYS, PLANT
from effects import committed, deeds, facts, instructed, listening, sent
from rigs import VehicleRig
from spoken import announcement, award, transport

from dray.body import Drive, Drop, NodePassed, Pick, WayDone
from dray.messages import (
    Accepted,
    AtvStatus,
    Bid,
    Declined,
    Docked,
    DockHeld,
    DockOpened,
    Handover,
    HandoverAccepted,
    Message,
    Phase,
    Reason,
    Refusal,
    Release,
    Role,
    Superseded,
    TransportCost,
    Withdrawn,
)
from dray.messages.fact import BidRefused, ContractEnded, ContractTaken

# --- listening and bidding --------------------------------------------------------------------------


def test_a_vehicle_listens_to_the_announcements_for_its_own_cell() -> None:
    rig = parked(node="p3")
    cell = PLANT.cell_of(PLANT.nodes["p3"].x_m, PLANT.nodes["p3"].y_m)
    assert KEYS.transports(cell) in listening(rig.all)


def test_a_vehicle_takes_its_cell_subscriptions_along() -> None:
    rig = contracted(node="p8")
    before = {key for key in listening(rig.all) if "/task/" in key}
    rig.arrive()
    after = {key for key in listening(rig.all) if "/task/" in key}
    assert len(before) == len(after) == 1
    assert before != after


def test_an_idle_vehicle_bids() -> None:
    rig = parked()
    assert sent(rig.on_message("M8", announcement()), Bid, to="M8")


def test_a_vehicle_that_charges_bids_as_far_as_its_battery_keeps_the_promise() -> None:
    rig = parked(node="ch2", battery_frac=0.5)
    rig.run(SETTLED_S)
    assert last_beat(rig).status is AtvStatus.CHARGING
    assert sent(rig.on_message("M8", announcement()), Bid)
    rig.battery_frac = 0.1
    rig.run(rig.now_s + 6.0)
    [refused] = facts(rig.on_message("M8", announcement()), BidRefused)
    assert refused.reason is Refusal.BATTERY


def test_a_working_vehicle_refuses_because_it_is_busy() -> None:
    rig = contracted()
    [refused] = facts(rig.on_message("M7", announcement(task="M7-1")), BidRefused)
    assert (refused.reason, refused.detail) == (Refusal.BUSY, "M8-1")


def test_a_bid_reserves_nothing() -> None:
    rig = parked()
    for task in ("M8-1", "M8-2", "M8-3"):
        assert sent(rig.on_message("M8", announcement(task=task)), Bid)
    assert last_beat(rig).status is AtvStatus.IDLE


# --- the contract -----------------------------------------------------------------------------------


def test_an_award_is_accepted_and_the_vehicle_sets_off() -> None:
    rig = parked()
    effects = rig.on_message("M8", award())
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
    effects = parked().on_message("M8", award(work=work, source="S8"))
    assert instructed(effects, Drive)[-1].nodes[-1] == "s8"


def test_a_vehicle_is_primary_of_one_task_and_declines_the_second() -> None:
    rig = contracted()
    [declined] = sent(rig.on_message("M7", award(task="M7-1")), Declined, to="M7")
    assert declined.reason is Refusal.BUSY
    beat = last_beat(rig)
    assert beat.task is not None
    assert beat.task.task == "M8-1"


def test_an_award_that_comes_twice_is_accepted_twice_and_driven_once() -> None:
    rig = contracted()
    effects = rig.on_message("M8", award())
    first, second = sent(rig.all, Accepted)
    assert first == second
    assert instructed(effects, Drive) == []
    assert facts(effects, ContractTaken) == []


def test_a_whole_transport_ends_with_a_free_vehicle() -> None:
    rig = handing_over()
    assert [handover.task for handover in sent(rig.all, Handover, to="M8")] == ["M8-1"]
    effects = rig.on_message("M8", HandoverAccepted(task="M8-1", epoch=1))
    [ended] = facts(effects, ContractEnded)
    assert ended.reason == Reason.HANDED_OVER
    beat = last_beat(rig)
    assert (beat.status, beat.task, beat.load) == (AtvStatus.IDLE, None, "")
    assert sent(rig.on_message("M7", announcement(task="M7-1")), Bid)


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
    rig.on_message("M8", opened)
    rig.on_message("M8", opened)
    assert len(instructed(rig.all, Drop)) == 1
    rig.dropped()
    rig.on_message("M8", HandoverAccepted(task="M8-1", epoch=1))
    said = len(deeds(rig.all))
    for message in (
        opened,
        HandoverAccepted(task="M8-1", epoch=1),
        Superseded(task="M8-1", epoch=2),
        Release(task="M8-1", epoch=1, role=Role.PRIMARY, reason=Reason.NO_ANSWER, number=1),
        Withdrawn(task="M8-1", epoch=1, reason=Reason.NOT_NEEDED),
    ):
        rig.on_message("M8", message)
    assert len(deeds(rig.all)) == said


def test_answers_of_another_epoch_or_task_do_not_count() -> None:
    rig = unloading()
    for message in (
        DockOpened(task="M8-1", epoch=2, station="M8"),
        DockOpened(task="M8-9", epoch=1, station="M8"),
        HandoverAccepted(task="M8-1", epoch=2),
        Withdrawn(task="M8-1", epoch=2, reason=Reason.NOT_NEEDED),
        Withdrawn(task="M8-9", epoch=1, reason=Reason.NOT_NEEDED),
        Superseded(task="M8-9", epoch=2),
    ):
        rig.on_message("M8", message)
    assert instructed(rig.all, Drop) == []
    assert facts(rig.all, ContractEnded) == []


def test_a_question_is_repeated_until_the_machine_answers() -> None:
    rig = unloading()
    rig.run(rig.now_s + 10.0)
    assert len(sent(rig.all, Docked, to="M8")) == 4
    rig.on_message("M8", DockHeld(task="M8-1", epoch=1, station="M8", reason="the buffer is full"))
    assert sent(rig.run(rig.now_s + 4.9), Docked) == []
    assert len(sent(rig.run(rig.now_s + 0.2), Docked)) == 1


def test_a_released_vehicle_without_a_load_is_free_at_once() -> None:
    rig = contracted()
    release = Release(task="M8-1", epoch=1, role=Role.PRIMARY, reason=Reason.NO_ANSWER, number=1)
    [ended] = facts(rig.on_message("M8", release), ContractEnded)
    assert ended.reason == Reason.RELEASED
    assert deeds(rig.on_message("M8", release)) == []
    assert last_beat(rig).status is AtvStatus.IDLE
    assert sent(rig.on_message("M7", announcement(task="M7-1")), Bid)


def test_a_release_of_an_earlier_award_does_not_end_the_contract_of_a_later_one() -> None:
    rig = contracted()
    [again] = sent(
        rig.on_message("M8", award(number=2)), Accepted
    )  # Its first answer was lost, and it was asked once more.
    assert again.number == 2
    late = Release(task="M8-1", epoch=1, role=Role.PRIMARY, reason=Reason.NO_ANSWER, number=1)
    assert deeds(rig.on_message("M8", late)) == []
    assert last_beat(rig).task is not None
    release = Release(task="M8-1", epoch=1, role=Role.PRIMARY, reason=Reason.NO_ANSWER, number=2)
    assert facts(rig.on_message("M8", release), ContractEnded)


def test_a_release_of_another_epoch_is_ignored() -> None:
    rig = contracted()
    release = Release(task="M8-1", epoch=2, role=Role.PRIMARY, reason=Reason.NO_ANSWER, number=1)
    assert deeds(rig.on_message("M8", release)) == []


@pytest.mark.parametrize(
    "message",
    [
        Release(task="M8-1", epoch=1, role=Role.PRIMARY, reason=Reason.NO_ANSWER, number=1),
        Withdrawn(task="M8-1", epoch=1, reason=Reason.NOT_NEEDED),
        Superseded(task="M8-1", epoch=2),
        DockOpened(task="M8-1", epoch=1, station="M8"),
    ],
    ids=lambda message: type(message).__name__,
)
def test_a_contract_is_changed_by_its_coordinator_alone(message: Message) -> None:
    rig = unloading()
    effects = rig.on_message("M3", message)
    assert deeds(effects) == []
    assert len(effects) == 1
    assert last_beat(rig).status is AtvStatus.WORKING


@pytest.mark.parametrize("change", [{"sources": ("nowhere",)}, {"destination": "nowhere"}])
def test_a_transport_from_or_to_an_unknown_place_is_refused_and_declined(change: dict[str, object]) -> None:
    rig, work = parked(), transport(**change)
    [refused] = facts(rig.on_message("M8", announcement(work=work)), BidRefused)
    assert refused.reason is Refusal.NO_WAY
    [declined] = sent(rig.on_message("M8", award(work=work)), Declined, to="M8")
    assert declined.reason is Refusal.NO_WAY


def test_an_answer_carries_the_number_of_its_award() -> None:
    rig = parked()
    [taken] = sent(rig.on_message("M8", award(number=3)), Accepted)
    [again] = sent(rig.on_message("M8", award(number=4)), Accepted)
    [declined] = sent(rig.on_message("M7", award(task="M7-1", number=5)), Declined)
    assert (taken.number, again.number, declined.number) == (3, 4, 5)


@pytest.mark.parametrize(
    "message",
    [
        Superseded(task="M8-1", epoch=2),
        Withdrawn(task="M8-1", epoch=1, reason=Reason.NOT_NEEDED),
        Release(task="M8-1", epoch=1, role=Role.PRIMARY, reason=Reason.WITHDRAWN, number=1),
    ],
    ids=lambda message: type(message).__name__,
)
def test_a_carrier_without_a_contract_brings_its_load_to_a_storage_before_it_is_free(
    message: Superseded | Withdrawn | Release,
) -> None:
    rig = unloading()
    rig.on_message("M8", message)
    assert facts(rig.all, ContractEnded) == []
    assert [declined.reason for declined in sent(rig.on_message("M7", award(task="M7-1")), Declined)] == [
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
    rig.on_message("M8", Release(task="M8-1", epoch=1, role=Role.PRIMARY, reason=Reason.NO_ANSWER, number=1))
    rig.on_message("M8", award(task="M8-2", work=transport(sources=("S8",))))
    assert rig.last(Drive).order > old.order
    rig.report(WayDone(order=old.order, node="s3"))
    assert instructed(rig.all, Pick) == []


def second_life(before: VehicleRig) -> VehicleRig:
    """ATV1 is started again where it stands, long after the plant was."""
    rig = VehicleRig(node=before.node, incarnation=2)
    rig.memory, rig.load = committed(before.all), before.load
    rig.now_s = before.now_s + 1000.0
    rig.start()
    return rig


def delivered(rig: VehicleRig) -> float:
    """ATV1 brings the rest of its transport to its end without a wait; the waits that it counts in its next bid (s)."""
    if not rig.load[0] and instructed(rig.all, Pick):
        rig.picked()
    if rig.load[0]:
        if instructed(rig.all, Drive):
            rig.arrive()
        rig.on_message("M8", DockOpened(task="M8-1", epoch=1, station="M8"))
        rig.dropped()
    rig.on_message("M8", HandoverAccepted(task="M8-1", epoch=1))
    rig.run(rig.now_s)  # It sees that its load is down.
    [bid] = sent(rig.on_message("M8", announcement(task="M8-2")), Bid)
    assert isinstance(bid.cost, TransportCost)
    return bid.cost.waiting_s


def test_a_wait_at_a_dock_counts_in_the_next_bid() -> None:
    rig = contracted()
    rig.arrive()
    rig.now_s += PLANT.vehicle_types["light"].load_s + 100.0
    assert delivered(rig) == pytest.approx(100.0)


def at_source() -> VehicleRig:
    rig = contracted()
    rig.arrive()
    return rig


def picked_meanwhile() -> VehicleRig:
    rig = at_source()
    rig.load = (rig.last(Pick).item, rig.last(Pick).quantity)
    return rig


def dropped_meanwhile() -> VehicleRig:
    rig = unloading()
    rig.on_message("M8", DockOpened(task="M8-1", epoch=1, station="M8"))
    rig.load = ("", 0)
    return rig


@pytest.mark.parametrize("before", [at_source, picked_meanwhile, unloading, dropped_meanwhile])
def test_a_wait_that_an_earlier_life_began_counts_for_nothing(before: Callable[[], VehicleRig]) -> None:
    """Its length is unknown. Taken from the plant's start, it made a lone vehicle refuse everything for ten minutes."""
    assert delivered(second_life(before())) == 0.0
