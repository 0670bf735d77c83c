"""A vehicle watches others as their secondary, and takes over (paper, 3.2)."""

from __future__ import annotations

from atv1 import command, last_beat, parked, secondary
from defaults import KEYS
from effects import deeds, facts, instructed, listening, sent
from spoken import announcement, award, rhb

from dray.body import Drive, ProblemRaised
from dray.messages import (
    Accepted,
    AtvStatus,
    Bid,
    CommandKind,
    Declined,
    Reason,
    Refusal,
    Release,
    Resigned,
    Role,
)
from dray.messages.fact import ContractEnded, ContractTaken, PrimarySuspected
from dray.protocol.liveness.suspicion import WORKING_INTERVAL_S, bound_s
from dray.protocol.vehicle.bidding import MAX_WATCHES


def test_a_secondary_is_not_reserved() -> None:
    rig = parked()
    [answer] = sent(secondary(rig), Accepted, to="M8")
    assert answer.role is Role.SECONDARY
    beat = last_beat(rig)
    assert (beat.status, beat.task) == (AtvStatus.IDLE, None)
    assert [brief.task for brief in beat.watches] == ["M8-2"]
    assert instructed(rig.all, Drive) == []
    assert sent(rig.on_message("M7", announcement(task="M7-1")), Bid)


def test_a_secondary_that_wins_work_resigns_all_its_watches() -> None:
    rig = parked()
    secondary(rig, "M8-2")
    secondary(rig, "M8-3")
    effects = rig.on_message("M7", award(task="M7-1"))
    assert [message.task for message in sent(effects, Resigned, to="M8")] == ["M8-2", "M8-3"]
    assert last_beat(rig).watches == ()
    assert KEYS.atv_heartbeat("ATV2") not in listening(rig.all)


def test_the_contract_is_accepted_before_the_watches_are_given_back() -> None:
    rig = parked()
    secondary(rig)
    effects = rig.on_message("M7", award(task="M7-1"))
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


def test_a_watch_that_its_coordinator_does_not_know_of_is_bid_for_and_taken_again() -> None:
    rig = parked()
    secondary(rig, "M8-2")
    again = announcement(task="M8-2", role=Role.SECONDARY, primary="ATV2")
    assert len(sent(rig.on_message("M8", again), Bid, to="M8")) == 1
    given = award(task="M8-2", role=Role.SECONDARY, primary="ATV2", number=7)
    [taken] = sent(rig.on_message("M8", given), Accepted, to="M8")
    assert taken.number == 7
    old = Release(task="M8-2", epoch=1, role=Role.SECONDARY, reason=Reason.SILENT, number=1)
    assert deeds(rig.on_message("M8", old)) == []
    assert len(last_beat(rig).watches) == 1


def test_a_released_watch_is_over_and_releasing_it_twice_is_harmless() -> None:
    rig = parked()
    secondary(rig, "M8-2")
    release = Release(task="M8-2", epoch=1, role=Role.SECONDARY, reason=Reason.TASK_ENDED, number=1)
    assert len(facts(rig.on_message("M8", release), ContractEnded)) == 1
    assert deeds(rig.on_message("M8", release)) == []


def test_a_watch_is_released_by_its_coordinator_and_not_by_a_stale_word() -> None:
    rig = parked()
    rig.on_message("M8", award(role=Role.SECONDARY, primary="ATV2", epoch=2, number=2))
    stale = Release(task="M8-1", epoch=1, role=Role.SECONDARY, reason=Reason.SILENT, number=1)
    strange = Release(task="M8-1", epoch=2, role=Role.SECONDARY, reason=Reason.SILENT, number=2)
    for sender, release in (("M8", stale), ("M3", strange)):
        effects = rig.on_message(sender, release)
        assert deeds(effects) == []
        assert len(effects) == 1
    assert len(last_beat(rig).watches) == 1


def test_a_watch_is_renewed_for_a_newer_epoch_however_many_there_are() -> None:
    rig = parked()
    for number in range(MAX_WATCHES):
        secondary(rig, f"M8-{number}")
    newer = {"task": "M8-0", "epoch": 2, "role": Role.SECONDARY, "primary": "ATV3"}
    assert sent(rig.on_message("M8", announcement(**newer)), Bid)
    assert sent(rig.on_message("M8", award(**newer)), Accepted)
    assert len(last_beat(rig).watches) == MAX_WATCHES


def test_a_watched_primary_that_falls_silent_is_suspected_within_the_bound() -> None:
    rig = parked()
    secondary(rig, "M8-2", "ATV2")
    rig.now_s = 1.0
    rig.on_message("ATV2", rhb("ATV2", 1, 1.0, task="M8-2"))
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
