"""A machine as a contractor of the strategist: it quotes goals, takes them, and gives them back."""

from __future__ import annotations

from collections.abc import Callable

from dray.messages import (
    Accepted,
    Award,
    Confirmed,
    GoalClosed,
    GoalRevised,
    GoalRevisionTaken,
    HolderChanged,
    Message,
    Production,
    ProductionCost,
    Reason,
    Refusal,
    Release,
    Role,
    TaskAnnounced,
    Withdrawn,
)
from dray.messages.fact import ContractEnded, ContractTaken
from dray.messages.overtaken import LatestNumbers
from dray.protocol.contract_net.replies import Refusals, decline, offer
from dray.protocol.contract_net.trust.probation import ON_PROBATION, Probation
from dray.protocol.machine.production import Goal, GoalBook
from dray.protocol.machine.supply import Supply
from dray.protocol.runtime.bounded_map import BoundedMap
from dray.protocol.runtime.events import Send
from dray.protocol.runtime.life import Life
from dray.protocol.runtime.retransmission import Retransmitter

CONFIRM = "confirm"

QUOTES_KEPT = 64
"""Maximum bids whose award may still come: more than a strategist has open at a time."""

GOALS_MAX = 4096
"""Maximum goals of one machine: weeks of work. More are not from orders."""

QUOTE_TOLERANCE_S = 60.0
"""Maximum lateness against its bid with which a machine still takes an award (s)."""


