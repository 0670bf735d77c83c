"""One of several strategists: its answers, takeovers and losses of orders. `order_holding` knows the holders."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from dray.body import GateState, Report
from dray.memory import Memory
from dray.messages import (
    Event,
    GoalBrief,
    Message,
    OrderCancelled,
    OrderReleased,
    OrderRevoked,
    StrategistHeartbeat,
)
from dray.messages.fact import GoodsDelivered, OrderTakenOver
from dray.messages.gate import GoalHeld, OrderHeld
from dray.messages.keys import Keys
from dray.protocol.runtime.events import Commit
from dray.protocol.runtime.life import BEAT, Life
from dray.protocol.runtime.shutdown import GracefulShutdown
from dray.protocol.strategist.goal_auctions import GoalAuctions
from dray.protocol.strategist.order_book import OpenGoal, OrderBook, OrderInWork
from dray.protocol.strategist.order_holding import CLAIM, OrderHolding, Said
from dray.protocol.strategist.peers import Peers

Handler = Callable[..., None]


class SharedOrders:
    """The orders of one strategist among several.

    Args:
        keys: the plant's bus keys.
        book: the orders that it holds.
        auctions: its goal auctions.
        shutdown: of the strategist: while it drains it sends no heartbeats, and claims nothing.
        agent, incarnation, others: its id, how often it was started, and the other strategists.
        handlers: handlers of messages about orders that it holds.
        follow: begins to watch a goal.
        unfollow: ends that.
        settle: continues people's change of an order.
        end_if_done: ends a delivered order.
        take_back: withdraws an order's goals without a machine, and shuts the gate for the others.

    Attributes:
        message_handlers, report_handlers, alarms: entries for the strategist's tables.
    """

    def __init__(
        self,
        keys: Keys,
        book: OrderBook,
        auctions: GoalAuctions,
        life: Life,
        shutdown: GracefulShutdown,
        *,
        agent: str,
        incarnation: int,
        others: tuple[str, ...],
        handlers: Mapping[type[Message], Handler],
        follow: Callable[[OpenGoal, float], None],
        unfollow: Callable[[OpenGoal], None],
        settle: Callable[[OrderInWork, float], None],
        end_if_done: Callable[[OrderInWork], None],
        take_back: Callable[[OrderInWork], None],
    ) -> None:
        self._book, self._auctions, self._life, self._shutdown = book, auctions, life, shutdown
        self._follow, self._unfollow = follow, unfollow
        self._settle, self._end_if_done, self._take_back = settle, end_if_done, take_back
        said: dict[type[Message], Handler] = {
            kind: handlers[kind] for kind in (OrderReleased, OrderCancelled, OrderRevoked)
        }
        self._answer = said
        self._peers = Peers(agent, incarnation, others, keys, life, lambda: len(book.orders()))
        self._holding = OrderHolding(
            agent,
            self._peers,
            life,
            is_over=self._is_over,
            can_take=lambda release: not book.is_full and all(map(book.can_be_made, release.items)),
            granted=self._on_granted,
            lost=self._on_lost,
            heard=lambda sender, message, now_s: said[type(message)](sender, message, now_s),
        )
        book.held_with = self._holding.epoch
        self.message_handlers: dict[type[Message], Handler] = {
            **dict.fromkeys(said, self._on_said),
            StrategistHeartbeat: self._peers.on_heartbeat,
            Event: self._holding.on_event,
        }
        self.report_handlers: dict[type[Report], Callable[[Any, float], None]] = {
            OrderHeld: self._holding.on_held
        }
        self.alarms: dict[str, Callable[[Any, float], None]] = {BEAT: self._beat, CLAIM: self._claim}

    def commits(self) -> list[Commit]:
        """The changed notes."""
        return self._holding.commits()

    def restore(self, memory: Memory, gate: GateState) -> None:
        """Restore notes of earlier lives, and give up orders that another strategist holds now."""
        self._holding.restore(memory)
        for order in self._book.orders():
            if order.id not in gate.held:
                self._book.give_up(order.id)

    def start(self, gate: GateState, now_s: float) -> None:
        """Start heartbeats and subscriptions, and continue the held orders."""
        self._peers.start(now_s)
        self._holding.start(gate.held, self._knows, now_s)

    def has_ended(self, order: str, release: int) -> None:
        """An order has ended, up to this release."""
        self._holding.ended(order, release)

    def excuse(self, span_s: float) -> None:
        """The strategist was deaf for this long."""
        self._peers.excuse(span_s)

    def is_judge(self, machine: str, brief: GoalBrief) -> bool:
        """Whether this strategist holds the order of a machine's goal, and so decides; the machine is told if needed."""
        self._holding.on_brief(machine, brief)
        return self._holding.judges(brief.goal)

    # --- messages ---

    def _on_said(self, sender: str, message: Said, now_s: float) -> None:
        if self._holding.on_said(sender, message, now_s):
            self._answer[type(message)](sender, message, now_s)

    def _beat(self, _about: None, now_s: float) -> None:
        if not self._shutdown.begun:
            self._peers.beat(now_s)
            self._holding.look(now_s)

    def _claim(self, order: str, now_s: float) -> None:
        if not self._shutdown.begun:
            self._holding.claim(order, now_s)

    # --- orders ---

    def _on_granted(self, held: OrderHeld, release: OrderReleased | None, now_s: float) -> None:
        """Continue an order that another strategist has begun; a fresh one is handled as with one strategist."""
        is_fresh = held.epoch == 1 and not held.goals and not any(held.arrived) and not held.over
        if is_fresh or release is None or self._book.knows(release.order, release.release):
            return
        order = self._book.take_over(release, held.arrived, held.goals)
        self._life.record(OrderTakenOver(order.id, held.epoch, tuple(order.goals)))
        for goal in order.goals.values():
            if goal.machine:
                self._follow(goal, now_s)
        if held.over >= release.release:
            # It was taken back, or has arrived: that is repeated on request, and nothing is made.
            self._take_back(order)
            return
        for known in (*held.done, *held.goals):
            # No other strategist reports what has arrived while none held the order.
            if known.arrived:
                self._tell_arrived(known, release.items[known.of.item].product)
        self._settle(order, now_s)
        if self._book.order(order.id) is order:
            self._end_if_done(order)

    def _tell_arrived(self, goal: GoalHeld, product: str) -> None:
        of, pieces = goal.of, goal.arrived
        told = GoodsDelivered(goal.goal, of.order, of.item, product, quantity=pieces, delivered=pieces)
        self._life.record(told)

    def _on_lost(self, order: str, now_s: float) -> None:
        """Another strategist goes on with an order: end its goals here."""
        given_up = self._book.give_up(order)
        goals = () if given_up is None else tuple(given_up.goals.values())
        for goal in goals:
            self._unfollow(goal)
            self._auctions.give_up(goal)
        for product in dict.fromkeys(goal.work.product for goal in goals):
            self._auctions.ask_next(product, now_s)

    def _knows(self, order: str) -> bool:
        return self._book.order(order) is not None or self._book.is_over(order)

    def _is_over(self, message: Said) -> bool:
        """Whether a message is about an order that has ended here, and is answered so."""
        order = message.order
        if self._book.order(order) is not None:
            return False
        return not isinstance(message, OrderCancelled) and self._book.knows(order, message.release)
