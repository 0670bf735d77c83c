"""The coordinator's side of the Contract Net: announce, collect, rank, award, confirm (paper, Figure 3).

The rules
---------
1. A round begins with an announcement and collects bids until its window closes.
2. An implausible bid is ignored. What the coordinator knows of a bidder is added to its bid (`assessment`). The
   cheapest bidder is awarded first, point to point. It accepts, declines with a reason, or is silent for
   `answer_s`. A silent bidder is released, so that no vehicle stays bound by an award that expired. Then the next
   cheapest is asked.
3. When no bidder is left, the radius grows and the next round begins. At full radius the rounds continue, with a
   rest between them that grows to a limit. An auction never gives up by itself: its task is delivered, withdrawn,
   or still announced (invariant 1).
4. A bid counts in any round it arrives in: on a bad link it may come late (paper, case 3). Windows
   grow from round to round for the same reason.

An auction for a SECONDARY first asks the bidders that were not asked when the primary was found. It announces
nothing before that. [docs/states.md](docs/states.md) draws the stages (`STAGES`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from enum import StrEnum
from itertools import count

import msgspec

from dray.messages import (
    Accepted,
    Award,
    Bid,
    Declined,
    Reason,
    Refusal,
    Release,
    TaskAnnounced,
    Transport,
    Wait,
    Work,
)
from dray.messages.fact import Answer, AwardAnswered, AwardGiven, BidReceived, RoundFailed, TaskOpened
from dray.protocol.contract_net.auction_rules import PATIENCE_S, AuctionRules, rank
from dray.protocol.contract_net.terms import SPAN_MAX_S, SPANS_MAX, Place, Terms
from dray.protocol.contract_net.trust.assessment import Assessor
from dray.protocol.contract_net.trust.plausibility import by_our_clock
from dray.protocol.runtime.bounded_map import BoundedMap
from dray.protocol.runtime.events import NEVER_S
from dray.protocol.runtime.life import Life
from dray.states import States, Transitions

BIDS_KEPT = 1024
"""Maximum bids per round, more than any fleet has vehicles. More bids come under invented names."""

Offer = tuple[str, Bid]
"""A bidder, and what it has bid."""


class Bids:
    """The bids of an auction, and the order in which their bidders are asked.

    Args:
        candidates: bids to ask before the first announcement, cheapest first.
    """

    def __init__(self, candidates: tuple[Offer, ...] = ()) -> None:
        self._collected: BoundedMap[str, Bid] = BoundedMap(BIDS_KEPT)
        self._noted: BoundedMap[str, tuple[int, float]] = BoundedMap(BIDS_KEPT)
        """By bidder: the last round of which a bid was noted, and its surcharge (s)."""
        self._queue: list[Offer] = list(candidates)

    @property
    def is_queued(self) -> bool:
        """Whether a bidder is still to be asked."""
        return bool(self._queue)

    def objection(self, bidder: str, bid: Bid, present_round: int) -> str:
        """Why a bid is ignored without further checks; empty if it is to be checked."""
        if bid.round > present_round:
            return "a bid in a round that has not begun"
        if bid.round <= self._noted.get(bidder, (-1, 0.0))[0]:
            return "a second bid in one round"  # Limits the history to one bid per round.
        return ""

    def note(self, bidder: str, bid: Bid, surcharge_s: float) -> None:
        """Collect a bid; a later round's bid replaces the same bidder's earlier one."""
        self._collected[bidder], self._noted[bidder] = bid, (bid.round, surcharge_s)

    def let_bid_again(self, bidder: str) -> None:
        """Permit another bid of this bidder in this round."""
        self._noted.pop(bidder, None)

    def close_window(self) -> None:
        """Queue all bidders, cheapest first; later bids count in the next round."""
        self._queue = sorted(self._collected.items(), key=self._rank_of)
        self._collected = BoundedMap(BIDS_KEPT)

    def next(self) -> Offer | None:
        """The next bidder to ask; None when the queue is empty."""
        return self._queue.pop(0) if self._queue else None

    def left_over(self) -> tuple[Offer, ...]:
        """Bidders that were never asked, cheapest first."""
        return tuple(sorted((*self._queue, *self._collected.items()), key=self._rank_of))

    def _rank_of(self, offer: Offer) -> tuple[float, float, str]:
        bidder, bid = offer
        _, surcharge_s = self._noted.get(bidder, (0, 0.0))
        return rank(bid.cost.total_s + surcharge_s, bid.finish_s, bidder)


class Stage(StrEnum):
    """The stages of an auction."""

    PREPARED = "prepared"
    """It is not open yet."""
    RESTING = "resting"
    """Its next round is to come."""
    COLLECTING = "collecting"
    """It was announced, and bids are collected."""
    ASKING = "asking"
    """A bidder has the award, and its answer is awaited."""
    DECIDED = "decided"
    """A bidder has accepted, or the auction was cancelled."""


STAGES: Transitions[Stage] = {
    Stage.PREPARED: {
        Stage.COLLECTING: "announced",
        Stage.ASKING: "its candidates are asked first",
        Stage.RESTING: "it is to begin later, or stands behind a more urgent task",
        Stage.DECIDED: "cancelled: its task has a carrier, or is held",
    },
    Stage.RESTING: {
        Stage.COLLECTING: "its next round begins",
        Stage.ASKING: "a bid comes late",
        Stage.RESTING: "it stands behind a more urgent task",
        Stage.DECIDED: "cancelled",
    },
    Stage.COLLECTING: {
        Stage.ASKING: "its window closes",
        Stage.DECIDED: "cancelled",
    },
    Stage.ASKING: {
        Stage.DECIDED: "accepted, or cancelled",
        Stage.RESTING: "no bidder is left",
    },
    Stage.DECIDED: {},
}


class Auction:
    """One auction, from its first announcement until a bidder has accepted.

    Args:
        coordinator: the coordinator's id.
        terms: the task and its conditions.
        place: the centre of the announcement radius.
        audience: the bus keys that reach all agents within a radius (m).
        rules: time-outs and radius.
        assessor: checks bids and adds surcharges.
        candidates: bids to ask before the first announcement, cheapest first.
        numbers: of its awards; from 1 by default.
        waits: the coordinator's known waits at the places of a work, at a time (s).
    """

    def __init__(
        self,
        coordinator: str,
        terms: Terms,
        place: Place,
        audience: Callable[[float], tuple[str, ...]],
        rules: AuctionRules,
        life: Life,
        assessor: Assessor,
        candidates: tuple[Offer, ...] = (),
        numbers: Iterator[int] | None = None,
        waits: Callable[[Work, float], tuple[Wait, ...]] = lambda _work, _now_s: (),
    ) -> None:
        self.coordinator = coordinator
        self.terms = terms
        self.round = 0
        self._stages = States("an auction", STAGES, Stage.PREPARED)
        self.wake_at_s = NEVER_S
        self.winner = ""
        """The bidder that accepted; empty until the stage is DECIDED."""
        self.number = 0
        """Number of the newest award; 0 before the first."""
        self.winning_bid: Bid | None = None
        self.left_over: tuple[Offer, ...] = ()
        """Bidders that were never asked, cheapest first, once the stage is DECIDED."""
        self._place = place
        self._audience = audience
        self._waits = waits
        self._rules = rules
        self._life = life
        self._assessor = assessor
        self._bids = Bids(candidates)
        self._span_s = self._opened_s = 0.0
        self.needed_s = terms.deadline_s
        """Time by which the task is needed, for its urgency against other tasks (plant clock)."""
        self._behind = False
        """This round was not announced: a more urgent task waits for the same vehicles."""
        self.asked = ""
        """The bidder whose answer to an award is awaited; empty if none is."""
        self._rank = 0
        self._numbers = count(1) if numbers is None else numbers
        self._vain = 0
        """Rounds that ended without a winner."""
        self.found_nobody = False
        """A round at full radius has failed. Later rounds do not clear this."""

    @property
    def stage(self) -> Stage:
        return self._stages.now

    @property
    def has_asked(self) -> bool:
        """Whether an announcement was sent, or a candidate was asked."""
        return self.round > 0 or self.number > 0

    @property
    def awaits_answers(self) -> bool:
        """Whether bids are being collected or an award is unanswered."""
        return self.stage is Stage.COLLECTING or self.stage is Stage.ASKING

    @property
    def span_s(self) -> float:
        """Time for a task that begins now (s); it grows after each failed round."""
        return min(self._span_s * min(1 + self._vain, SPANS_MAX), SPAN_MAX_S)

    @property
    def radius_m(self) -> float:
        """The radius of the present round (m)."""
        return min(self._rules.radius_in_m(self.round), self._place.reach_m)

    def open(self, now_s: float) -> None:
        """Ask the candidates if there are any, else announce."""
        self._begin(now_s)
        if self._bids.is_queued:
            self._stages.enter(Stage.ASKING)
            self._ask_next(now_s)
        else:
            self._announce(now_s)

    def open_later(self, at_s: float, *, tell: bool = False) -> None:
        """Begin at `at_s`, unless it is cancelled before; `tell` records the opening of the task."""
        self._begin(at_s)
        self._stages.enter(Stage.RESTING)
        self.wake_at_s = at_s
        if tell:
            self._tell_opened(at_s)

    @property
    def has_candidates(self) -> bool:
        """Whether candidates are to be asked before the first announcement."""
        return self._bids.is_queued

    def is_due(self, now_s: float) -> bool:
        """Whether the next round is to begin now."""
        return self.stage is Stage.RESTING and now_s >= self.wake_at_s

    @property
    def waits(self) -> bool:
        """Whether a full-radius round failed or a more urgent task has precedence, and the next round is to come."""
        return self.was_in_vain or (self._behind and self.stage is Stage.RESTING)

    @property
    def was_in_vain(self) -> bool:
        """Whether a round at full radius failed, and the next round is still to come."""
        return self.stage is Stage.RESTING and self._vain > 0 and self.radius_m >= self._place.reach_m

    def stand_behind(self, now_s: float) -> None:
        """Announce nothing for now: a more urgent task waits for the same vehicles, and free vehicles ask for work."""
        if not self.round:
            self._begin(now_s)
            self.round = 1
            self._tell_opened(now_s)
        self._behind = True
        self._stages.enter(Stage.RESTING)
        self.wake_at_s = now_s + self._rules.rest_aged_max_s

    def offer(self, bidder: str, now_s: float) -> None:
        """Announce a waiting task to a vehicle that asks for work; it may bid again in this round."""
        self._move_deadline(now_s)
        self._bids.let_bid_again(bidder)
        self._life.send(bidder, self._announcement(self.wake_at_s, now_s))

    def on_bid(self, bidder: str, bid: Bid, now_s: float) -> None:
        """Note a plausible bid. A bid of a later round replaces the same bidder's earlier one."""
        if objection := self._objection(bidder, bid):
            self._life.ignore(objection)
            return
        bid = by_our_clock(bid, now_s)
        if self._assessor.refuses(bidder, self.terms.work, bid, now_s):
            return
        terms = self.terms
        surcharge_s = self._assessor.surcharge_s(bidder, now_s)
        self._bids.note(bidder, bid, surcharge_s)
        self._life.record(
            BidReceived(
                task=terms.task,
                epoch=terms.epoch,
                role=terms.role,
                round=bid.round,
                bidder=bidder,
                cost=bid.cost,
                total_s=bid.cost.total_s,
                finish_s=bid.finish_s,
                source=bid.source,
                surcharge_s=surcharge_s,
                battery_reckoned=bid.battery_reckoned,
            )
        )
        if self.stage is Stage.RESTING:
            # The bid came after its window: on such a slow link waiting longer gains nothing.
            self._close_window(now_s)

    def on_accepted(self, bidder: str, answer: Accepted) -> None:
        """Conclude the contract if this bidder was asked."""
        if bidder == self.winner:
            self._life.ignore("a second acceptance of one award")
            return
        if bidder != self.asked:
            self._release(bidder, answer.number, Reason.NOT_ASKED)
            return
        if answer.number != self.number:
            self._life.ignore("an answer to an earlier award")
            return
        self._note_answer("accepted")
        self.winner, self.asked = bidder, ""
        self._decide()
        self.left_over = self._bids.left_over()

    def on_declined(self, bidder: str, answer: Declined, now_s: float) -> None:
        """Ask the next bidder if this one was asked."""
        if bidder != self.asked or answer.number != self.number:
            self._life.ignore("a refusal of an award that the sender does not have")
            return
        self._note_answer("declined", answer.reason)
        self.asked = ""
        self._ask_next(now_s)

    def cancel(self) -> None:
        """End the auction; an asked bidder is released. Repeating this is harmless, also after a decision."""
        if self.asked:
            self._release(self.asked, self.number, Reason.WITHDRAWN)
            self.asked = ""
        if self.stage is not Stage.DECIDED:
            self._decide()

    def wake(self, now_s: float) -> None:
        """Handle the alarm: close the window, give up an unanswered award, or begin the next round."""
        if now_s < self.wake_at_s:
            return
        if self.stage is Stage.COLLECTING:
            self._close_window(now_s)
        elif self.stage is Stage.ASKING:
            self._note_answer("silent")
            self._release(self.asked, self.number, Reason.NO_ANSWER)
            self.asked = ""
            self._ask_next(now_s)
        elif self.stage is Stage.RESTING:
            self._announce(now_s)

    def _objection(self, bidder: str, bid: Bid) -> str:
        """Why a bid is ignored without further checks; empty if it is to be checked."""
        if self.stage is Stage.DECIDED or bidder == self.asked:
            return "a bid after the award"
        return self._bids.objection(bidder, bid, self.round)

    def _decide(self) -> None:
        self._stages.enter(Stage.DECIDED)
        self.wake_at_s = NEVER_S

    def _announce(self, now_s: float) -> None:
        self.round += 1
        if self.round > 1:
            self._move_deadline(now_s)
        self._behind = False
        self._stages.enter(Stage.COLLECTING)
        self.wake_at_s = now_s + self._rules.window_in_s(self.round)
        self._tell_opened(self.wake_at_s)
        announcement = self._announcement(self.wake_at_s, now_s)
        for key in self._audience(self.radius_m):
            self._life.publish(key, announcement)

    def _begin(self, now_s: float) -> None:
        self._opened_s = now_s
        self._span_s = self.terms.span_s(now_s)
        # A task without urgency must not wait for ever behind tasks that are always urgent.
        self.needed_s = min(self.terms.deadline_s, now_s + PATIENCE_S)

    def _tell_opened(self, until_s: float) -> None:
        terms = self.terms
        self._life.record(
            TaskOpened(
                task=terms.task,
                epoch=terms.epoch,
                role=terms.role,
                round=self.round,
                work=terms.work,
                radius_m=self.radius_m,
                deadline_s=terms.deadline_s,
                bids_until_s=until_s,
            )
        )

    def _announcement(self, until_s: float, now_s: float) -> TaskAnnounced:
        terms = self.terms
        return TaskAnnounced(
            task=terms.task,
            epoch=terms.epoch,
            role=terms.role,
            coordinator=self.coordinator,
            work=terms.work,
            deadline_s=terms.deadline_s,
            x_m=self._place.x_m,
            y_m=self._place.y_m,
            radius_m=self.radius_m,
            round=self.round,
            bids_until_s=until_s,
            primary=terms.primary,
            needed_s=self.needed_s,
            waits=self._waits(terms.work, now_s),
        )

    def _move_deadline(self, now_s: float) -> None:
        # All bidders would refuse an impossible deadline for ever: late is better than never.
        if self._rules.moves_deadline:
            self.terms = self.terms.until(now_s + self.span_s)

    def _close_window(self, now_s: float) -> None:
        self._bids.close_window()
        self._rank = 0
        self._stages.enter(Stage.ASKING)
        self._ask_next(now_s)

    def _ask_next(self, now_s: float) -> None:
        offer = self._bids.next()
        if offer is None:
            self._rest(now_s)
            return
        bidder, bid = offer
        terms = self.terms
        if isinstance(terms.work, Transport) and bid.source and bid.source not in terms.work.sources:
            # The bid was made when there were more sources.
            bid = msgspec.structs.replace(bid, source=terms.work.sources[0])
        self.asked, self.winning_bid = bidder, bid
        self._rank += 1
        self.number = next(self._numbers)
        # The answer timeout grows with failed rounds too, because `offer()` starts no round.
        self.wake_at_s = now_s + self._rules.answer_in_s(max(self.round, 1 + self._vain))
        fact = AwardGiven(task=terms.task, epoch=terms.epoch, role=terms.role, bidder=bidder, rank=self._rank)
        award = Award(
            task=terms.task,
            epoch=terms.epoch,
            role=terms.role,
            work=terms.work,
            deadline_s=terms.deadline_s,
            source=bid.source,
            primary=terms.primary,
            number=self.number,
        )
        self._life.record(fact)
        self._life.send(bidder, award)

    def _rest(self, now_s: float) -> None:
        reaches_all = self.radius_m >= self._place.reach_m
        # A wider radius was not announced yet, so there is no need to rest.
        rest_s = self._rules.rest_in_s(self.round, now_s - self._opened_s) if reaches_all else 0.0
        self._stages.enter(Stage.RESTING)
        self.wake_at_s = now_s + rest_s
        self.winning_bid = None
        # Counts rounds with bids too: a bidder that always declines must not keep an impossible deadline.
        self._vain += 1
        self.found_nobody = self.found_nobody or reaches_all
        terms = self.terms
        failed = RoundFailed(
            task=terms.task,
            epoch=terms.epoch,
            role=terms.role,
            round=self.round,
            bids=self._rank,
            next_round_s=self.wake_at_s,
        )
        self._life.record(failed)
        self._rank = 0

    def _note_answer(self, answer: Answer, reason: Refusal | None = None) -> None:
        terms = self.terms
        fact = AwardAnswered(terms.task, terms.epoch, terms.role, self.asked, answer, reason)
        self._life.record(fact)

    def _release(self, bidder: str, number: int, reason: Reason) -> None:
        terms = self.terms
        release = Release(task=terms.task, epoch=terms.epoch, role=terms.role, reason=reason, number=number)
        self._life.send(bidder, release)
