"""The coordinator of tasks: a contractor for each, and what is known of those that have ended (protocol, 3)."""

from __future__ import annotations

import pytest
from credulous import Credulous
from effects import deeds, listening, published, sent
from office import Office, contracted, watched
from spoken import accepted, bid, declined, transport

from dray.messages import Award, Role, TaskAnnounced, Withdrawn
from dray.protocol.contract_net.auction_rules import AuctionRules
from dray.protocol.contract_net.coordinator import CLOSED_KEPT, Coordinator
from dray.protocol.contract_net.terms import Place
from dray.protocol.runtime.events import NEVER_S, Effect
from dray.protocol.runtime.timers import Timers

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
    assert office.task.contract.promised_s == 100.0
    assert office.task.contract.source == "S3"
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
    assert office.task.round > 3600 / (AuctionRules().rest_aged_max_s + AuctionRules().window_max_s)
    assert office.timers.next_s < NEVER_S


# --- the end -------------------------------------------------------------------------------------


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


# --- a coordinator that watches nobody -----------------------------------------------------------


def test_where_contractors_are_not_watched_no_secondary_is_sought_and_nobody_is_suspected() -> None:
    out: list[Effect] = []
    timers = Timers()
    contracted: list[str] = []
    desk = Coordinator(
        "strategist",
        Place(x_m=0.0, y_m=0.0, reach_m=0.0),
        lambda _work, _radius_m: ("plant/goals/P1",),
        AuctionRules(),
        timers,
        out,
        lambda task, _now_s: contracted.append(task.id),
        Credulous(),
    )
    desk.open("T1", transport(), 300.0, 0.0)
    desk.on_bid("ATV2", bid(54.8), 0.5)
    desk.on_bid("ATV1", bid(55.9), 0.5)
    desk.alarms["primary auction"]("T1", timers.next_s)
    desk.on_bid("ATV4", bid(60.0, role=Role.SECONDARY), 1.5)
    desk.on_accepted("ATV2", accepted(), 2.0)
    desk.on_accepted("ATV1", accepted(role=Role.SECONDARY), 2.0)
    desk.on_declined("ATV1", declined(role=Role.SECONDARY), 2.0)
    assert contracted == ["T1"]
    assert [award.role for award in sent(out, Award)] == [Role.PRIMARY]
    assert listening(out) == set()
    assert timers.next_s == NEVER_S
