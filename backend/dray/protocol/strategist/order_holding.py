"""Several strategists: who holds which order, and who goes on with it when its holder is silent.

All of them hear what is said of an order. The number of orders that each has in work is its bid, in its heartbeats; who bids least
claims the order at the gate, the others a second later each. The gate lets one of them hold it, with an epoch, and from then on admits
its goals on that one's word alone. The others note the order, as secondaries note a task. When its holder is silent for
PEER_SILENCE_S they claim it in the same turns, with the next epoch. The gate tells the new holder what has arrived and which goals are open;
machines go on with these, and only what no goal is left for is put up anew. That an order has ended is told to the gate, too. Who comes
back senses at the gate what it does not hold any more, and gives it up. Who comes back without its notes says so, and others claim what it holds.

    NOTED --claimed, granted--> HELD --has ended--> forgotten
      ^                          |
      +-- another one holds it, with a higher epoch --+

What is noted is forgotten, too, when its holder tells that it has ended.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence

from msgspec import UNSET
from msgspec.structs import replace

from dray.body import HoldOrder
from dray.body.gate import EVERY_RELEASE
from dray.memory import Memory, OrderNoted
from dray.messages import Event, GoalBrief, HolderChanged, OrderCancelled, OrderReleased, OrderRevoked
from dray.messages.fact import MemoryLost, OrderDropped, OrderFulfilled, OrderReturned
from dray.messages.gate import OrderHeld
from dray.protocol.runtime.bounded_map import BoundedMap
from dray.protocol.runtime.events import Commit
from dray.protocol.runtime.life import Life
from dray.protocol.strategist.order_book import ENDED_KEPT, ORDERS_MAX
from dray.protocol.strategist.peers import Peers

TURN_S = 1.0
"""By so much those who bid more claim later: by then who bids less has asked the gate."""

CLAIM = "claim"
"""The alarm for claiming an order, by order."""

GOAL_NAME = re.compile(r"s\d+r\d+-\d+\.\d+$")
"""What follows the order in the name of a goal: which strategist, its life, the item, a number."""

Said = OrderReleased | OrderCancelled | OrderRevoked
"""What is said of an order."""


def life_of(agent: str, incarnation: int, others: Sequence[str]) -> str:
    """What marks the names of a strategist's goals: no two strategists give the same, nor two lives of one."""
    return f"s{sorted((agent, *others)).index(agent) + 1}r{incarnation}"


