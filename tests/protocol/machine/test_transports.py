"""A machine's transports: a secondary is kept elected, and a silent primary is suspected (protocol, 4)."""

from __future__ import annotations

import msgspec
import pytest
from credulous import Credulous
from defaults import KEYS
from effects import deeds, facts, listening, published, sent
from transports_rig import TransportsRig, contracted, watched

from dray.messages import DockExpected, DockTime, Phase, Reason, Role, TaskAnnounced, Transport, Withdrawn
from dray.messages.fact import PrimarySuspected, TaskClosed, WatchLost
from dray.protocol.contract_net.dock_queues import TURN_S
from dray.protocol.liveness.suspicion import IDLE_INTERVAL_S, LATENESS_MAX_S, WORKING_INTERVAL_S, bound_s
from dray.protocol.runtime.events import NEVER_S
from dray.protocol.takeover.secondaries import WATCH_RULES
from dray.protocol.transports.carrier_waits import ONE_AFTER_ANOTHER_S, SETTLES_S

# --- the secondary -------------------------------------------------------------------------------


def test_the_secondary_is_elected_from_the_runners_up_without_an_announcement() -> None:
    rig = contracted()
    assert rig.asked() == ["ATV1"]
    rig.accepts("ATV1", Role.SECONDARY)
    assert rig.task.secondary == "ATV1"
    assert [message.role for message in published(rig.out, TaskAnnounced)] == [Role.PRIMARY]


def test_when_a_runner_up_declines_the_next_one_is_asked_to_watch() -> None:
    rig = contracted()
    rig.declines("ATV1", Role.SECONDARY)
    assert rig.asked() == ["ATV1", "ATV4"]


def test_a_runner_up_that_is_silent_is_released_and_the_next_one_asked() -> None:
    rig = contracted()
    rig.run(2.5, "ATV2")
    assert rig.asked()[:2] == ["ATV1", "ATV4"]
    assert ("ATV1", Role.SECONDARY) in rig.released()
    rig.accepts("ATV1", Role.SECONDARY)
    assert rig.task.secondary == ""
    rig.accepts("ATV4", Role.SECONDARY)
    assert rig.task.secondary == "ATV4"


def test_without_runners_up_the_watch_is_announced_and_names_the_primary() -> None:
    rig = TransportsRig()
    rig.open()
    rig.bids(ATV2=54.8)
    rig.run(1.0)
    rig.accepts("ATV2")
    [_, announced] = published(rig.out, TaskAnnounced)
    assert announced.role is Role.SECONDARY
    assert announced.primary == "ATV2"


def test_the_primary_cannot_watch_itself() -> None:
    rig = contracted()
    rig.declines("ATV1", Role.SECONDARY)
    rig.declines("ATV4", Role.SECONDARY)
    rig.bids(ATV2=1.0, role=Role.SECONDARY)
    rig.run(60.0, "ATV2")
    assert "ATV2" not in rig.asked()


def test_when_the_secondary_resigns_another_one_is_sought_at_once() -> None:
    rig = watched()
    rig.resigns("ATV1")
    assert rig.task.secondary == ""
    assert published(rig.out, TaskAnnounced)[-1].role is Role.SECONDARY
    [lost] = facts(rig.out, WatchLost)
    assert (lost.secondary, lost.reason) == ("ATV1", Reason.HAS_WORK)
    rig.bids(ATV4=60.0, role=Role.SECONDARY)
    rig.run(2.5, "ATV2")
    rig.accepts("ATV4", Role.SECONDARY)
    assert rig.task.secondary == "ATV4"


def test_resigning_twice_or_from_another_task_changes_nothing() -> None:
    rig = watched()
    rig.resigns("ATV4")
    rig.resigns("ATV1", task="T9")
    assert rig.task.secondary == "ATV1"
    rig.resigns("ATV1")
    said = len(deeds(rig.out))
    rig.resigns("ATV1")
    assert len(deeds(rig.out)) == said


def test_a_silent_secondary_is_released_and_another_one_is_sought() -> None:
    rig = watched()
    rig.run(rig.now_s + LATENESS_MAX_S + bound_s(IDLE_INTERVAL_S) + 0.1, "ATV2")
    assert rig.task.secondary == ""
    assert rig.released()[-1] == ("ATV1", Role.SECONDARY)
    assert [fact.reason for fact in facts(rig.out, WatchLost)] == ["silent"]
    assert published(rig.out, TaskAnnounced)[-1].role is Role.SECONDARY


