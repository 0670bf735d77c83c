"""The coordinator of tasks: a primary for each, and a secondary that it keeps elected (protocol, 3 and 4)."""

from __future__ import annotations

import pytest
from kit import (
    KEYS,
    deeds,
    facts,
    listening,
    published,
    sent,
)
from office import Office, contracted, watched

from dray.messages import (
    Role,
    TaskAnnounced,
    Withdrawn,
)
from dray.messages.fact import PrimarySuspected, TaskClosed, WatchLost
from dray.protocol.coordinator import CLOSED_KEPT
from dray.protocol.events import NEVER_S
from dray.protocol.secondaries import WATCH_RULES
from dray.protocol.suspicion import IDLE_INTERVAL_S, LATENESS_MAX_S, WORKING_INTERVAL_S, bound_s

# --- the primary ---------------------------------------------------------------------------------


def test_a_task_that_is_opened_is_announced_with_epoch_1() -> None:
    office = Office()
    task = office.open()
    [announced] = published(office.out, TaskAnnounced)
    assert (announced.task, announced.epoch, announced.role) == ("T1", 1, Role.PRIMARY)
    assert (task.primary, task.secondary, task.round) == ("", "", 1)
    assert [each.id for each in office.desk] == ["T1"]


def test_who_accepts_becomes_the_primary_with_its_promise_and_its_source() -> None:
    office = contracted()
    assert office.task.primary == "ATV2"
    assert office.task.promised_s == 100.0
    assert office.task.source == "S3"
    assert office.contracted == ["T1"]


def test_accepting_twice_contracts_once() -> None:
    office = contracted()
    said = len(deeds(office.out))
    office.accepts("ATV2")
    assert office.contracted == ["T1"]
    assert len(deeds(office.out)) == said


def test_a_second_one_who_accepts_late_is_released_and_takes_nothing() -> None:
    office = contracted()
    office.accepts("ATV4")
    assert office.task.primary == "ATV2"
    assert office.released() == [("ATV4", Role.PRIMARY)]


def test_an_answer_for_an_unknown_task_is_released() -> None:
    office = Office()
    office.accepts("ATV1", task="T9")
    assert office.released() == [("ATV1", Role.PRIMARY)]


@pytest.mark.parametrize("epoch", [0, 2])
def test_answers_and_bids_of_another_epoch_do_not_count(epoch: int) -> None:
    office = Office()
    office.open()
    office.bids(ATV1=55.9, epoch=epoch)
    office.run(1.0)
    assert office.asked(Role.PRIMARY) == []
    office.bids(ATV2=54.8)
    office.run(5.0)
    assert office.asked(Role.PRIMARY)
    office.accepts("ATV2", epoch=epoch)
    assert office.task.primary == ""
    assert office.released()[-1] == ("ATV2", Role.PRIMARY)


def test_tasks_are_auctioned_side_by_side() -> None:
    office = Office()
    office.open("T1")
    office.open("T2")
    office.bids("T1", ATV1=50.0)
    office.bids("T2", ATV2=50.0)
    office.run(1.0)
    office.accepts("ATV2", task="T2")
    office.accepts("ATV1", task="T1")
    assert [task.primary for task in office.desk] == ["ATV1", "ATV2"]


def test_a_task_for_which_nobody_bids_stays_announced() -> None:
    office = Office()
    office.open()
    office.run(3600.0)
    assert office.desk.get("T1") is not None
    assert office.task.round > 50
    assert office.timers.next_s < NEVER_S


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
    assert 600 / (WATCH_RULES.rest_max_s + WATCH_RULES.window_max_s) <= len(sought) + 1
    assert len(sought) <= 600 / WATCH_RULES.rest_s
    office.bids(ATV4=60.0, role=Role.SECONDARY)
    office.run(620.0, "ATV2")
    assert office.asked()[-1] == "ATV4"


def test_accepting_a_watch_that_another_one_has_is_released() -> None:
    office = watched()
    office.accepts("ATV4", Role.SECONDARY)
    assert office.task.secondary == "ATV1"
    assert office.released() == [("ATV4", Role.SECONDARY)]
    office.accepts("ATV1", Role.SECONDARY)
    assert office.released() == [("ATV4", Role.SECONDARY)]


def test_where_contractors_are_not_watched_no_secondary_is_sought() -> None:
    office = Office(watched=False)
    office.open()
    office.bids(ATV1=55.9, ATV2=54.8)
    office.run(1.0)
    office.accepts("ATV2")
    office.run(600.0)
    assert office.asked() == []
    assert facts(office.out, PrimarySuspected) == []
    assert office.timers.next_s == NEVER_S


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


def test_a_withdrawn_task_is_withdrawn_from_its_carrier_too() -> None:
    office = watched()
    office.desk.close(office.task, "withdrawn")
    [message] = sent(office.out, Withdrawn, to="ATV2")
    assert (message.task, message.epoch) == ("T1", 1)
    assert office.released() == [("ATV1", Role.SECONDARY)]


def test_a_task_that_is_withdrawn_during_its_auction_releases_who_was_asked() -> None:
    office = Office()
    task = office.open()
    office.bids(ATV1=50.0)
    office.run(1.0)
    office.desk.close(task, "withdrawn")
    assert office.released() == [("ATV1", Role.PRIMARY)]
    assert office.timers.next_s == NEVER_S
    office.accepts("ATV1")
    assert office.released()[-1] == ("ATV1", Role.PRIMARY)


def test_a_watch_that_is_still_sought_at_the_end_is_sought_no_longer() -> None:
    office = contracted()
    office.desk.close(office.task, "delivered")
    assert office.released() == [("ATV1", Role.SECONDARY)]
    assert office.timers.next_s == NEVER_S


def test_the_carrier_of_a_closed_task_is_remembered_within_a_bound() -> None:
    office = contracted()
    office.desk.close(office.task, "delivered")
    closed = office.desk.closed("T1")
    assert closed is not None
    assert (closed.carrier, closed.epoch, closed.outcome) == ("ATV2", 1, "delivered")
    for number in range(CLOSED_KEPT):
        office.desk.close(office.open(f"X{number}"), "withdrawn")
    assert office.desk.closed("T1") is None


def test_what_is_heard_of_a_closed_task_opens_nothing() -> None:
    office = watched()
    office.desk.close(office.task, "delivered")
    said = len(deeds(office.out))
    office.bids(ATV4=1.0)
    office.declines("ATV4")
    office.resigns("ATV1")
    office.desk.alarms["primary auction"]("T1", 500.0)
    assert len(deeds(office.out)) == said
