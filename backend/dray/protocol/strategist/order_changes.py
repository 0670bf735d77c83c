"""How a strategist changes an order in work: at once if no piece is begun, else as far as machines can still save pieces.

Goals without a machine are put up anew. A machine gets the sufficient quantity (`GoalRevised`), and answers with
what it keeps. The message is repeated after each heartbeat that shows the goal otherwise, so no message has to be
remembered. Machines are asked one after another, always in the same order: after losses and restarts no more pieces
are saved than asked.
"""

from __future__ import annotations

from msgspec import UNSET
from msgspec.structs import replace

from dray.body import Admit
from dray.messages import GoalBrief, GoalRevised, GoalRevisionTaken, OrderItem, OrderReleased, OrderTaken
from dray.messages.fact import GoalReduced
from dray.messages.overtaken import LatestNumbers
from dray.protocol.runtime.life import Life
from dray.protocol.strategist.goal_auctions import GoalAuctions
from dray.protocol.strategist.order_book import DELIVERY_S, ORDERS_MAX, OpenGoal, OrderBook, OrderInWork
from dray.protocol.strategist.order_ends import OrderEnds


class OrderChanges:
    """The order changes of one strategist.

    Args:
        book: all orders and goals.
        auctions: those of the goals.
        ends: ends goals and orders.
    """

    def __init__(
        self,
        book: OrderBook,
        auctions: GoalAuctions,
        ends: OrderEnds,
        life: Life,
    ) -> None:
        self._book, self._auctions, self._ends, self._life = book, auctions, ends, life
        self._said: LatestNumbers[str] = LatestNumbers(ORDERS_MAX)
        """By order in work: its newest change."""
        self._askers: dict[str, str] = {}
        """By order: the agent that waits for the end of a change; an unknown one asks again."""

    def on_released(self, sender: str, message: OrderReleased, order: OrderInWork, now_s: float) -> bool:
        """An order in work is sent again; another change applies from now on, and the answer follows when that is done.

        A lower change of the same release counts once nobody repeats the higher one: a thief of a gateway's certificate has stated that.

        Returns:
            Whether it concerns a change.
        """
        newest = self._said.of(order.id, (order.change,), now_s)
        if message.release == order.release:
            counts = newest.stands((message.change,), now_s) and message.change != order.change
        else:
            counts = message.change > order.change
        if not counts and not order.wanted:
            return False
        self._askers[order.id] = sender
        if counts:
            self._begin(message, order)
        self.settle(order, now_s)
        return True

    def _begin(self, message: OrderReleased, order: OrderInWork) -> None:
        order.change = message.change
        pairs = zip(message.items, order.items, strict=False)
        order.wanted = [max(0, asked.quantity + asked.arrived - item.arrived) for asked, item in pairs]
        is_later, order.due_s = message.due_s != order.due_s, message.due_s
        self._book.touch(order)
        for goal in list(order.goals.values()):
            goal.asked, goal.keeps = None, False
            if goal.work.part_of:
                if is_later and not goal.machine:
                    # The planner orders the part again, with another deadline.
                    self._replace(goal, 0)
            elif is_later and not goal.machine:
                self._replace(goal, goal.work.quantity)
            elif is_later:
                goal.deadline_s = order.due_s - DELIVERY_S
                self._say(goal)
        for index, item in enumerate(message.items):
            self._add(order, index, item)

    def settle(self, order: OrderInWork, now_s: float) -> None:
        """Continue a change of an order, and report when it is done."""
        if self._book.order(order.id) is not order or order.revoked_by:
            return
        if order.wanted:
            settled = [self._spare(order, index) for index in range(len(order.items))]
            if all(settled):
                self._ends.end_change(order)
        for product in dict.fromkeys(goal.work.product for goal in order.goals.values() if not goal.machine):
            self._auctions.ask_next(product, now_s)
        if not order.wanted:
            self._answer(order)

    def on_taken(self, sender: str, message: GoalRevisionTaken, now_s: float) -> None:
        """A machine has answered what it keeps."""
        goal = self._book.goal(message.task)
        if goal is None or goal.machine != sender or goal.epoch != message.epoch:
            self._life.ignore("an answer about a goal or an epoch that has ended")
            return
        self._note(goal, message.quantity, message.asked, now_s)

    def on_named(self, goal: OpenGoal, brief: GoalBrief, now_s: float) -> None:
        """A machine names a goal: repeat what it has not heard, and accept what it reports."""
        if brief.quantity < goal.work.quantity:
            self._note(goal, brief.quantity, goal.asked, now_s)
        elif goal.asked is not None or brief.deadline_s not in (UNSET, goal.deadline_s):
            self._say(goal)

    # --- internals ---

    def _note(self, goal: OpenGoal, quantity: int, asked: int | None, now_s: float) -> None:
        """A machine makes no more than `quantity` of a goal, asked or not."""
        if goal.failure:
            return  # The gate is being shut for it; the missing pieces are given to others.
        order, work = self._book.order_of(goal), goal.work
        is_answer = goal.asked is not None and goal.asked == asked
        if is_answer:
            goal.asked, goal.keeps = None, True
        kept = max(quantity, goal.arrived)
        if kept < work.quantity:
            stands = order.items[work.item].quantity
            self._reduce(goal, kept)
            wanted = order.wanted[work.item] if order.wanted else stands
            missing = wanted - order.items[work.item].quantity
            if missing > 0:
                # It has saved pieces that are wanted again.
                self._book.resize(order, work.item, missing)
                rest = OrderItem(work.product, missing, work.definition)
                self._book.add_goals(order, work.item, rest)
        self.settle(order, now_s)
        if not goal.work.quantity:
            self._auctions.close_goal(goal, "withdrawn")
            self._ends.close(goal)
        elif goal.arrived >= goal.work.quantity and self._book.goal(goal.id) is goal:
            self._ends.deliver(goal)

    def _reduce(self, goal: OpenGoal, kept: int) -> None:
        work = goal.work
        self._book.reduce(goal, kept)
        self._life.instruct(Admit(goal=goal.id, quantity=kept))
        held = self._book.held_with(work.order)
        reduced = GoalReduced(goal.id, work.order, work.item, work.product, goal.machine, kept, held)
        self._life.record(reduced)

    def _add(self, order: OrderInWork, index: int, item: OrderItem) -> None:
        """Add goals for an increased item."""
        if index < len(order.wanted) and (more := order.wanted[index] - order.items[index].quantity) > 0:
            self._book.resize(order, index, more)
            self._book.add_goals(order, index, replace(item, quantity=more))

    def _spare(self, order: OrderInWork, index: int) -> bool:
        """Have less of an item made; returns whether no machine has to be asked any more."""
        whole = [goal for goal in order.goals.values() if not goal.work.part_of]
        goals = [goal for goal in whole if goal.work.item == index]
        for goal in reversed([goal for goal in goals if not goal.machine]):
            surplus = order.items[index].quantity - order.wanted[index]
            if surplus > 0:
                left = max(0, goal.work.quantity - surplus)
                self._book.resize(order, index, left - goal.work.quantity)
                self._replace(goal, left)
        for goal in reversed([goal for goal in goals if goal.machine]):
            surplus = order.items[index].quantity - order.wanted[index]
            least = max(goal.arrived, goal.work.quantity - surplus)
            if surplus <= 0:
                break
            if goal.failure:
                return False
            if not goal.keeps and least < goal.work.quantity:
                if goal.asked != least:
                    goal.asked = least
                    self._say(goal)
                return False
        return True

    def _replace(self, goal: OpenGoal, quantity: int) -> None:
        """Put a goal without a machine up anew, or drop it."""
        self._auctions.close_goal(goal, "withdrawn")
        if quantity:
            self._book.succeed(goal, quantity)
        else:
            self._book.close(goal)

    def _say(self, goal: OpenGoal) -> None:
        quantity = goal.work.quantity if goal.asked is None else goal.asked
        self._life.send(goal.machine, GoalRevised(goal.id, goal.epoch, quantity, goal.deadline_s))

    def _answer(self, order: OrderInWork) -> None:
        asker = self._askers.pop(order.id, "")
        if asker:
            self._life.send(asker, self.taken(order.id, order.release, order.change))

    def taken(self, order: str, release: int, change: int) -> OrderTaken:
        """The answer to an order in work or ended; with its quantities if it was changed."""
        in_work, ended = self._book.order(order), self._book.ended(order)
        if in_work is not None:
            quantities = in_work.quantities if change else ()
            return OrderTaken(order, release, change=in_work.change, quantities=quantities)
        return OrderTaken(order, release, ended.fulfilled, ended.change, ended.quantities if change else ())