def test_a_secondary_that_beats_is_kept() -> None:
    rig = watched()
    rig.run(600.0, "ATV1", "ATV2")
    assert rig.task.secondary == "ATV1"
    assert facts(rig.out, WatchLost) == []


def test_a_missing_watch_is_sought_as_long_as_the_task_lasts_but_in_no_hurry() -> None:
    rig = watched()
    rig.resigns("ATV1")
    rig.run(600.0, "ATV2")
    sought = [each for each in published(rig.out, TaskAnnounced) if each.role is Role.SECONDARY]
    assert 600 / (WATCH_RULES.rest_aged_max_s + WATCH_RULES.window_max_s) <= len(sought) + 1
    assert len(sought) <= 600 / WATCH_RULES.rest_s
    rig.bids(ATV4=60.0, role=Role.SECONDARY)
    rig.run(680.0, "ATV2")
    assert rig.asked()[-1] == "ATV4"


def test_accepting_a_watch_that_another_one_has_is_released() -> None:
    rig = watched()
    rig.accepts("ATV4", Role.SECONDARY)
    assert rig.task.secondary == "ATV1"
    assert rig.released() == [("ATV4", Role.SECONDARY)]
    rig.accepts("ATV1", Role.SECONDARY)
    assert rig.released() == [("ATV4", Role.SECONDARY)]


# --- silence of the primary ----------------------------------------------------------------------


def test_the_contracted_are_followed_and_nobody_else() -> None:
    rig = watched()
    assert listening(rig.out) == {KEYS.atv_heartbeat("ATV1"), KEYS.atv_heartbeat("ATV2")}
    rig.resigns("ATV1")
    assert listening(rig.out) == {KEYS.atv_heartbeat("ATV2")}


def test_a_silent_primary_is_suspected_within_the_bound_and_once() -> None:
    rig = watched()
    begun_s = rig.now_s
    rig.run(begun_s + LATENESS_MAX_S + bound_s(WORKING_INTERVAL_S), "ATV1")
    assert [fact.primary for fact in facts(rig.out, PrimarySuspected)] == ["ATV2"]
    rig.run(120.0, "ATV1")
    assert len(facts(rig.out, PrimarySuspected)) == 1


def test_a_primary_that_beats_is_not_suspected() -> None:
    rig = watched()
    rig.run(120.0, "ATV1", "ATV2")
    assert facts(rig.out, PrimarySuspected) == []


# --- the end -------------------------------------------------------------------------------------


def test_a_delivered_task_releases_its_secondary_and_not_its_carrier() -> None:
    rig = watched()
    rig.transports.close(rig.task, "delivered")
    assert rig.released() == [("ATV1", Role.SECONDARY)]
    assert sent(rig.out, Withdrawn) == []
    [closed] = facts(rig.out, TaskClosed)
    assert (closed.outcome, closed.carrier, closed.promised_s) == ("delivered", "ATV2", 100.0)
    assert listening(rig.out) == set()
    assert rig.life.timers.next_s == NEVER_S
    assert len(rig.transports) == 0


def test_a_watch_that_is_still_sought_at_the_end_is_sought_no_longer() -> None:
    rig = contracted()
    rig.transports.close(rig.task, "delivered")
    assert rig.released() == [("ATV1", Role.SECONDARY)]
    assert rig.life.timers.next_s == NEVER_S


# --- waits ---------------------------------------------------------------------------------------


def phase(rig: TransportsRig, atv: str, phase: Phase) -> None:
    """A carrier says how far it has come."""
    rig.seq += 1
    heartbeat = rig.heartbeat(atv)
    assert heartbeat.task is not None
    said = msgspec.structs.replace(heartbeat, task=msgspec.structs.replace(heartbeat.task, phase=phase))
    rig.transports.on_heartbeat(said, rig.now_s)


def told(rig: TransportsRig) -> dict[str, float]:
    """What the next announcement tells of waits."""
    rig.out.clear()
    rig.open("T2")
    return {wait.place: wait.wait_s for wait in published(rig.out, TaskAnnounced)[-1].waits}


def test_a_coordinator_tells_the_next_ones_how_long_its_carriers_have_waited() -> None:
    rig = watched()
    carrier = rig.task.primary
    rig.task.contract.source = "S3"
    work = rig.task.work
    assert isinstance(work, Transport)
    assert told(rig) == {}
    phase(rig, carrier, Phase.LOADING)
    rig.now_s += 50.0
    phase(rig, carrier, Phase.CARRYING)
    phase(rig, carrier, Phase.UNLOADING)
    rig.now_s += 20.0
    phase(rig, carrier, Phase.HANDING_OVER)
    handling_s = Credulous().handling_max_s
    known = rig.transports.announced_waits(work, rig.now_s)
    waits = {wait.place: wait.wait_s for wait in known}
    assert waits["S3"] == pytest.approx(50.0 - handling_s)
    assert waits[work.destination] == pytest.approx(20.0 - handling_s)


