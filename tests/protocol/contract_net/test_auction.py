"""One round of an auction, from the announcement until somebody has accepted (paper, Figure 3)."""

from __future__ import annotations

import pytest
from effects import deeds, facts, published, sent
from hall import RULES, Hall
from msgspec import UNSET, UnsetType
from msgspec.structs import replace
from spoken import accepted, bid, declined

from dray.messages import Award, Refusal, Release, Role, TaskAnnounced
from dray.messages.fact import AwardGiven, BidReceived, TaskOpened
from dray.protocol.contract_net.auction import Stage
from dray.protocol.runtime.events import NEVER_S, Publish

# --- announcing -------------------------------------------------------------------------------------


def test_an_auction_opens_with_an_announcement_to_all_cells_within_the_radius() -> None:
    hall = Hall()
    keys = [effect.key for effect in hall.out if isinstance(effect, Publish)]
    assert keys == ["plant/task/0_0", "plant/task/1_0"]
    [announced] = published(hall.out, TaskAnnounced)
    assert announced.task == "T1"
    assert announced.round == 1
    assert announced.coordinator == "M8"
    assert (announced.x_m, announced.y_m, announced.radius_m) == (30.0, 15.0, RULES.radius_m)
    assert announced.bids_until_s == RULES.window_s == hall.auction.wake_at_s
    assert announced.deadline_s == 300.0


def test_the_announcement_is_recorded_before_anybody_hears_it() -> None:
    hall = Hall()
    [opened] = facts(hall.out[:1], TaskOpened)
    assert opened.round == 1
    assert opened.bids_until_s == RULES.window_s


def test_nobody_is_asked_before_the_window_closes() -> None:
    hall = Hall()
    hall.bids(ATV1=50.0)
    hall.auction.wake(RULES.window_s - 0.001)
    assert hall.asked == []
    assert hall.auction.stage is Stage.COLLECTING


# --- ranking ----------------------------------------------------------------------------------------


def test_the_cheapest_bidder_is_asked_when_the_window_closes() -> None:
    hall = Hall()
    hall.bids(ATV1=55.9, ATV2=54.8, ATV3=51.0)
    hall.wait()
    assert hall.asked == ["ATV3"]
    [award] = sent(hall.out, Award, to="ATV3")
    assert award.role is Role.PRIMARY
    assert award.source == "S3"


@pytest.mark.parametrize("reckoned", [True, UNSET])
def test_that_the_level_of_a_battery_is_reckoned_is_recorded_with_its_bid(reckoned: bool | UnsetType) -> None:
    hall = Hall()
    hall.auction.on_bid("ATV1", replace(bid(50.0), battery_reckoned=reckoned), 0.1)
    assert [fact.battery_reckoned for fact in facts(hall.out, BidReceived)] == [reckoned]


def test_of_two_with_one_price_the_one_that_is_done_earlier_is_asked() -> None:
    hall = Hall()
    hall.auction.on_bid("ATV1", bid(50.0, finish_s=90.0), 0.1)
    hall.auction.on_bid("ATV2", bid(50.0, finish_s=80.0), 0.2)
    hall.wait()
    assert hall.asked == ["ATV2"]


def test_of_two_equal_bids_the_smaller_id_is_asked_whoever_spoke_first() -> None:
    for order in (("ATV1", "ATV2"), ("ATV2", "ATV1")):
        hall = Hall()
        for bidder in order:
            hall.auction.on_bid(bidder, bid(50.0), 0.1)
        hall.wait()
        assert hall.asked == ["ATV1"]


def test_a_bid_of_a_later_round_replaces_the_first_of_the_same_bidder() -> None:
    hall = Hall()
    hall.bids(ATV1=50.0)
    hall.wait()
    hall.declines("ATV1")
    hall.wait()
    hall.bids(ATV1=70.0, ATV2=60.0)
    hall.wait()
    assert hall.asked == ["ATV1", "ATV2"]


def test_of_two_bids_in_one_round_the_first_counts_and_the_history_has_one() -> None:
    hall = Hall()
    hall.bids(ATV1=50.0, ATV2=60.0)
    hall.bids(ATV1=70.0)
    hall.wait()
    assert hall.asked == ["ATV1"]
    assert [fact.bidder for fact in facts(hall.out, BidReceived)] == ["ATV1", "ATV2"]


def test_a_bid_that_arrives_twice_is_asked_once() -> None:
    hall = Hall()
    hall.bids(ATV1=50.0)
    hall.bids(ATV1=50.0)
    hall.wait()
    hall.declines("ATV1")
    assert hall.asked == ["ATV1"]


def test_every_bid_is_recorded_with_the_parts_of_its_price() -> None:
    hall = Hall()
    hall.bids(ATV1=50.0)
    [received] = facts(hall.out, BidReceived)
    assert received.bidder == "ATV1"
    assert received.total_s == received.cost.total_s == 50.0


# --- asking -----------------------------------------------------------------------------------------


def test_who_accepts_is_the_winner_and_the_others_are_left_over_cheapest_first() -> None:
    hall = Hall()
    hall.bids(ATV1=55.9, ATV2=54.8, ATV3=51.0)
    hall.wait()
    hall.accepts("ATV3")
    assert hall.auction.stage is Stage.DECIDED
    assert hall.auction.winner == "ATV3"
    assert [bidder for bidder, _ in hall.auction.left_over] == ["ATV2", "ATV1"]
    assert hall.auction.wake_at_s == NEVER_S
    assert hall.answers == ["accepted"]
    assert hall.released() == []


