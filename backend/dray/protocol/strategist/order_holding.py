"""Several strategists: which of them holds an order, and which goes on with it if the holder is silent.

All strategists hear all messages about orders. A strategist's bid is its number of orders in work, in its
heartbeats. The lowest bidder claims the order at the gate, each other one a second later. The gate grants the order
to one, with an epoch, and from then on admits its goals only for that holder. The others note the order, as
secondaries note a task. If the holder is silent for PEER_SILENCE_S, they claim the order in the same turns, with
the next epoch. The gate tells the new holder the arrivals and the open goals; machines go on with these, and only
the rest is put up anew. The gate is also told when an order has ended. A returning strategist learns from the gate
what it does not hold any more. One that returns without its notes reports that, and others claim its orders.

    NOTED --claimed, granted--> HELD --has ended--> forgotten
      ^                          |
      +-- another one holds it, with a higher epoch --+

A noted order is forgotten, too, when its holder reports its end.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from msgspec import UNSET
from msgspec.structs import replace

from dray.body import HoldOrder
from dray.body.gate import EVERY_RELEASE
from dray.memory import Memory, OrderNoted
from dray.messages import Event, GoalBrief, HolderChanged, OrderCancelled, OrderReleased, OrderRevoked
from dray.messages.base import COUNT_MAX
from dray.messages.fact import MemoryLost, OrderDropped, OrderFulfilled, OrderReturned
from dray.messages.gate import OrderHeld
from dray.messages.overtaken import LatestNumbers
from dray.protocol.runtime.bounded_map import BoundedMap
from dray.protocol.runtime.events import NEVER_S, Commit
from dray.protocol.runtime.life import Change, Life
from dray.protocol.strategist.order_book import ENDED_KEPT, ORDERS_MAX, OrderBook
from dray.protocol.strategist.peers import Peers

TURN_S = 1.0
"""Delay of a claim per lower bidder (s): by then that one has asked the gate."""

REPORTED_S = 10.0
"""Time in which a machine is told who holds an order by the gate's last report (s): two heartbeats of an idle machine."""

CLAIM = "claim"
"""Alarm of a claim, by order."""

GOAL_NAME = re.compile(r"s\d+r\d+-\d+\.\d+$")
"""Suffix of a goal's name after the order: strategist, life, item and number."""

Said = OrderReleased | OrderCancelled | OrderRevoked
"""Messages about an order."""


def life_of(agent: str, incarnation: int, others: Sequence[str]) -> str:
    """Suffix of a strategist's goal names: different for every strategist and every life."""
    return f"s{sorted((agent, *others)).index(agent) + 1}r{incarnation}"


@dataclass(frozen=True, slots=True)
class OrderGranted(Change):
    """The gate has granted an order to this strategist.

    Attributes:
        held: the gate's report.
        release: its last release; None if unknown.
    """

    held: OrderHeld
    release: OrderReleased | None


@dataclass(frozen=True, slots=True)
class OrderLost(Change):
    """Another strategist holds an order that was held here."""

    order: str


@dataclass(frozen=True, slots=True)
class OrderHeard(Change):
    """A message about an order is to be answered here: the order is held here, or has ended here."""

    sender: str
    message: Said


