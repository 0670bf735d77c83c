"""Whatever bidders do, an auction keeps its promises (invariants 1 and 3 of the protocol).

The model stands for the bidders: who was asked and has neither answered nor been released, and who
believes to be bound. An answer may be late, be said twice, or be lost; it carries the number of its award,
so an answer that is still under way when its sender is asked anew does not count.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

import pytest
from credulous import Credulous
from effects import facts
from hypothesis import given
from hypothesis import strategies as st
from spoken import accepted, bid, declined, transport

from dray.messages import Award, Release, Role
from dray.messages.fact import AwardGiven
from dray.protocol.contract_net.auction import STAGES, Auction, Stage
from dray.protocol.contract_net.auction_rules import AuctionRules
from dray.protocol.contract_net.terms import Place, Terms
from dray.protocol.runtime.events import NEVER_S, Send
from dray.protocol.runtime.life import Life
from dray.states import States

BIDDERS = ("ATV1", "ATV2", "ATV3", "ATV4")
WILLING = "ATV9"

Step = tuple[Literal["bid", "accept", "decline", "late", "arrive", "repeat", "early", "wait"], str, float]

STEPS = st.lists(
    st.tuples(
        st.sampled_from(["bid", "accept", "decline", "late", "arrive", "repeat", "early", "wait"]),
        st.sampled_from(BIDDERS),
        st.floats(min_value=0.0, max_value=100.0),
    ),
    max_size=60,
)

RULES = st.builds(
    AuctionRules,
    window_s=st.floats(min_value=0.1, max_value=5.0),
    window_growth=st.floats(min_value=1.0, max_value=3.0),
    answer_s=st.floats(min_value=0.1, max_value=5.0),
    radius_m=st.floats(min_value=1.0, max_value=100.0),
    radius_growth=st.floats(min_value=1.5, max_value=3.0),
    rest_s=st.floats(min_value=0.1, max_value=5.0),
    rest_growth=st.floats(min_value=1.0, max_value=3.0),
)


CANDIDATES = st.lists(
    st.tuples(st.sampled_from(BIDDERS), st.floats(min_value=0.0, max_value=100.0)),
    max_size=3,
    unique_by=lambda each: each[0],
)
"""Who was left when another auction had found its winner; they are asked before anything is announced."""


class Hall:
    """An auction, its bidders, and what must never be seen."""

    def __init__(self, rules: AuctionRules, candidates: list[tuple[str, float]] | None = None) -> None:
        self.life = Life()
        self.out = self.life.effects
        self.seen = 0
        self.now_s = 0.0
        self.asked = ""
        self.awards: dict[str, int] = {}
        """The number of the newest award to each bidder."""
        self.bound: dict[str, int] = {}
        """Who believes to be bound, and by which award."""
        self.under_way: dict[str, list[int]] = {bidder: [] for bidder in (*BIDDERS, WILLING)}
        """By bidder: the awards of which its acceptance has not arrived yet, oldest first."""
        self.winner = ""
        left_over = tuple((bidder, bid(cost_s)) for bidder, cost_s in candidates or [])
        terms = Terms(task="T1", epoch=1, role=Role.PRIMARY, work=transport(), deadline_s=300.0)
        place = Place(x_m=30.0, y_m=20.0, reach_m=72.0)
        self.auction = Auction(
            "M8", terms, place, lambda _radius_m: ("k",), rules, self.life, Credulous(), left_over
        )
        self.auction.open(0.0)
        self.check()

    def step(self, kind: str, bidder: str, amount: float) -> None:
        auction = self.auction
        if kind == "bid":
            auction.on_bid(bidder, bid(amount, round=auction.round), self.now_s)
        elif kind == "wait":
            self.wait()
        elif kind == "early":
            self.now_s = min(self.now_s + amount / 100.0, max(self.now_s, auction.wake_at_s))
            auction.wake(self.now_s)
        elif kind == "arrive" and self.under_way[bidder]:
            self.says_accepted(bidder, self.under_way[bidder].pop(0))
        elif kind == "repeat" and bidder in self.bound:
            self.says_accepted(bidder, self.bound[bidder])
        elif bidder == self.asked and self.bound.get(bidder) != self.awards[bidder]:
            self.answer(kind, bidder)
        self.check()

    def answer(self, kind: str, bidder: str) -> None:
        number = self.awards[bidder]
        if kind == "accept":
            self.bound[bidder] = number
            self.says_accepted(bidder, number)
        elif kind == "late":
            self.bound[bidder] = number
            self.under_way[bidder].append(number)
        elif kind == "decline":
            self.asked = ""
            self.auction.on_declined(bidder, declined(number=number), self.now_s)

    def says_accepted(self, bidder: str, number: int) -> None:
        if self.asked == bidder and self.awards[bidder] == number:
            self.asked = ""
        self.auction.on_accepted(bidder, accepted(number=number))

    def wait(self) -> None:
        if self.auction.wake_at_s < NEVER_S:
            self.now_s = max(self.now_s, self.auction.wake_at_s)
            self.auction.wake(self.now_s)

    def check(self) -> None:
        self.read()
        auction = self.auction
        if self.winner:
            assert auction.winner == self.winner, "a second winner"
        self.winner = auction.winner
        if auction.stage is Stage.DECIDED:
            assert auction.winner
            assert auction.wake_at_s == NEVER_S
            assert not self.asked
        else:
            assert not auction.winner
            assert auction.wake_at_s < NEVER_S, "nothing would ever happen again"
            assert (auction.stage is Stage.ASKING) is bool(self.asked)

    def read(self) -> None:
        for effect in self.life.effects[self.seen :]:
            if not isinstance(effect, Send):
                continue
            if isinstance(effect.message, Award):
                assert not self.asked, "two are asked at once"
                self.asked = effect.to
                self.awards[effect.to] = effect.message.number
            elif isinstance(effect.message, Release):
                self.bound.pop(effect.to, None)
                if self.asked == effect.to:
                    self.asked = ""
        self.seen = len(self.life.effects)

    def all_arrive(self) -> None:
        for bidder, numbers in self.under_way.items():
            while numbers:
                self.step("arrive", bidder, 0.0)

    def finish(self) -> None:
        """One willing bidder comes, and everything that is under way arrives."""
        self.all_arrive()
        for _ in range(100):
            if self.auction.stage is Stage.DECIDED:
                break
            self.step("bid", WILLING, 1.0)
            self.step("accept", WILLING, 0.0)
            self.step("wait", "", 0.0)
            self.step("accept", WILLING, 0.0)
        self.all_arrive()


@given(rules=RULES, candidates=CANDIDATES, steps=STEPS)
def test_one_is_asked_at_a_time_one_wins_and_the_auction_never_falls_asleep(
    rules: AuctionRules, candidates: list[tuple[str, float]], steps: list[Step]
) -> None:
    hall = Hall(rules, candidates)
    for step in steps:
        hall.step(*step)


@given(rules=RULES, candidates=CANDIDATES, steps=STEPS)
def test_a_willing_bidder_always_ends_it_and_nobody_but_the_winner_stays_bound(
    rules: AuctionRules, candidates: list[tuple[str, float]], steps: list[Step]
) -> None:
    hall = Hall(rules, candidates)
    for step in steps:
        hall.step(*step)
    hall.finish()
    assert hall.auction.stage is Stage.DECIDED
    assert set(hall.bound) == {hall.auction.winner}


@given(rules=RULES, candidates=CANDIDATES, steps=STEPS)
def test_an_auction_that_nobody_answers_goes_on_without_spinning(
    rules: AuctionRules, candidates: list[tuple[str, float]], steps: list[Step]
) -> None:
    hall = Hall(rules, candidates)
    for step in steps:
        hall.step(*step)
    if hall.auction.stage is Stage.DECIDED:
        return
    for _ in range(20):
        before_s, before = hall.now_s, len(hall.out)
        # The rest may be nothing once; then a window must pass.
        hall.step("wait", "", 0.0)
        hall.step("wait", "", 0.0)
        assert hall.now_s > before_s
        assert len(hall.out) - before < 20


@given(
    costs_s=st.dictionaries(
        st.sampled_from([f"ATV{number}" for number in range(20)]),
        st.tuples(st.sampled_from([40.0, 50.0, 60.0]), st.sampled_from([100.0, 110.0])),
        min_size=1,
    ),
    data=st.data(),
)
def test_bidders_are_asked_by_price_then_finish_then_name_however_their_bids_arrived(
    costs_s: dict[str, tuple[float, float]], data: st.DataObject
) -> None:
    hall = Hall(AuctionRules())
    for bidder in data.draw(st.permutations(sorted(costs_s))):
        cost_s, finish_s = costs_s[bidder]
        hall.auction.on_bid(bidder, bid(cost_s, finish_s=finish_s), 0.5)
    hall.wait()
    for _ in costs_s:
        hall.read()
        asked, hall.asked = hall.asked, ""
        hall.auction.on_declined(asked, declined(number=hall.awards[asked]), hall.now_s)
    order = [fact.bidder for fact in facts(hall.out, AwardGiven)]
    assert order == sorted(costs_s, key=lambda each: (*costs_s[each], each))


# --- the table of its stages ----------------------------------------------------------------------


class Walk:
    """An auction at one point of its way, and the changes of its stage so far."""

    def __init__(self, candidates: int, monkey: pytest.MonkeyPatch) -> None:
        self.seen: set[tuple[Stage, Stage]] = set()
        enter = States.enter

        def note(states: States[Stage], stage: Stage) -> None:
            before = states.now
            enter(states, stage)
            self.seen.add((before, stage))

        monkey.setattr(States, "enter", note)
        offers = tuple((bidder, bid(10.0)) for bidder in BIDDERS[:candidates])
        terms = Terms(task="T1", epoch=1, role=Role.PRIMARY, work=transport(), deadline_s=300.0)
        place, self.now_s = Place(x_m=30.0, y_m=20.0, reach_m=20.0), 0.0
        self.auction = Auction(
            "M8", terms, place, lambda _radius_m: ("k",), AuctionRules(), Life(), Credulous(), offers
        )

    def opens(self) -> None:
        if self.auction.stage is Stage.PREPARED:
            self.auction.open(self.now_s)

    def opens_later(self) -> None:
        if self.auction.stage is Stage.PREPARED:
            self.auction.open_later(self.now_s + 10.0)

    def stands_behind(self) -> None:
        if self.auction.stage is Stage.PREPARED or self.auction.is_due(self.auction.wake_at_s):
            self.auction.stand_behind(self.now_s)

    def somebody_bids(self) -> None:
        if self.auction.stage is not Stage.PREPARED:
            self.auction.on_bid(WILLING, bid(20.0, round=self.auction.round), self.now_s)

    def time_passes(self) -> None:
        if self.auction.wake_at_s < NEVER_S:
            self.now_s = max(self.now_s, self.auction.wake_at_s)
            self.auction.wake(self.now_s)

    def bidder_accepts(self) -> None:
        self.auction.on_accepted(self.auction.asked or WILLING, accepted(number=self.auction.number))

    def bidder_declines(self) -> None:
        asked = self.auction.asked or WILLING
        self.auction.on_declined(asked, declined(number=self.auction.number), self.now_s)

    def is_cancelled(self) -> None:
        self.auction.cancel()


HAPPENINGS: tuple[Callable[[Walk], None], ...] = (
    Walk.opens,
    Walk.opens_later,
    Walk.stands_behind,
    Walk.somebody_bids,
    Walk.time_passes,
    Walk.bidder_accepts,
    Walk.bidder_declines,
    Walk.is_cancelled,
)


def test_no_walk_leaves_the_table_of_stages_and_none_of_it_is_out_of_reach() -> None:
    seen: set[tuple[Stage, Stage]] = set()
    for candidates in (0, 2):
        paths: list[tuple[Callable[[Walk], None], ...]] = [()]
        known = set()
        for path in paths:
            with pytest.MonkeyPatch.context() as patch:
                walk = Walk(candidates, patch)
                for happening in path:
                    happening(walk)
            seen |= walk.seen
            auction = walk.auction
            key = (auction.stage, auction.asked, auction.winner, min(auction.round, 2), auction.waits)
            if key not in known:
                known.add(key)
                paths += [(*path, happening) for happening in HAPPENINGS]
    table = {(stage, after) for stage, row in STAGES.items() for after in row}
    assert seen == table, f"never seen: {sorted(table - seen)}"
