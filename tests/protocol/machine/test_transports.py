"""A machine's transports: a secondary is kept elected, and a silent primary is suspected (protocol, 4)."""

from __future__ import annotations

import msgspec
import pytest
from credulous import Credulous
from defaults import KEYS
from effects import deeds, facts, listening, published, sent
from office import Office, contracted, watched

from dray.messages import Phase, Role, TaskAnnounced, Transport, Withdrawn
from dray.messages.fact import PrimarySuspected, TaskClosed, WatchLost
from dray.protocol.liveness.suspicion import IDLE_INTERVAL_S, LATENESS_MAX_S, WORKING_INTERVAL_S, bound_s
from dray.protocol.runtime.events import NEVER_S
from dray.protocol.takeover.secondaries import WATCH_RULES

# --- the secondary -------------------------------------------------------------------------------


def test_the_secondary_is_elected_from_the_runners_up_without_an_announcement() -> None:
    office = contracted()
    assert office.asked() == ["ATV1"]
    office.accepts("ATV1", Role.SECONDARY)
    assert office.task.secondary == "ATV1"
    assert [message.role for message in published(office.out, TaskAnnounced)] == [Role.PRIMARY]


def test_when_a_runner_up_declines_the_next_one_is_asked_to_watch() -> None:
    office = contracted()
    office.declines("ATV1", Role.SECONDARY)
    assert office.asked() == ["ATV1", "ATV4"]


def test_a_runner_up_that_is_silent_is_released_and_the_next_one_asked() -> None:
    office = contracted()
    office.run(2.5, "ATV2")
    assert office.asked()[:2] == ["ATV1", "ATV4"]
    assert ("ATV1", Role.SECONDARY) in office.released()
    office.accepts("ATV1", Role.SECONDARY)
    assert office.task.secondary == ""
    office.accepts("ATV4", Role.SECONDARY)
    assert office.task.secondary == "ATV4"


def test_without_runners_up_the_watch_is_announced_and_names_the_primary() -> None:
    office = Office()
    office.open()
    office.bids(ATV2=54.8)
    office.run(1.0)
    office.accepts("ATV2")
    [_, announced] = published(office.out, TaskAnnounced)
    assert announced.role is Role.SECONDARY
    assert announced.primary == "ATV2"


def test_the_primary_cannot_watch_itself() -> None:
    office = contracted()
    office.declines("ATV1", Role.SECONDARY)
    office.declines("ATV4", Role.SECONDARY)
    office.bids(ATV2=1.0, role=Role.SECONDARY)
    office.run(60.0, "ATV2")
    assert "ATV2" not in office.asked()


def test_when_the_secondary_resigns_another_one_is_sought_at_once() -> None:
    office = watched()
    office.resigns("ATV1")
    assert office.task.secondary == ""
    assert published(office.out, TaskAnnounced)[-1].role is Role.SECONDARY
    [lost] = facts(office.out, WatchLost)
    assert (lost.secondary, lost.reason) == ("ATV1", "has work of its own")
    office.bids(ATV4=60.0, role=Role.SECONDARY)
    office.run(2.5, "ATV2")
    office.accepts("ATV4", Role.SECONDARY)
    assert office.task.secondary == "ATV4"


def test_resigning_twice_or_from_another_task_changes_nothing() -> None:
    office = watched()
    office.resigns("ATV4")
    office.resigns("ATV1", task="T9")
    assert office.task.secondary == "ATV1"
    office.resigns("ATV1")
    said = len(deeds(office.out))
    office.resigns("ATV1")
    assert len(deeds(office.out)) == said


def test_a_silent_secondary_is_released_and_another_one_is_sought() -> None:
    office = watched()
    office.run(office.now_s + LATENESS_MAX_S + bound_s(IDLE_INTERVAL_S) + 0.1, "ATV2")
    assert office.task.secondary == ""
    assert office.released()[-1] == ("ATV1", Role.SECONDARY)
    assert [fact.reason for fact in facts(office.out, WatchLost)] == ["silent"]
    assert published(office.out, TaskAnnounced)[-1].role is Role.SECONDARY


def test_a_secondary_that_beats_is_kept() -> None:
    office = watched()
    office.run(600.0, "ATV1", "ATV2")
    assert office.task.secondary == "ATV1"
    assert facts(office.out, WatchLost) == []


def test_a_missing_watch_is_sought_as_long_as_the_task_lasts_but_in_no_hurry() -> None:
    office = watched()
    office.resigns("ATV1")
    office.run(600.0, "ATV2")
    sought = [each for each in published(office.out, TaskAnnounced) if each.role is Role.SECONDARY]
    assert 600 / (WATCH_RULES.rest_aged_max_s + WATCH_RULES.window_max_s) <= len(sought) + 1
    assert len(sought) <= 600 / WATCH_RULES.rest_s
    office.bids(ATV4=60.0, role=Role.SECONDARY)
    office.run(680.0, "ATV2")
    assert office.asked()[-1] == "ATV4"