def test_when_one_declines_the_next_is_asked_and_the_reason_is_kept() -> None:
    hall = Hall()
    hall.bids(ATV1=55.9, ATV2=54.8)
    hall.wait()
    hall.declines("ATV2", Refusal.BATTERY)
    assert hall.asked == ["ATV2", "ATV1"]
    assert hall.answers == ["battery"]
    assert hall.released() == []
    assert [fact.rank for fact in facts(hall.out, AwardGiven)] == [1, 2]


def test_a_silent_bidder_is_released_before_the_next_one_is_asked() -> None:
    hall = Hall()
    hall.bids(ATV1=55.9, ATV2=54.8)
    hall.wait()
    hall.wait()
    assert hall.now_s == RULES.window_s + RULES.answer_s
    assert hall.answers == ["silent"]
    said = [effect.to for effect in hall.out if sent([effect], Award) or sent([effect], Release)]
    assert said == ["ATV2", "ATV2", "ATV1"]
    assert hall.released() == ["ATV2"]


def test_an_acceptance_that_comes_too_late_is_released() -> None:
    hall = Hall()
    hall.bids(ATV1=55.9, ATV2=54.8)
    hall.wait()
    hall.wait()
    hall.accepts("ATV2")
    assert hall.auction.winner == ""
    assert hall.released() == ["ATV2", "ATV2"]
    hall.accepts("ATV1")
    assert hall.auction.winner == "ATV1"


def test_a_late_acceptance_after_the_decision_is_released_and_changes_nothing() -> None:
    hall = Hall()
    hall.bids(ATV1=55.9, ATV2=54.8)
    hall.wait()
    hall.wait()
    hall.accepts("ATV1")
    hall.accepts("ATV2")
    assert hall.auction.winner == "ATV1"
    assert hall.released() == ["ATV2", "ATV2"]


def test_awards_are_numbered_and_an_answer_to_an_earlier_one_does_not_count() -> None:
    hall = Hall()
    hall.bids(ATV1=55.9)
    hall.wait()
    hall.wait()
    hall.wait()
    hall.bids(ATV1=55.9)
    hall.wait()
    assert [award.number for award in sent(hall.out, Award, to="ATV1")] == [1, 2]
    said = len(deeds(hall.out))
    hall.auction.on_accepted("ATV1", accepted(number=1))
    hall.auction.on_declined("ATV1", declined(number=1), hall.now_s)
    assert len(deeds(hall.out)) == said
    assert (hall.auction.stage, hall.auction.winner) == (Stage.ASKING, "")
    hall.accepts("ATV1")
    assert hall.auction.winner == "ATV1"


def test_a_late_acceptance_of_one_who_has_declined_since_is_not_a_contract() -> None:
    hall = Hall()
    hall.bids(ATV1=55.9)
    hall.wait()
    hall.wait()
    hall.wait()
    hall.bids(ATV1=55.9)
    hall.wait()
    hall.auction.on_accepted("ATV1", accepted(number=1))
    hall.declines("ATV1")
    assert hall.auction.winner == ""
    assert hall.answers == ["silent", "busy"]


def test_an_acceptance_from_somebody_who_was_never_asked_is_released() -> None:
    hall = Hall()
    hall.bids(ATV1=55.9)
    hall.accepts("ATV1")
    assert hall.auction.stage is Stage.COLLECTING
    assert hall.released() == ["ATV1"]


def test_accepting_twice_is_harmless() -> None:
    hall = Hall()
    hall.bids(ATV1=55.9)
    hall.wait()
    hall.accepts("ATV1")
    said = len(deeds(hall.out))
    hall.accepts("ATV1")
    assert len(deeds(hall.out)) == said
    assert hall.auction.winner == "ATV1"


def test_a_decline_from_somebody_who_is_not_asked_is_ignored() -> None:
    hall = Hall()
    hall.bids(ATV1=55.9, ATV2=54.8)
    hall.wait()
    hall.declines("ATV1")
    assert hall.asked == ["ATV2"]
    hall.declines("ATV2")
    hall.declines("ATV2")
    assert hall.asked == ["ATV2", "ATV1"]


def test_being_woken_too_early_or_after_the_end_is_harmless() -> None:
    hall = Hall()
    hall.bids(ATV1=55.9)
    hall.auction.wake(0.5)
    hall.wait()
    hall.auction.wake(hall.now_s + 0.5)
    assert hall.asked == ["ATV1"]
    hall.accepts("ATV1")
    said = len(deeds(hall.out))
    hall.auction.wake(1e6)
    assert len(deeds(hall.out)) == said


def test_a_cancelled_auction_releases_whom_it_had_asked() -> None:
    hall = Hall()
    hall.bids(ATV1=55.9)
    hall.wait()
    hall.auction.cancel()
    assert hall.released() == ["ATV1"]
    assert hall.auction.wake_at_s == NEVER_S
    hall.accepts("ATV1")
    assert hall.auction.winner == ""
    assert hall.released() == ["ATV1", "ATV1"]


def test_a_bid_after_the_decision_is_ignored() -> None:
    hall = Hall()
    hall.bids(ATV1=55.9)
    hall.wait()
    hall.accepts("ATV1")
    said = len(deeds(hall.out))
    hall.bids(ATV2=1.0)
    assert len(deeds(hall.out)) == said
