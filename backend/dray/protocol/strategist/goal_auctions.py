"""How a strategist auctions goals: those of one product one after another, different products at the same time.

So every machine bids with its real queue (`goal_bidding` is its side). The `strategist` follows a goal after its
contract.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

from dray.errors import ProtocolViolation
from dray.messages import (
    Accepted,
    Brought,
    Confirmed,
    GoalBrief,
    GoalClosed,
    Production,
    Reason,
    Withdrawn,
    Work,
)
from dray.messages.fact import GoalContracted, GoalWaits, Outcome, TaskClosed
from dray.messages.keys import Keys
from dray.protocol.contract_net.auction_rules import AuctionRules
from dray.protocol.contract_net.coordinator import Coordinator
from dray.protocol.contract_net.task import OpenTask
from dray.protocol.contract_net.terms import Place
from dray.protocol.contract_net.trust.assessment import Assessor
from dray.protocol.liveness.suspicion import GOAL_SILENCE_S
from dray.protocol.runtime.life import Change, Life
from dray.protocol.runtime.shutdown import GracefulShutdown
from dray.protocol.strategist.machine_monitor import MachineMonitor
from dray.protocol.strategist.order_book import OpenGoal, OrderBook

GOAL_RULES = AuctionRules(window_s=0.5, rest_s=5.0, rest_growth=1.5, rest_aged_frac=0.0, moves_deadline=False)
"""Machines are wired and few, so the window is shorter than for vehicles."""

NOWHERE = Place(x_m=0.0, y_m=0.0, reach_m=0.0)
"""A goal's audience has no place: all machines for the product are asked."""


REASON_CHARS = 500
"""Maximum length of a reason; a large plant has more machines than a person reads."""

GOAL_CHECK = "goal check"
"""Alarm of the check of a goal, by goal: the strategist sets it while it follows the goal."""

TAKERS = "takers"
"""Alarm of the check whether any machine could take a goal, by product."""


@dataclass(frozen=True, slots=True)
class GoalTaken(Change):
    """A machine has taken a goal; the next goal of its product may be put up."""

    goal: OpenGoal