class OrderHolding:
    """For one strategist among several.

    Args:
        agent: which.
        peers: the others.
        life: its agent's; its alarms are named ``(CLAIM, order)``.
        is_over: whether what was said is of an order that has ended here, and can be answered.
        can_take: whether an order can be made, and there is room for it.
        granted: called with what the gate tells of an order that is held from now on, how it was said last (None where that is not
            known), and now_s.
        lost: called with an order that another one holds, and now_s.
        heard: called with sender, message and now_s: what was said of an order that is held from now on.
    """

    def __init__(
        self,
        agent: str,
        peers: Peers,
        life: Life,
        is_over: Callable[[Said], bool],
        can_take: Callable[[OrderReleased], bool],
        granted: Callable[[OrderHeld, OrderReleased | None, float], None],
        lost: Callable[[str, float], None],
        heard: Callable[[str, Said, float], None],
    ) -> None:
        self._agent, self._peers, self._life = agent, peers, life
        self._is_over, self._can_take = is_over, can_take
        self._granted, self._lost, self._heard = granted, lost, heard
        self._held: BoundedMap[str, int] = BoundedMap(ENDED_KEPT)
        """Orders that this one holds, with their epochs; those that have ended, too."""
        self._noted: dict[str, OrderNoted] = {}
        """Orders that have not ended, whoever holds them."""
        self._waiting: BoundedMap[str, tuple[str, Said]] = BoundedMap(ORDERS_MAX)
        """What was said last of orders that are not held here, and is not answered."""
        self._unwritten: dict[str, None] = {}

    def start(self, held: Mapping[str, int], known: Callable[[str], bool], now_s: float) -> None:
        """Go on with the orders that the gate says are held here; those that the notes do not `know` are asked for."""
        self._held.update({order: epoch for order, epoch in held.items() if known(order)})
        for order, noted in self._noted.items():
            if order in self._held:
                continue
            if order in held:
                self._life.instruct(HoldOrder(order, held[order]))
            elif noted.holder in ("", self._agent):
                self._note(order, replace(noted, holder="", epoch=0))
                self._take_turn(order, now_s)

    def restore(self, memory: Memory) -> None:
        """Take up what earlier lives have noted."""
        for note in memory.values():
            if isinstance(note, OrderNoted):
                self._noted[note.release.order] = note

    def commits(self) -> list[Commit]:
        """What has changed since this was asked for last."""
        commits = [Commit(self._noted.get(order), f"{order} noted") for order in self._unwritten]
        self._unwritten.clear()
        return commits

    def epoch(self, order: str) -> int:
        """With which an order is held here; 0 when it is not."""
        return self._held.get(order, 0)

    def judges(self, goal: str) -> bool:
        """Whether a goal that is not open here is for this one to end: its order is held here."""
        return GOAL_NAME.sub("", goal) in self._held

    def ended(self, order: str, release: int) -> None:
        """Nothing is to be done any more for an order, up to this release; whoever takes it over hears so from the gate."""
        self._forget(order, release)
        if order in self._held:
            self._life.instruct(HoldOrder(order, self._held[order], release))

    # --- what is heard ---

    def on_said(self, sender: str, message: Said, now_s: float) -> bool:
        """Something was said of an order; returns whether that is for this one to answer, at once."""
        order = message.order
        if self._is_over(message):
            return True
        noted = self._noted.get(order)
        if isinstance(message, OrderReleased) and (
            noted is None or (message.release, message.change) > (noted.release.release, noted.release.change)
        ):
            before = noted or OrderNoted(message, sender)
            self._note(order, replace(before, release=message, asker=sender))
        if order in self._held:
            return True
        self._waiting[order] = (sender, message)
        if noted is None or not noted.holder or self._peers.is_silent(noted.holder, now_s):
            self._take_turn(order, now_s)
        else:
            self._life.ignore("what is said of an order that another strategist holds")
        return False

    def on_event(self, sender: str, event: Event, now_s: float) -> None:
        """Another one tells that an order has ended, or that it has forgotten all that it holds."""
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

    def on_brief(self, machine: str, brief: GoalBrief) -> None:
        """A machine tells of a goal: one that obeys another strategist hears who holds the order."""
        order = GOAL_NAME.sub("", brief.goal)
        if self._held.get(order, 1) > (1 if brief.held is UNSET else brief.held):
            self._life.send(machine, HolderChanged(order, self._held[order]))

    def look(self, now_s: float) -> None:
        """Take one's turn for the orders of those who are silent."""
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
                self._life.instruct(HoldOrder(order, noted.epoch + 1))
        elif noted is not None or order in self._waiting:
            self._life.instruct(HoldOrder(order, 1 if noted is None else noted.epoch + 1))

    def on_held(self, report: OrderHeld, now_s: float) -> None:
        """The gate tells who holds an order."""
        order, noted = report.order, self._noted.get(report.order)
        if noted is not None and (noted.holder, noted.epoch) != (report.holder, report.epoch):
            self._note(order, replace(noted, holder=report.holder, epoch=report.epoch))
        if report.holder != self._agent:
            self._forget(order, report.over)
            if self._held.pop(order, None) is not None:
                self._lost(order, now_s)
            return
        if self._held.get(order) != report.epoch:
            self._held[order] = report.epoch
            self._granted(report, None if noted is None else noted.release, now_s)
        if order in self._waiting:
            self._heard(*self._waiting.pop(order), now_s)
        elif noted is not None:
            self._heard(noted.asker, noted.release, now_s)

    # --- how it is done ---

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
        """Claim an order after all who bid less."""
        if not self._life.awaits((CLAIM, order)):
            before = self._peers.before(order, now_s)
            self._life.alarm((CLAIM, order), now_s + before * TURN_S)
