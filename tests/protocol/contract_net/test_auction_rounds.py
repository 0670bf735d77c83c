"""What follows when a round finds nobody, and who else is sought: a secondary, behind what is more urgent."""

from __future__ import annotations

from itertools import pairwise

import msgspec
import pytest
from effects import facts, published, sent
from hall import REACH_M, RULES, Hall
from spoken import bid

from dray.messages import Award, Release, Role, TaskAnnounced
from dray.messages.fact import RoundFailed, TaskOpened
from dray.protocol.contract_net.auction import BIDS_KEPT, Stage

# --- late bids --------------------------------------------------------------------------------------


def test_a_bid_that_comes_while_another_is_asked_counts_in_the_next_round() -> None:
    hall = Hall()
    hall.bids(ATV1=55.9)
    hall.wait()
    hall.bids(ATV2=99.0)
    hall.declines("ATV1")
    hall.wait_for_award()
    assert hall.asked == ["ATV1", "ATV2"]


def test_who_has_bid_while_another_was_asked_is_left_over_too() -> None:
    hall = Hall()
    hall.bids(ATV1=5.0, ATV3=8.0)
    hall.wait()
    hall.bids(ATV2=6.0)
    hall.accepts("ATV1")
    assert [bidder for bidder, _ in hall.auction.left_over] == ["ATV2", "ATV3"]


def test_a_bid_that_comes_after_its_window_is_asked_at_once() -> None:
    hall = Hall(reach_m=RULES.radius_m)
    hall.wait()
    assert hall.auction.stage is Stage.RESTING
    hall.bids(ATV1=55.9)
    assert hall.asked == ["ATV1"]
    hall.accepts("ATV1")
    assert hall.auction.winner == "ATV1"


def test_a_bid_of_an_earlier_round_counts() -> None:
    hall = Hall()
    for _ in range(6):
        hall.wait()
    hall.auction.on_bid("ATV1", bid(50.0, round=1), hall.now_s)
    while not hall.asked:
        hall.wait()
    assert hall.asked == ["ATV1"]


# --- rounds -----------------------------------------------------------------------------------------


def test_the_radius_grows_round_by_round_to_the_whole_plant() -> None:
    hall = Hall()
    while len(hall.radii_m) < 5:
        hall.wait()
    assert hall.radii_m == [25.0, 50.0, 80.0, 80.0, 80.0]
    assert [message.radius_m for message in published(hall.out, TaskAnnounced)] == hall.radii_m


def test_a_wider_circle_is_asked_without_a_rest() -> None:
    hall = Hall()
    hall.wait()
    [failed] = facts(hall.out, RoundFailed)
    assert failed.next_round_s == hall.now_s


def test_the_whole_plant_is_left_in_peace_between_rounds_longer_and_longer() -> None:
    hall = Hall(reach_m=RULES.radius_m)
    while len(facts(hall.out, RoundFailed)) < 12:
        hall.wait()
    closed_s = [fact.bids_until_s for fact in facts(hall.out, TaskOpened)]
    next_s = [fact.next_round_s for fact in facts(hall.out, RoundFailed)]
    rests_s = [opens_s - end_s for opens_s, end_s in zip(next_s, closed_s, strict=True)]
    assert rests_s[0] == RULES.rest_s
    assert rests_s == sorted(rests_s)
    assert rests_s[-1] == pytest.approx(RULES.rest_aged_max_s)


def test_windows_grow_to_a_limit() -> None:
    hall = Hall()
    while len(facts(hall.out, TaskOpened)) < 12:
        hall.wait()
    opened = published(hall.out, TaskAnnounced)
    starts_s = [0.0, *(fact.next_round_s for fact in facts(hall.out, RoundFailed))]
    windows_s = [message.bids_until_s - start_s for message, start_s in zip(opened, starts_s, strict=True)]
    assert windows_s[:2] == [1.0, 1.5]
    assert windows_s == sorted(windows_s)
    assert windows_s[-1] == pytest.approx(RULES.window_max_s)


def test_an_answer_is_waited_for_longer_where_the_window_is_longer() -> None:
    hall = Hall()
    while len(facts(hall.out, TaskOpened)) < 12:
        hall.wait()
    hall.bids(ATV1=50.0)
    hall.wait_for_award()
    assert hall.auction.wake_at_s - hall.now_s == pytest.approx(RULES.window_max_s)


def test_ten_thousand_rounds_neither_overflow_nor_spin() -> None:
    hall = Hall()
    while hall.auction.round < 10_000 or hall.auction.stage is not Stage.RESTING:
        hall.wait()
        hall.auction.wake(hall.now_s)
    least_s = RULES.window_max_s + RULES.rest_aged_max_s
    rounds = facts(hall.out, RoundFailed)
    assert rounds[-1].round == 10_000
    gaps_s = [b.next_round_s - a.next_round_s for a, b in pairwise(rounds[100:])]
    assert min(gaps_s) == pytest.approx(least_s)
    assert max(gaps_s) == pytest.approx(least_s)