class GoalAuctions(Coordinator):
    """The goals of one strategist, put up for auction.

    Args:
        keys: the plant's bus keys.
        book: all goals.
        watch: the monitor of machines.
        life: the agent's life; alarms are named ``(TAKERS, product)`` beside those of its base.
        assessor: checks bids and adds surcharges.
        shutdown: of the strategist: while it drains it auctions nothing.
    """

    def __init__(
        self,
        keys: Keys,
        book: OrderBook,
        watch: MachineMonitor,
        life: Life,
        assessor: Assessor,
        shutdown: GracefulShutdown,
    ) -> None:
        super().__init__(life.agent, NOWHERE, GOAL_RULES, life, assessor, watch.arrivals)
        self._keys = keys
        self._book = book
        self._watch = watch
        self._shutdown = shutdown
        self._asking: dict[str, str] = {}
        """By product: the goal that is up for auction."""
        self.alarms[TAKERS] = self._check_takers

    def ask_next(self, product: str, now_s: float) -> None:
        """Put the next goal of a product up for auction, unless one already is, or the strategist drains."""
        if product in self._asking or self._shutdown.begun:
            return
        goal = next(self._book.unclaimed(product), None)
        if goal is None:
            self._life.cancel((TAKERS, product))
            return
        self._asking[product] = goal.id
        self.open(goal.id, goal.work, goal.deadline_s, now_s, epoch=goal.epoch)
        if not self._life.awaits((TAKERS, product)):
            self._check_takers(product, now_s)

    def close_goal(self, goal: OpenGoal, outcome: Outcome) -> None:
        """A goal has ended, with or without an auction; it is not followed any more."""
        self._life.cancel((GOAL_CHECK, goal.id))
        if self._asking.get(goal.work.product) == goal.id:
            del self._asking[goal.work.product]
        task = self.get(goal.id)
        if task is not None:
            self.close(task, outcome)
        elif goal.machine:
            # An earlier life made the contract, and its auctions are forgotten.
            if outcome == "withdrawn":
                self.withdraw(goal.machine, goal.id, goal.epoch)
            ended = TaskClosed(task=goal.id, epoch=goal.epoch, outcome=outcome, carrier=goal.machine)
            self._life.record(ended)

    def give_up(self, goal: OpenGoal) -> None:
        """Another strategist holds the order of a goal, and follows it: withdraw an auction; a contract stands."""
        self._life.cancel((GOAL_CHECK, goal.id))
        if self._asking.get(goal.work.product) == goal.id:
            del self._asking[goal.work.product]
        task = self.get(goal.id)
        if task is not None and not goal.machine:
            self.close(task, "withdrawn")
        self._open.pop(goal.id, None)

    def on_accepted(self, sender: str, answer: Accepted, now_s: float) -> None:
        """Bind the machine, and confirm whenever it asks: it begins only then."""
        goal = self._book.goal(answer.task)
        if goal is None or goal.machine != sender:
            super().on_accepted(sender, answer, now_s)
            self._life.settle(now_s)  # The gate admits the goal before its machine begins.
        if goal is not None and goal.machine == sender and goal.epoch == answer.epoch:
            goal.named_s = now_s
            self.confirm(goal)

    # --- messages to machines ---

    def confirm(self, goal: OpenGoal) -> None:
        """Confirm a goal to its machine, with the count of arrivals."""
        brought = tuple(Brought(vehicle, pieces) for vehicle, pieces in goal.brought.items())
        confirmed = Confirmed(
            task=goal.id, epoch=goal.epoch, arrived=goal.arrived, brought=brought, by_people=goal.by_people
        )
        self._life.send(goal.machine, confirmed)

    def withdraw(self, machine: str, goal: str, epoch: int) -> None:
        """Tell a machine that a goal is withdrawn."""
        self._life.send(machine, Withdrawn(task=goal, epoch=epoch, reason=Reason.NOT_NEEDED))

    def say_over(self, machine: str, brief: GoalBrief) -> None:
        """Tell a machine that names an ended goal how it ended."""
        closed = self.closed(brief.goal)
        # The goals of an earlier life are unknown here; the machine's own counts suffice.
        delivered = brief.delivered >= brief.quantity if closed is None else closed.outcome == "delivered"
        if delivered:
            self._life.send(machine, GoalClosed(goal=brief.goal))
        else:
            self.withdraw(machine, brief.goal, 1 if closed is None else closed.epoch)

    # --- goals without a taker ---

    def say_waits(self, goal: OpenGoal, now_s: float) -> None:
        """Record once that no machine can make a goal, with each machine's problem."""
        if goal.waits:
            return
        goal.waits = True
        machines = self._watch.failures(goal.work, now_s, goal.machine if goal.offered else "")
        self._life.record(GoalWaits(goal=goal.id, order=goal.work.order, machines=machines))

    def _check_takers(self, product: str, now_s: float) -> None:
        """Report goals of a product that no living machine could take, and check again later."""
        waiting = list(self._book.unclaimed(product))
        if not waiting:
            return
        for goal in waiting:
            if self._watch.anybody_fit(goal.work, now_s):
                goal.waits = False
            else:
                self.say_waits(goal, now_s)
        self._life.alarm((TAKERS, product), now_s + GOAL_SILENCE_S)

    # --- internals ---

    def _audience(self, work: Work, _radius_m: float) -> tuple[str, ...]:
        goal = cast(Production, work)
        named = self._watch.named_for(goal)
        return tuple(self._keys.goals(each) for each in (goal.product, *named))

    def _contracted(self, task: OpenTask, now_s: float) -> None:
        goal = self._book.goal(task.id)
        if goal is None:
            raise ProtocolViolation(f"{self._life.agent}: {task.id} was put up and is in no order")
        self._book.contract(goal, task.primary, now_s)
        work = goal.work
        contracted = GoalContracted(
            goal=goal.id,
            order=work.order,
            item=work.item,
            product=work.product,
            quantity=work.quantity,
            machine=goal.machine,
            finish_s=task.contract.promised_s,
            part_of=work.part_of,
            held=self._book.held_with(work.order),
        )
        self._life.record(contracted)
        # The auction is over; from now on the goal is followed, not its task.
        del self._asking[work.product]
        self._life.note(GoalTaken(goal))