class OrderHolding:
    """The holding of orders of one strategist among several.

    Args:
        peers: the other strategists.
        life: the agent's life; alarms are named ``(CLAIM, order)``. It notes `OrderGranted`, `OrderLost` and `OrderHeard`.
        book: the orders that the strategist has in work, and those that have ended.
    """

    def __init__(self, peers: Peers, life: Life, book: OrderBook) -> None:
        self._agent, self._peers, self._life, self._book = life.agent, peers, life, book
        self._held: BoundedMap[str, int] = BoundedMap(ENDED_KEPT)
        """Epochs of the orders that this strategist holds, including ended ones."""
        self._reported_s: BoundedMap[str, float] = BoundedMap(ORDERS_MAX)
        """By order: when the gate last reported that it is held here."""
        self._noted: dict[str, OrderNoted] = {}
        """Orders that have not ended, with any holder."""
        self._said: LatestNumbers[str] = LatestNumbers(ORDERS_MAX)
        """By noted order: the newest release and change."""
        self._waiting: BoundedMap[str, tuple[str, Said]] = BoundedMap(ORDERS_MAX)
        """The last unanswered message about orders that are not held here."""
        self._unwritten: dict[str, None] = {}

    def start(self, held: Mapping[str, int], now_s: float) -> None:
        """Continue the held orders by the gate's report; the gate is asked about unknown ones."""
        self._held.update({order: epoch for order, epoch in held.items() if self._knows(order)})
        for order, noted in self._noted.items():
            if order in self._held:
                continue
            if order in held:
                self._life.instruct(HoldOrder(order, held[order]))
            elif noted.holder in ("", self._agent):
                self._note(order, replace(noted, holder="", epoch=0))
                self._take_turn(order, now_s)

    def restore(self, memory: Memory) -> None:
        """Restore the notes of earlier lives."""
        for note in memory.values():
            if isinstance(note, OrderNoted):
                self._noted[note.release.order] = note

    def commits(self) -> list[Commit]:
        """The changes since the last call."""
        commits = [Commit(self._noted.get(order), f"{order} noted") for order in self._unwritten]
        self._unwritten.clear()
        return commits

    def epoch(self, order: str) -> int:
        """The epoch with which an order is held here; 0 if it is not."""
        return self._held.get(order, 0)

    def judges(self, goal: str) -> bool:
        """Whether this strategist decides about a goal that is not open here, because it holds the order."""
        return GOAL_NAME.sub("", goal) in self._held

    def ended(self, order: str, release: int) -> None:
        """An order has ended, up to this release; the gate tells a later holder."""
        self._forget(order, release)
        if order in self._held:
            self._life.instruct(HoldOrder(order, self._held[order], release))

    def made_again(self, order: str, release: int) -> None:
        """A release is made although it was said to have ended; the gate tells a later holder."""
        if order in self._held:
            self._life.instruct(HoldOrder(order, self._held[order], again=release))

    # --- messages ---

    def on_said(self, sender: str, message: Said, now_s: float) -> None:
        """Handle a message about an order."""
        order = message.order
        if self._is_over(message):
            self._life.note(OrderHeard(sender, message))
            return
        noted = self._noted.get(order)
        if isinstance(message, OrderReleased) and (noted is None or self._is_news(message, noted, now_s)):
            before = noted or OrderNoted(message, sender)
            self._note(order, replace(before, release=message, asker=sender))
        if order in self._held:
            self._life.note(OrderHeard(sender, message))
            return
        self._waiting[order] = (sender, message)
        if noted is None or not noted.holder or self._peers.is_silent(noted.holder, now_s):
            self._take_turn(order, now_s)
        else:
            self._life.ignore("a message about an order that another strategist holds")

    def on_event(self, sender: str, event: Event, now_s: float) -> None:
        """Another strategist reports that an order has ended, or that it has lost its notes."""
        fact = event.fact
        if isinstance(fact, MemoryLost):
            for order, noted in list(self._noted.items()):
                if noted.holder == sender and order not in self._held:
                    self._note(order, replace(noted, holder=""))
                    self._take_turn(order, now_s)
        elif isinstance(fact, OrderFulfilled | OrderDropped | OrderReturned) and fact.order not in self._held:
            self._forget(fact.order, fact.release if isinstance(fact, OrderReturned) else EVERY_RELEASE)
            self._waiting.pop(fact.order, None)
            self._life.cancel((CLAIM, fact.order))

    def on_brief(self, machine: str, brief: GoalBrief, now_s: float) -> None:
        """A machine names a goal: tell it the holder if it obeys another strategist.

        If it obeys one with as high an epoch, the gate is asked first: it may have another holder, or a thief has spoken.
        """
        order = GOAL_NAME.sub("", brief.goal)
        ours, told = self._held.get(order), 1 if brief.held is UNSET else brief.held
        if ours is None or (told == ours and brief.holder in (UNSET, self._agent)):
            return
        if told < ours or now_s - self._reported_s.get(order, -NEVER_S) <= REPORTED_S:
            self._life.send(machine, HolderChanged(order, ours))
        else:
            self._life.instruct(HoldOrder(order, ours))

    def look(self, now_s: float) -> None:
        """Take a turn for the orders of silent strategists."""
        if self._peers.any_silent(now_s):
            for order, noted in self._noted.items():
                if order not in self._held and self._peers.is_silent(noted.holder, now_s):
                    self._take_turn(order, now_s)

    def claim(self, order: str, now_s: float) -> None:
        """The turn has come: ask the gate."""
        noted = self._noted.get(order)
        if order in self._held or (noted is not None and not self._can_take(noted.release)):
            return
        if noted is not None and noted.holder:
            if self._peers.is_silent(noted.holder, now_s):
                self._life.instruct(HoldOrder(order, _next(noted.epoch)))
        elif noted is not None or order in self._waiting:
            self._life.instruct(HoldOrder(order, 1 if noted is None else _next(noted.epoch)))

    def on_held(self, report: OrderHeld, now_s: float) -> None:
        """The gate reports the holder of an order."""
        order, noted = report.order, self._noted.get(report.order)
        if noted is not None and (noted.holder, noted.epoch) != (report.holder, report.epoch):
            self._note(order, replace(noted, holder=report.holder, epoch=report.epoch))
        if report.holder != self._agent:
            self._forget(order, report.over)
            if self._held.pop(order, None) is not None:
                self._life.note(OrderLost(order))
            return
        self._reported_s[order] = now_s
        if self._held.get(order) != report.epoch:
            self._held[order] = report.epoch
            self._life.note(OrderGranted(report, None if noted is None else noted.release))
        if order in self._waiting:
            self._life.note(OrderHeard(*self._waiting.pop(order)))
        elif noted is not None:
            self._life.note(OrderHeard(noted.asker, noted.release))

    # --- internals ---

    def _knows(self, order: str) -> bool:
        return self._book.order(order) is not None or self._book.is_over(order)

    def _is_over(self, message: Said) -> bool:
        """Whether a message is about an order that has ended here, and is answered so."""
        order = message.order
        if self._book.order(order) is not None:
            return False
        return not isinstance(message, OrderCancelled) and self._book.knows(order, message.release)

    def _is_news(self, message: OrderReleased, noted: OrderNoted, now_s: float) -> bool:
        """Whether a release or change replaces the noted one: a later one, or one whose gateways do not repeat the noted one any more."""
        said, known = (message.release, message.change), (noted.release.release, noted.release.change)
        return self._said.of(message.order, known, now_s).stands(said, now_s) and said != known

    def _can_take(self, release: OrderReleased) -> bool:
        """Whether an order can be made, and there is room for it."""
        return not self._book.is_full and all(map(self._book.can_be_made, release.items))

    def _forget(self, order: str, release: int) -> None:
        noted = self._noted.get(order)
        if noted is not None and noted.release.release <= release:
            del self._noted[order]
            self._unwritten[order] = None

    def _note(self, order: str, noted: OrderNoted) -> None:
        if order in self._noted or len(self._noted) < ORDERS_MAX:
            self._noted[order] = noted
            self._unwritten[order] = None

    def _take_turn(self, order: str, now_s: float) -> None:
        """Claim an order after all lower bidders."""
        if not self._life.awaits((CLAIM, order)):
            before = self._peers.before(order, now_s)
            self._life.alarm((CLAIM, order), now_s + before * TURN_S)


def _next(epoch: int) -> int:
    """The epoch with which an order is claimed; a thief of the gate's certificate may have reported the last one."""
    return min(epoch + 1, COUNT_MAX)