def test_an_endless_auction_takes_the_first_bid_it_gets() -> None:
    hall = Hall()
    while hall.auction.round < 1000:
        hall.wait()
    hall.bids(ATV1=50.0)
    hall.wait_for_award()
    hall.accepts("ATV1")
    assert hall.auction.winner == "ATV1"


def test_a_deadline_that_nobody_could_keep_moves_with_the_rounds() -> None:
    hall = Hall(deadline_s=10.0)
    while len(facts(hall.out, TaskOpened)) < 10:
        hall.wait()
    announced = published(hall.out, TaskAnnounced)
    assert announced[0].deadline_s == 10.0
    deadlines_s = [message.deadline_s for message in announced]
    assert deadlines_s == sorted(deadlines_s)
    assert deadlines_s[-1] > hall.now_s + 90.0
    hall.bids(ATV1=50.0)
    hall.wait_for_award()
    assert sent(hall.out, Award)[-1].deadline_s == deadlines_s[-1]


def test_a_deadline_in_another_century_does_not_move() -> None:
    hall = Hall(deadline_s=1e10)
    while len(facts(hall.out, TaskOpened)) < 10:
        hall.wait()
    assert {message.deadline_s for message in published(hall.out, TaskAnnounced)} == {1e10}


def test_a_failed_round_says_how_many_had_bid() -> None:
    hall = Hall()
    hall.bids(ATV1=50.0, ATV2=60.0)
    hall.wait()
    hall.declines("ATV1")
    hall.declines("ATV2")
    [failed] = facts(hall.out, RoundFailed)
    assert failed.round == 1
    assert failed.bids == 2


# --- a secondary ------------------------------------------------------------------------------------


def test_a_secondary_is_sought_among_those_who_were_left_before_anything_is_announced() -> None:
    hall = Hall(role=Role.SECONDARY, candidates=(("ATV2", bid(54.8)), ("ATV1", bid(55.9))))
    assert published(hall.out, TaskAnnounced) == []
    [award] = sent(hall.out, Award, to="ATV2")
    assert award.role is Role.SECONDARY
    assert award.primary == "ATV9"
    hall.declines("ATV2")
    assert hall.asked == ["ATV2", "ATV1"]
    hall.accepts("ATV1")
    assert hall.auction.winner == "ATV1"


def test_when_all_who_were_left_decline_the_watch_is_announced() -> None:
    hall = Hall(role=Role.SECONDARY, candidates=(("ATV2", bid(54.8)),))
    hall.declines("ATV2")
    hall.wait()
    [announced] = published(hall.out, TaskAnnounced)
    assert announced.role is Role.SECONDARY
    assert announced.primary == "ATV9"
    assert announced.round == 1


def test_the_epoch_is_in_everything_that_is_said() -> None:
    hall = Hall(epoch=7)
    hall.bids(ATV1=50.0)
    hall.wait()
    hall.wait()
    said = [
        *published(hall.out, TaskAnnounced),
        *sent(hall.out, Award),
        *sent(hall.out, Release),
    ]
    assert {type(message) for message in said} == {TaskAnnounced, Award, Release}
    assert {msgspec.structs.asdict(message)["epoch"] for message in said} == {7}


def test_bids_under_ever_new_names_are_not_kept_without_bound() -> None:
    hall = Hall()
    for number in range(2 * BIDS_KEPT):
        hall.auction.on_bid(f"X{number}", bid(50.0), hall.now_s)
    hall.wait()
    hall.accepts(f"X{BIDS_KEPT}")
    assert len(hall.auction.left_over) < BIDS_KEPT


def test_one_that_bids_and_declines_keeps_no_deadline_that_nobody_else_can_meet() -> None:
    hall = Hall(deadline_s=60.0)
    first_s = hall.auction.terms.deadline_s
    for _ in range(4):
        hall.bids(LIAR=20.0)
        hall.wait_for_award()
        hall.declines("LIAR")
        hall.wait()
    assert hall.auction.terms.deadline_s > first_s + 60.0


# --- standing behind what is more urgent ------------------------------------------------------------


def test_what_has_stood_behind_is_announced_with_a_deadline_that_can_still_be_kept() -> None:
    hall = Hall(deadline_s=100.0, opened=False)
    hall.auction.stand_behind(hall.now_s)
    hall.wait()
    assert hall.now_s > 100.0
    assert published(hall.out, TaskAnnounced)[-1].deadline_s >= hall.now_s + 100.0


def test_what_stands_behind_waits_and_was_not_sought_in_vain_itself() -> None:
    hall = Hall(opened=False)
    hall.auction.stand_behind(hall.now_s)
    assert (hall.auction.waits, hall.auction.was_in_vain) == (True, False)
    hall.wait()
    while hall.auction.stage is not Stage.RESTING or hall.auction.radius_m < REACH_M:
        hall.wait()
    assert (hall.auction.waits, hall.auction.was_in_vain) == (True, True)
