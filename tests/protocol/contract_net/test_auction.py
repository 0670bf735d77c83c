"""One auction, from the announcement until somebody has accepted (paper, Figure 3)."""

from __future__ import annotations

from itertools import pairwise

import msgspec
import pytest
from kit import Credulous, accepted, award_number, bid, declined, deeds, facts, published, sent, transport

from dray.messages import Award, Bid, Refusal, Release, Role, TaskAnnounced
from dray.messages.fact import AwardAnswered, AwardGiven, BidReceived, RoundFailed, TaskOpened
from dray.protocol.contract_net.auction import Auction, Stage
from dray.protocol.contract_net.auction_rules import AuctionRules
from dray.protocol.contract_net.bids import BIDS_KEPT
from dray.protocol.contract_net.terms import Place, Terms
from dray.protocol.runtime.events import NEVER_S, Effect, Publish

RULES = AuctionRules()
REACH_M = 80.0


class Hall:
    """An auction and the time in its room."""

    def __init__(
        self,
        *,
        deadline_s: float = 300.0,
        role: Role = Role.PRIMARY,
        epoch: int = 1,
        rules: AuctionRules = RULES,
        reach_m: float = REACH_M,
        candidates: tuple[tuple[str, Bid], ...] = (),
    ) -> None:
        self.out: list[Effect] = []
        self.radii_m: list[float] = []
        self.now_s = 0.0
        terms = Terms(
            task="T1",
            epoch=epoch,
            role=role,
            work=transport(),
            deadline_s=deadline_s,
            primary="ATV9" if role is Role.SECONDARY else "",
        )
        place = Place(x_m=30.0, y_m=15.0, reach_m=reach_m)
        self.auction = Auction("M8", terms, place, self._audience, rules, self.out, Credulous(), candidates)
        self.auction.open(0.0)

    def _audience(self, radius_m: float) -> tuple[str, ...]:
        self.radii_m.append(radius_m)
        return ("plant/task/0_0", "plant/task/1_0")

    def bids(self, **costs_s: float) -> None:
        for bidder, cost_s in costs_s.items():
            self.auction.on_bid(bidder, bid(cost_s, round=self.auction.round), self.now_s)

    def accepts(self, bidder: str) -> None:
        """It answers the newest award that it was sent."""
        role = self.auction.terms.role
        answer = accepted(role=role, number=award_number(self.out, bidder, role=role))
        self.auction.on_accepted(bidder, answer)

    def declines(self, bidder: str, reason: Refusal = Refusal.BUSY) -> None:
        role = self.auction.terms.role
        answer = declined(role=role, reason=reason, number=award_number(self.out, bidder, role=role))
        self.auction.on_declined(bidder, answer, self.now_s)

    def wait(self) -> None:
        """Until the auction wants to be woken."""
        assert self.auction.wake_at_s < NEVER_S
        self.now_s = max(self.now_s, self.auction.wake_at_s)
        self.auction.wake(self.now_s)

    def wait_for_award(self) -> None:
        """Until somebody is asked."""
        count = len(self.asked)
        while len(self.asked) == count:
            self.wait()

    @property
    def asked(self) -> list[str]:
        """Everybody who was asked, in order."""
        return [fact.bidder for fact in facts(self.out, AwardGiven)]

    @property
    def answers(self) -> list[str]:
        return [fact.answer for fact in facts(self.out, AwardAnswered)]

    def released(self) -> list[str]:
        return [effect.to for effect in self.out if sent([effect], Release)]


# --- announcing ----------------------------------------------------------------------------------


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


# --- ranking -------------------------------------------------------------------------------------


def test_the_cheapest_bidder_is_asked_when_the_window_closes() -> None:
    hall = Hall()
    hall.bids(ATV1=55.9, ATV2=54.8, ATV3=51.0)
    hall.wait()
    assert hall.asked == ["ATV3"]
    [award] = sent(hall.out, Award, to="ATV3")
    assert award.role is Role.PRIMARY
    assert award.source == "S3"


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


# --- asking --------------------------------------------------------------------------------------


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


# --- late bids -----------------------------------------------------------------------------------


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


# --- rounds --------------------------------------------------------------------------------------


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


# --- a secondary ---------------------------------------------------------------------------------


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


# --- standing behind what is more urgent -----------------------------------------------------------


def test_what_has_stood_behind_is_announced_with_a_deadline_that_can_still_be_kept() -> None:
    hall = Hall(deadline_s=100.0)
    hall.auction.stand_behind(hall.now_s)
    hall.wait()
    assert hall.now_s > 100.0
    assert published(hall.out, TaskAnnounced)[-1].deadline_s >= hall.now_s + 100.0


def test_what_stands_behind_waits_and_was_not_sought_in_vain_itself() -> None:
    hall = Hall()
    hall.auction.stand_behind(hall.now_s)
    assert (hall.auction.waits, hall.auction.was_in_vain) == (True, False)
    hall.wait()
    while hall.auction.stage is not Stage.RESTING or hall.auction.radius_m < REACH_M:
        hall.wait()
    assert (hall.auction.waits, hall.auction.was_in_vain) == (True, True)
