"""The coordinator of tasks: a contractor for each, and what is known of those that have ended (protocol, 3)."""

from __future__ import annotations

import pytest
from credulous import Credulous
from effects import deeds, listening, published, sent
from spoken import accepted, bid, declined, transport
from transports_rig import TransportsRig, contracted, watched

from dray.messages import Award, Role, TaskAnnounced, Withdrawn, Work
from dray.protocol.contract_net.auction_rules import AuctionRules
from dray.protocol.contract_net.changes import ContractChanged
from dray.protocol.contract_net.coordinator import CLOSED_KEPT, Coordinator
from dray.protocol.contract_net.terms import Place
from dray.protocol.runtime.events import NEVER_S
from dray.protocol.runtime.life import Life

# --- the primary ---------------------------------------------------------------------------------


def test_a_task_that_is_opened_is_announced_with_epoch_1() -> None:
    rig = TransportsRig()
    task = rig.open()
    [announced] = published(rig.out, TaskAnnounced)
    assert (announced.task, announced.epoch, announced.role) == ("T1", 1, Role.PRIMARY)
    assert (task.primary, task.secondary, task.round) == ("", "", 1)
    assert [each.id for each in rig.transports] == ["T1"]


def test_who_accepts_becomes_the_primary_with_its_promise_and_its_source() -> None:
    rig = contracted()
    assert rig.task.primary == "ATV2"
    assert rig.task.contract.promised_s == 100.0
    assert rig.task.contract.source == "S3"
    assert rig.contracted == ["T1"]


def test_accepting_twice_contracts_once() -> None:
    rig = contracted()
    said = len(deeds(rig.out))
    rig.accepts("ATV2")
    assert rig.contracted == ["T1"]
    assert len(deeds(rig.out)) == said


def test_a_second_one_who_accepts_late_is_released_and_takes_nothing() -> None:
    rig = contracted()
    rig.accepts("ATV4")
    assert rig.task.primary == "ATV2"
    assert rig.released() == [("ATV4", Role.PRIMARY)]


def test_an_answer_for_an_unknown_task_is_released() -> None:
    rig = TransportsRig()
    rig.accepts("ATV1", task="T9")
    assert rig.released() == [("ATV1", Role.PRIMARY)]


@pytest.mark.parametrize("epoch", [0, 2])
def test_answers_and_bids_of_another_epoch_do_not_count(epoch: int) -> None:
    rig = TransportsRig()
    rig.open()
    rig.bids(ATV1=55.9, epoch=epoch)
    rig.run(1.0)
    assert rig.asked(Role.PRIMARY) == []
    rig.bids(ATV2=54.8)
    rig.run(5.0)
    assert rig.asked(Role.PRIMARY)
    rig.accepts("ATV2", epoch=epoch)
    assert rig.task.primary == ""
    assert rig.released()[-1] == ("ATV2", Role.PRIMARY)


def test_tasks_are_auctioned_side_by_side() -> None:
    rig = TransportsRig()
    rig.open("T1")
    rig.open("T2")
    rig.bids("T1", ATV1=50.0)
    rig.bids("T2", ATV2=50.0)
    rig.run(1.0)
    rig.accepts("ATV2", task="T2")
    rig.accepts("ATV1", task="T1")
    assert [task.primary for task in rig.transports] == ["ATV1", "ATV2"]


def test_a_task_for_which_nobody_bids_stays_announced() -> None:
    rig = TransportsRig()
    rig.open()
    rig.run(3600.0)
    assert rig.transports.get("T1") is not None
    assert rig.task.round > 3600 / (AuctionRules().rest_aged_max_s + AuctionRules().window_max_s)
    assert rig.life.timers.next_s < NEVER_S


# --- the end -------------------------------------------------------------------------------------


def test_a_withdrawn_task_is_withdrawn_from_its_carrier_too() -> None:
    rig = watched()
    rig.transports.close(rig.task, "withdrawn")
    [message] = sent(rig.out, Withdrawn, to="ATV2")
    assert (message.task, message.epoch) == ("T1", 1)
    assert rig.released() == [("ATV1", Role.SECONDARY)]


def test_a_task_that_is_withdrawn_during_its_auction_releases_who_was_asked() -> None:
    rig = TransportsRig()
    task = rig.open()
    rig.bids(ATV1=50.0)
    rig.run(1.0)
    rig.transports.close(task, "withdrawn")
    assert rig.released() == [("ATV1", Role.PRIMARY)]
    assert rig.life.timers.next_s == NEVER_S
    rig.accepts("ATV1")
    assert rig.released()[-1] == ("ATV1", Role.PRIMARY)


def test_the_carrier_of_a_closed_task_is_remembered_within_a_bound() -> None:
    rig = contracted()
    rig.transports.close(rig.task, "delivered")
    closed = rig.transports.closed("T1")
    assert closed is not None
    assert (closed.carrier, closed.epoch, closed.outcome) == ("ATV2", 1, "delivered")
    for number in range(CLOSED_KEPT):
        rig.transports.close(rig.open(f"X{number}"), "withdrawn")
    assert rig.transports.closed("T1") is None


def test_what_is_heard_of_a_closed_task_opens_nothing() -> None:
    rig = watched()
    rig.transports.close(rig.task, "delivered")
    said = len(deeds(rig.out))
    rig.bids(ATV4=1.0)
    rig.declines("ATV4")
    rig.resigns("ATV1")
    rig.transports.alarms["primary auction"]("T1", 500.0)
    assert len(deeds(rig.out)) == said


# --- a coordinator that watches nobody -----------------------------------------------------------


class OfGoals(Coordinator):
    """Asks the machines that make a product."""

    def _audience(self, _work: Work, _radius_m: float) -> tuple[str, ...]:
        return ("plant/goals/P1",)


def test_where_contractors_are_not_watched_no_secondary_is_sought_and_nobody_is_suspected() -> None:
    life = Life()
    nowhere = Place(x_m=0.0, y_m=0.0, reach_m=0.0)
    coordinator = OfGoals("strategist", nowhere, AuctionRules(), life, Credulous())
    coordinator.open("T1", transport(), 300.0, 0.0)
    coordinator.on_bid("ATV2", bid(54.8), 0.5)
    coordinator.on_bid("ATV1", bid(55.9), 0.5)
    coordinator.alarms["primary auction"]("T1", life.timers.next_s)
    coordinator.on_bid("ATV4", bid(60.0, role=Role.SECONDARY), 1.5)
    coordinator.on_accepted("ATV2", accepted(), 2.0)
    coordinator.on_accepted("ATV1", accepted(role=Role.SECONDARY), 2.0)
    coordinator.on_declined("ATV1", declined(role=Role.SECONDARY), 2.0)
    assert [change.task.id for change in life.changes if isinstance(change, ContractChanged)] == ["T1"]
    assert [award.role for award in sent(life.effects, Award)] == [Role.PRIMARY]
    assert listening(life.effects) == set()
    assert life.timers.next_s == NEVER_S
