"""A machine as a contractor of the strategist: hear of goals, quote them, take them, give them back."""

from __future__ import annotations

from dray.messages import (
    Accepted,
    Award,
    Bid,
    Declined,
    GoalClosed,
    Production,
    Refusal,
    Release,
    Role,
    TaskAnnounced,
    Withdrawn,
)
from dray.messages.fact import BidRefused, BidSent, ContractEnded, ContractTaken
from dray.protocol.events import Effect, Record, Send
from dray.protocol.production import Goal, GoalBook
from dray.protocol.supply import Supply

QUOTES_KEPT = 64
"""Bids for goals whose award may still come: more than a strategist has open at a time."""

QUOTE_TOLERANCE_S = 60.0
"""How much later than it bid a machine may end and still take an award."""


class GoalBidder:
    """Bids for one machine.

    Args:
        products: what the machine can make.
        goals: what it has taken.
        supply: what is at hand.
        out: where effects go.
    """

    def __init__(self, products: tuple[str, ...], goals: GoalBook, supply: Supply, out: list[Effect]) -> None:
        self._products = products
        self._goals = goals
        self._supply = supply
        self._out = out
        self._quoted_s: dict[str, float] = {}
        """By goal: when it was promised to be done. Oldest first."""

    def hear(self, message: TaskAnnounced, unfit: str, now_s: float) -> None:
        """Answer an announcement with a bid, or note why not.

        Args:
            message: the announcement.
            unfit: why the machine cannot work at all; empty when it can.
            now_s: the present time.
        """
        work = message.work
        if not isinstance(work, Production) or work.product not in self._products:
            return
        if unfit:
            refused = BidRefused(
                task=message.task,
                epoch=message.epoch,
                role=message.role,
                reason=Refusal.NOT_FIT,
                detail=unfit,
            )
            self._out.append(Record(refused))
            return
        cost = self._goals.quote(work, self._supply.stock, self._supply.longest_lead_s(work.product))
        finish_s = now_s + cost.total_s
        self._remember(message.task, finish_s)
        bid = Bid(
            task=message.task,
            epoch=message.epoch,
            role=message.role,
            round=message.round,
            cost=cost,
            finish_s=finish_s,
        )
        sent = BidSent(task=message.task, epoch=message.epoch, role=message.role, total_s=cost.total_s)
        self._out += (Send(message.coordinator, bid), Record(sent))

    def hear_award(self, sender: str, award: Award, unfit: str, now_s: float) -> bool:
        """Take a goal or decline it; True when it was taken just now."""
        work = award.work
        if not isinstance(work, Production):
            return False
        if self._goals.get(award.task) is not None:
            self._accept(sender, award, now_s)  # Its first answer was lost.
            return False
        reason = self._why_not(award.task, work, unfit, now_s)
        if reason is not None:
            declined = Declined(task=award.task, epoch=award.epoch, role=award.role, reason=reason)
            self._out.append(Send(sender, declined))
            return False
        self._goals.add(Goal(award.task, work, award.deadline_s))
        self._accept(sender, award, now_s)
        taken = ContractTaken(task=award.task, epoch=award.epoch, role=award.role, coordinator=sender)
        self._out.append(Record(taken))
        return True

    def hear_over(self, message: Release | Withdrawn, running: Goal | None) -> bool:
        """The goal is not needed; True when it was given back: nothing of it was begun yet."""
        goal = self._goals.get(message.task)
        if goal is None or goal.made or goal is running:
            return False
        self._end(goal, message.epoch, message.reason)
        return True

    def hear_closed(self, message: GoalClosed) -> None:
        """The strategist has noted that all of a goal is delivered."""
        goal = self._goals.get(message.goal)
        if goal is not None and goal.delivered >= goal.work.quantity:
            self._end(goal, 1, "delivered")

    def _end(self, goal: Goal, epoch: int, reason: str) -> None:
        self._goals.remove(goal.id)
        ended = ContractEnded(task=goal.id, epoch=epoch, role=Role.PRIMARY, reason=reason)
        self._out.append(Record(ended))

    def _accept(self, sender: str, award: Award, now_s: float) -> None:
        finish_s = self._quoted_s.get(award.task, now_s)
        accepted = Accepted(task=award.task, epoch=award.epoch, role=award.role, finish_s=finish_s)
        self._out.append(Send(sender, accepted))

    def _why_not(self, goal: str, work: Production, unfit: str, now_s: float) -> Refusal | None:
        """A goal that was taken since the bid may have made its promise empty."""
        if unfit:
            return Refusal.NOT_FIT
        cost = self._goals.quote(work, self._supply.stock, self._supply.longest_lead_s(work.product))
        finish_s = now_s + cost.total_s
        late_s = finish_s - self._quoted_s.setdefault(goal, finish_s)
        return Refusal.BUSY if late_s > QUOTE_TOLERANCE_S else None

    def _remember(self, goal: str, finish_s: float) -> None:
        self._quoted_s[goal] = finish_s
        if len(self._quoted_s) > QUOTES_KEPT:
            del self._quoted_s[next(iter(self._quoted_s))]