def test_who_stands_at_its_dock_now_counts_too() -> None:
    rig = watched()
    work = rig.task.work
    assert isinstance(work, Transport)
    rig.task.contract.held_s = rig.now_s
    rig.now_s += 33.0
    waits = {wait.place: wait.wait_s for wait in rig.transports.announced_waits(work, rig.now_s)}
    assert waits["M8"] == pytest.approx(33.0)


def expected(comes_s: float, place: str = "M8") -> DockExpected:
    return DockExpected(place=place, comes_s=comes_s, stays_s=15.0)


def test_who_is_expected_at_its_dock_is_told_to_those_who_bid() -> None:
    rig = TransportsRig()
    rig.transports.waits.on_expected("ATV9", expected(60.0), rig.now_s)
    rig.open()
    [announced] = published(rig.out, TaskAnnounced)
    [told] = announced.waits
    assert (told.place, told.wait_s) == ("M8", 0.0)
    assert told.expected == (DockTime(atv="ATV9", comes_s=60.0, leaves_s=75.0 + TURN_S),)


def hired() -> tuple[TransportsRig, float]:
    """A task that ATV2 has just promised to be done with, as if alone, and when that is."""
    rig = contracted()
    done_s = rig.task.contract.promised_s
    rig.transports.waits.on_expected("ATV2", expected(done_s - 55.0, "S3"), rig.now_s)
    rig.transports.waits.on_expected("ATV2", expected(done_s - 15.0), rig.now_s)
    assert rig.task.contract.promised_s == done_s
    return rig, done_s


@pytest.mark.parametrize("place", ["S3", "M8"])
def test_a_promise_counts_those_before_it_at_a_dock_who_were_hired_at_the_same_moment(place: str) -> None:
    rig, done_s = hired()
    comes_s = done_s - (15.0 if place == "M8" else 55.0)
    rig.transports.waits.on_expected("ATV9", expected(comes_s - 10.0, place), rig.now_s)
    assert rig.task.contract.promised_s == done_s + 5.0 + TURN_S
    rig.transports.waits.on_expected("ATV9", expected(comes_s + 60.0, place), rig.now_s)
    assert rig.task.contract.promised_s == done_s, "it comes later now"


def test_a_promise_counts_nobody_twice_of_whom_its_carrier_had_heard() -> None:
    rig, done_s = hired()
    rig.transports.waits.on_expected("ATV2", expected(done_s - 15.0 - 5.0 - TURN_S), rig.now_s)
    rig.transports.waits.on_expected("ATV9", expected(done_s - 30.0 - TURN_S), rig.now_s)
    assert rig.task.contract.promised_s == done_s


def test_a_promise_is_settled_soon_after_it_was_given() -> None:
    rig, done_s = hired()
    rig.run(rig.now_s + SETTLES_S + 0.5, "ATV2")
    rig.transports.waits.on_expected("ATV9", expected(done_s - 25.0), rig.now_s)
    assert rig.task.contract.promised_s == done_s


def test_where_carriers_queue_at_docks_one_is_hired_after_the_other() -> None:
    rig = TransportsRig()
    rig.transports.waits.on_expected("ATV9", expected(60.0), rig.now_s)
    rig.open("T1")
    rig.open("T2")
    assert [said.task for said in published(rig.out, TaskAnnounced)] == ["T1"]
    rig.run(ONE_AFTER_ANOTHER_S)
    assert list(dict.fromkeys(said.task for said in published(rig.out, TaskAnnounced))) == ["T1", "T2"]


def test_nothing_stands_behind_what_only_stood_behind_something_else() -> None:
    rig = TransportsRig()
    rig.open("T1")
    rig.run(10.0)  # Nobody bids: it waits.
    rig.open("T2")
    assert [said.task for said in published(rig.out, TaskAnnounced) if said.task == "T2"] == []
    rig.transports.offer("ATV2", ("crate",), rig.now_s)
    rig.bids(ATV2=50.0)
    rig.accepts("ATV2")
    rig.open("T3")
    assert [said.task for said in published(rig.out, TaskAnnounced) if said.task == "T3"] != []