class GoalBidder:
    """Bids for one machine.

    Args:
        goals: its goals.
        supply: its stock.
        probation: the machine's probation. A goal of one container is short: a fault spoils no more.
        life: the agent's life; alarms are named ``(CONFIRM, goal)``.

    Attributes:
        alarms: handlers of this class's alarms, called with (goal, now_s).
        message_handlers: for the machine's table.
    """

    def __init__(self, goals: GoalBook, supply: Supply, probation: Probation, life: Life) -> None:
        self._goals = goals
        self._supply = supply
        self._probation = probation
        self._life = life
        self._refusals = Refusals(life)
        self._quoted_s: BoundedMap[str, float] = BoundedMap(QUOTES_KEPT)
        """By goal: the promised finish."""
        self._holders: LatestNumbers[str] = LatestNumbers(GOALS_MAX)
        """By order: the epoch with which its strategist holds it."""
        self._unconfirmed = Retransmitter(CONFIRM, life)
        """Acceptances, repeated until their strategist has confirmed the goal or released the machine."""
        self.alarms = {CONFIRM: self._unconfirmed.wake}
        self.message_handlers: dict[type[Message], Callable[..., None]] = {
            HolderChanged: self.on_holder_changed
        }

    def coordinator_of(self, task: str, _role: Role) -> str:
        """The strategist of a goal, or the one that took its order over; empty without such a goal."""
        goal = self._goals.get(task)
        return "" if goal is None else goal.strategist

    def on_announced(self, message: TaskAnnounced, unfit: str, now_s: float) -> None:
        """Answer an announcement with a bid, or note the refusal.

        Args:
            message: the announcement.
            unfit: why the machine takes no goals at all; empty if it does.
            now_s: the present time.
        """
        work = message.work
        if not isinstance(work, Production) or not self._goals.products.can_make(work):
            return
        if objection := self._goals.products.objection(work):
            self._refusals.note(message, Refusal.ABILITY, objection)
            return
        is_short = work.quantity <= work.definition.lot
        if not unfit and self._probation.bars(short=is_short, round_number=message.round):
            unfit = ON_PROBATION
        if unfit:
            self._refusals.note(message, Refusal.NOT_FIT, unfit)
            return
        self._refusals.forget(message)
        cost = self._quote(work, message.deadline_s, now_s)
        finish_s = now_s + cost.takes_s
        self._quoted_s[message.task] = finish_s
        self._life.do(*offer(message, cost, finish_s, now_s))

    def on_award(self, sender: str, award: Award, unfit: str, now_s: float) -> bool:
        """Take a goal or decline it; True if it was taken just now."""
        work = award.work
        if not isinstance(work, Production) or not self._is_able(work):
            self._life.do(decline(sender, award, Refusal.ABILITY))
            return False
        known = self._goals.get(award.task)
        if known is not None:
            # Its first answer was lost, or the strategist has lost it by a restart.
            if award.epoch >= known.epoch:
                known.epoch, known.number = award.epoch, award.number
                self._life.commit()
            self.ask(known, now_s)
            return False
        reason = self._why_not(sender, award.task, work, award.deadline_s, unfit, now_s)
        if reason is not None:
            self._life.do(decline(sender, award, reason))
            return False
        goal = Goal(award.task, work, award.deadline_s, sender, award.epoch, award.number)
        for each in self._of_order(work.order):
            goal.held, goal.taken_over = max(goal.held, each.held), goal.taken_over or each.taken_over
        goal.promised_s = self._quoted_s[goal.id]
        self._goals.add(goal)
        self._life.commit()
        self.ask(goal, now_s)
        taken = ContractTaken(task=award.task, epoch=award.epoch, role=award.role, coordinator=sender)
        self._life.record(taken)
        return True

    def ask(self, goal: Goal, now_s: float) -> None:
        """Repeat the acceptance until it is confirmed. The answer tells if the goal is valid, and what has arrived."""
        accepted = Accepted(
            task=goal.id,
            epoch=goal.epoch,
            role=Role.PRIMARY,
            finish_s=self._quoted_s.get(goal.id, goal.promised_s or now_s),
            number=goal.number,
        )
        self._unconfirmed.say(goal.id, Send(goal.strategist, accepted), now_s)

    def on_confirmed(self, message: Confirmed, now_s: float) -> bool:
        """The strategist confirms the goal; True if that, or the count of arrivals, is new."""
        goal = self._goals.get(message.task)
        if goal is None:
            return False
        # Also after an earlier confirmation: a doubled award has made the machine ask again.
        self._unconfirmed.settle(goal.id)
        before = (goal.confirmed, goal.delivered, goal.lost_in_transit)
        goal.confirmed = True
        goal.on_count(message, now_s)
        self._goals.add_spare(goal.work.product, goal.note_arrived(message.arrived))
        if before == (goal.confirmed, goal.delivered, goal.lost_in_transit):
            return False
        self._life.commit()
        return True

    def on_revised(self, sender: str, message: GoalRevised, running: Goal | None) -> bool:
        """Reduce a goal, or change its deadline; begun pieces are kept. True after a change.

        Args:
            sender: the strategist, which hears what is kept.
            message: the new quantity and deadline.
            running: the goal of the running cycle.
        """
        goal = self._goals.get(message.task)
        if goal is None or message.epoch != goal.epoch:
            return False  # Its strategist learns from the heartbeat that there is no such goal here.
        # Pieces in work, or made and not lost, cannot be saved.
        begun = max(goal.made - goal.lost_in_transit + (goal is running), goal.delivered, goal.arrived)
        kept = min(max(begun, message.quantity), goal.work.quantity)
        is_news = self._goals.revise(goal, kept, message.deadline_s)
        if is_news:
            self._life.commit()
        self._life.send(sender, GoalRevisionTaken(goal.id, goal.epoch, message.quantity, goal.work.quantity))
        return is_news

    def on_over(self, message: Release | Withdrawn) -> Goal | None:
        """The goal is not this machine's any more: it stops, and ready pieces are spare.

        Returns:
            The goal, if it was known; None for ignored messages. A Release answers a machine that asks: it is too
            late for a
                confirmed goal, or for one with another award.
        """
        goal = self._goals.get(message.task)
        if goal is None:
            return None
        if isinstance(message, Release) and (
            goal.id not in self._unconfirmed or message.number != goal.number
        ):
            return None
        return self._end(goal, message.reason)

    def on_holder_changed(self, sender: str, message: HolderChanged, now_s: float) -> None:
        """Another strategist takes over the goals of an order, unless a later one already has.

        A lower epoch counts once no late message can have it: then a thief of a strategist's certificate has told the higher one.
        """
        goals = self._of_order(message.order)
        if not goals:
            return
        held = max(goal.held for goal in goals)
        newest, said = self._holders.of(message.order, (held,), now_s), (message.epoch,)
        is_known = all(goal.strategist == sender for goal in goals)
        if not (newest.stands(said, now_s) if is_known else newest.takes(said, now_s)):
            self._life.ignore("a strategist that a later one has replaced")
            return
        for goal in goals:
            is_news = (goal.strategist, goal.held) != (sender, message.epoch)
            goal.strategist, goal.held, goal.taken_over = sender, message.epoch, True
            if is_news and goal.id in self._unconfirmed:
                self.ask(goal, now_s)
        self._life.commit()

    def on_closed(self, message: GoalClosed) -> Goal | None:
        """The gate has counted all of a goal. Returns the goal, if it was known."""
        goal = self._goals.get(message.goal)
        return None if goal is None else self._end(goal, Reason.DELIVERED)

    def _end(self, goal: Goal, reason: Reason) -> Goal:
        self._goals.remove(goal.id)
        self._unconfirmed.settle(goal.id)
        self._life.commit()
        ended = ContractEnded(task=goal.id, epoch=goal.epoch, role=Role.PRIMARY, reason=reason)
        self._life.record(ended)
        return goal

    def _is_able(self, work: Production) -> bool:
        products = self._goals.products
        return products.can_make(work) and not products.objection(work)

    def _quote(self, work: Production, deadline_s: float, now_s: float) -> ProductionCost:
        lead_s = self._supply.longest_lead_s(work)
        return self._goals.quote(work, self._supply.stock, lead_s, deadline_s, now_s)

    def _of_order(self, order: str) -> list[Goal]:
        return [goal for goal in self._goals if goal.work.order == order]

    def _why_not(
        self, sender: str, goal: str, work: Production, deadline_s: float, unfit: str, now_s: float
    ) -> Refusal | None:
        """Why an award is declined: other goals delay the promise, or another strategist holds the order."""
        if unfit or any(each.strategist != sender for each in self._of_order(work.order)):
            return Refusal.NOT_FIT
        if len(self._goals) >= GOALS_MAX:
            return Refusal.BUSY
        finish_s = now_s + self._quote(work, deadline_s, now_s).takes_s
        promised_s = self._quoted_s[goal] = self._quoted_s.get(goal, finish_s)
        return Refusal.BUSY if finish_s - promised_s > QUOTE_TOLERANCE_S else None