def test_accepting_a_watch_that_another_one_has_is_released() -> None:
    office = watched()
    office.accepts("ATV4", Role.SECONDARY)
    assert office.task.secondary == "ATV1"
    assert office.released() == [("ATV4", Role.SECONDARY)]
    office.accepts("ATV1", Role.SECONDARY)
    assert office.released() == [("ATV4", Role.SECONDARY)]


# --- silence of the primary ----------------------------------------------------------------------


def test_the_contracted_are_followed_and_nobody_else() -> None:
    office = watched()
    assert listening(office.out) == {KEYS.atv_heartbeat("ATV1"), KEYS.atv_heartbeat("ATV2")}
    office.resigns("ATV1")
    assert listening(office.out) == {KEYS.atv_heartbeat("ATV2")}


def test_a_silent_primary_is_suspected_within_the_bound_and_once() -> None:
    office = watched()
    begun_s = office.now_s
    office.run(begun_s + LATENESS_MAX_S + bound_s(WORKING_INTERVAL_S), "ATV1")
    assert [fact.primary for fact in facts(office.out, PrimarySuspected)] == ["ATV2"]
    office.run(120.0, "ATV1")
    assert len(facts(office.out, PrimarySuspected)) == 1


def test_a_primary_that_beats_is_not_suspected() -> None:
    office = watched()
    office.run(120.0, "ATV1", "ATV2")
    assert facts(office.out, PrimarySuspected) == []


# --- the end -------------------------------------------------------------------------------------


def test_a_delivered_task_releases_its_secondary_and_not_its_carrier() -> None:
    office = watched()
    office.desk.close(office.task, "delivered")
    assert office.released() == [("ATV1", Role.SECONDARY)]
    assert sent(office.out, Withdrawn) == []
    [closed] = facts(office.out, TaskClosed)
    assert (closed.outcome, closed.carrier, closed.promised_s) == ("delivered", "ATV2", 100.0)
    assert listening(office.out) == set()
    assert office.timers.next_s == NEVER_S
    assert len(office.desk) == 0


def test_a_watch_that_is_still_sought_at_the_end_is_sought_no_longer() -> None:
    office = contracted()
    office.desk.close(office.task, "delivered")
    assert office.released() == [("ATV1", Role.SECONDARY)]
    assert office.timers.next_s == NEVER_S


# --- waits ---------------------------------------------------------------------------------------


def phase(office: Office, atv: str, phase: Phase) -> None:
    """A carrier says how far it has come."""
    office.seq += 1
    heartbeat = office.heartbeat(atv)
    assert heartbeat.task is not None
    said = msgspec.structs.replace(heartbeat, task=msgspec.structs.replace(heartbeat.task, phase=phase))
    office.desk.on_heartbeat(said, office.now_s)


def told(office: Office) -> dict[str, float]:
    """What the next announcement tells of waits."""
    office.out.clear()
    office.open("T2")
    return {wait.place: wait.wait_s for wait in published(office.out, TaskAnnounced)[-1].waits}


def test_a_coordinator_tells_the_next_ones_how_long_its_carriers_have_waited() -> None:
    office = watched()
    carrier = office.task.primary
    office.task.contract.source = "S3"
    work = office.task.work
    assert isinstance(work, Transport)
    assert told(office) == {}
    phase(office, carrier, Phase.LOADING)
    office.now_s += 50.0
    phase(office, carrier, Phase.CARRYING)
    phase(office, carrier, Phase.UNLOADING)
    office.now_s += 20.0
    phase(office, carrier, Phase.HANDING_OVER)
    handling_s = Credulous().handling_max_s
    known = office.desk.told_waits(work, office.now_s)
    waits = {wait.place: wait.wait_s for wait in known}
    assert waits["S3"] == pytest.approx(50.0 - handling_s)
    assert waits[work.destination] == pytest.approx(20.0 - handling_s)


def test_who_stands_at_its_dock_now_counts_too() -> None:
    office = watched()
    work = office.task.work
    assert isinstance(work, Transport)
    office.task.contract.held_s = office.now_s
    office.now_s += 33.0
    waits = {wait.place: wait.wait_s for wait in office.desk.told_waits(work, office.now_s)}
    assert waits["M8"] == pytest.approx(33.0)


def test_nothing_stands_behind_what_only_stood_behind_something_else() -> None:
    office = Office()
    office.open("T1")
    office.run(10.0)  # Nobody bids: it waits.
    office.open("T2")
    assert [said.task for said in published(office.out, TaskAnnounced) if said.task == "T2"] == []
    office.desk.offer("ATV2", ("crate",), office.now_s)
    office.bids(ATV2=50.0)
    office.accepts("ATV2")
    office.open("T3")
    assert [said.task for said in published(office.out, TaskAnnounced) if said.task == "T3"] != []
