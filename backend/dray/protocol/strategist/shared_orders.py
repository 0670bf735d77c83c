"""The orders that several strategists share: the agent's tables for `order_holding` and `peers`."""

from __future__ import annotations

from collections.abc import Callable
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
from dray.messages.gate import OrderHeld
from dray.messages.keys import Keys
from dray.protocol.runtime.agent import Handler
from dray.protocol.runtime.events import Commit
from dray.protocol.runtime.life import BEAT, Life
from dray.protocol.runtime.shutdown import GracefulShutdown
from dray.protocol.strategist.order_book import OrderBook
from dray.protocol.strategist.order_holding import CLAIM, OrderHolding
from dray.protocol.strategist.peers import Peers


class SharedOrders:
    """The orders of one strategist among several.

    Args:
        keys: the plant's bus keys.
        book: the orders that it has in work.
        life: the agent's life; see `OrderHolding` for the changes that it notes.
        shutdown: of the strategist: while it drains it sends no heartbeats, and claims nothing.
        others: the other strategists.

    Attributes:
        message_handlers, report_handlers, alarms: entries for the strategist's tables.
    """

    def __init__(
        self,
        keys: Keys,
        book: OrderBook,
        life: Life,
        shutdown: GracefulShutdown,
        others: tuple[str, ...],
    ) -> None:
        self._book, self._shutdown = book, shutdown
        self._peers = Peers(others, keys, life, book)
        self._holding = OrderHolding(self._peers, life, book)
        book.held_with = self._holding.epoch
        self.message_handlers: dict[type[Message], Handler] = {
            OrderReleased: self._holding.on_said,
            OrderCancelled: self._holding.on_said,
            OrderRevoked: self._holding.on_said,
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
        self._holding.start(gate.held, now_s)

    def has_ended(self, order: str, release: int) -> None:
        """An order has ended, up to this release."""
        self._holding.ended(order, release)

    def is_made_again(self, order: str, release: int) -> None:
        """A release is made although it was said to have ended."""
        self._holding.made_again(order, release)

    def excuse(self, span_s: float) -> None:
        """The strategist was deaf for this long."""
        self._peers.excuse(span_s)

    def is_judge(self, machine: str, brief: GoalBrief, now_s: float) -> bool:
        """Whether this strategist holds the order of a machine's goal, and so decides; the machine is told if needed."""
        self._holding.on_brief(machine, brief, now_s)
        return self._holding.judges(brief.goal)

    def _beat(self, _about: None, now_s: float) -> None:
        if not self._shutdown.begun:
            self._peers.beat(now_s)
            self._holding.look(now_s)

    def _claim(self, order: str, now_s: float) -> None:
        if not self._shutdown.begun:
            self._holding.claim(order, now_s)
