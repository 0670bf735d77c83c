"""The outbox: brings released orders to the strategist, and revocations and cancellations too.

The bus promises nothing, so all are repeated with growing pauses until they are answered. Nothing is
remembered here that SQL does not know: what was answered is forgotten, and at every reconciliation
(`dray.gateway.orders.reconciliation`) open orders are sent again, with what is still to be delivered, or taken back
again; to a strategist who knows already that is no news.

Where a plant has several strategists all of them are told. They note it, and whoever holds the order answers; when that one is silent,
whoever holds it next does (`dray.protocol.strategist.order_holding`).
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Collection, Iterable
from contextlib import suppress
from heapq import heappop, heappush
from itertools import count

from dray.gateway.live.timescale import TimeScale
from dray.messages import (
    CancellationTaken,
    Message,
    OrderCancelled,
    OrderItem,
    OrderReleased,
    OrderRevoked,
    OrderTaken,
    PartDefinition,
    ProductDefinition,
    RevocationTaken,
)
from dray.messages.keys import STRATEGIST
from dray.store.orders.orders import Order
from dray.store.orders.progress import OPEN, OrderStatus

PAUSE_S = (0.5, 15.0)
"""Wall seconds before the first repetition, and between later ones at most; it doubles. The strategist
may be away for hours, and should have its orders soon after it is back."""

SAID_A_TURN = 400
TURN_S = 1.0
"""So much is said in a second at most. The inbox of a strategist that is busy for ten seconds holds 4,096 messages, and
all the orders of a large plant may be due for a repetition at once."""

NO_DUE_S = 8 * 3600.0
"""Factory seconds within which an order without a due time is wanted: a shift."""

Answer = OrderTaken | CancellationTaken | RevocationTaken
"""What the strategist says to what is repeated here."""

ANSWERS: dict[type[Answer], type[Message]] = {
    OrderTaken: OrderReleased,
    CancellationTaken: OrderCancelled,
    RevocationTaken: OrderRevoked,
}
"""What each of them is the answer to."""

_log = logging.getLogger(__name__)


class Reminder:
    """Something to be said until it is answered."""

    __slots__ = ("due_s", "message", "pause_s")

    def __init__(self, message: Message, now_s: float) -> None:
        self.message = message
        self.due_s, self.pause_s = now_s, PAUSE_S[0]

    def say(self, now_s: float) -> Message:
        """It is said now; the next time is set."""
        self.due_s = now_s + self.pause_s
        self.pause_s = min(2 * self.pause_s, PAUSE_S[1])
        return self.message


class Reminders:
    """What is to be said, again and again, and when. Pure; bounded by the open orders and those just cancelled.

    No more than SAID_A_TURN is said in TURN_S; what finds no place is said in one of the next turns, the oldest first.

    All times are on a clock of the caller's choice that never goes back.
    """

    def __init__(self) -> None:
        self._reminders: dict[str, Reminder] = {}
        self._queue: list[tuple[float, int, str, Reminder]] = []
        """A heap by when they are due; one that was answered meanwhile leaves it when its time has come."""
        self._numbers = count()
        self._turn_s = float("-inf")
        self._said = 0
        """In the turn that has begun at `_turn_s`."""

    def __contains__(self, order: str) -> bool:
        return order in self._reminders

    def add(self, order: str, message: Message, now_s: float) -> None:
        """Say it from now on until it is answered; replaces an older one."""
        self._reminders[order] = Reminder(message, now_s)
        self._put(order, self._reminders[order])

    def get(self, order: str) -> Message | None:
        """What is said again about an order; None for nothing."""
        reminder = self._reminders.get(order)
        return None if reminder is None else reminder.message

    def forget(self, order: str) -> None:
        """Say nothing more about an order; harmless when nothing is said."""
        self._reminders.pop(order, None)

    def awaits(self, answer: Answer) -> bool:
        """Whether something is said again until this answer comes."""
        reminder = self._reminders.get(answer.order)
        return (
            reminder is not None
            and isinstance(reminder.message, ANSWERS[type(answer)])
            and _release(reminder.message) == _release(answer)
            and (_is_over(answer) or _change(answer) >= _change(reminder.message))
        )

    def answered(self, answer: Answer) -> bool:
        """The strategist has answered; returns whether something was waiting for it."""
        if not self.awaits(answer):
            return False
        del self._reminders[answer.order]
        return True

    def due(self, now_s: float) -> list[Message]:
        """What is to be said at this moment; the next time is set."""
        if now_s >= self._turn_s + TURN_S:
            self._turn_s, self._said = now_s, 0
        said = []
        while self._said < SAID_A_TURN and (first_s := self._first_s()) is not None and first_s <= now_s:
            _, _, order, reminder = heappop(self._queue)
            said.append(reminder.say(now_s))
            self._put(order, reminder)
            self._said += 1
        return said

    def next_s(self) -> float | None:
        """When something is to be said; None for never."""
        next_s = self._first_s()
        if next_s is None or self._said < SAID_A_TURN:
            return next_s
        return max(next_s, self._turn_s + TURN_S)

    def _first_s(self) -> float | None:
        """When the first of them is due, however many were said in this turn; None for none."""
        while self._queue and self._reminders.get(self._queue[0][2]) is not self._queue[0][3]:
            heappop(self._queue)
        return self._queue[0][0] if self._queue else None

    def _put(self, order: str, reminder: Reminder) -> None:
        heappush(self._queue, (reminder.due_s, next(self._numbers), order, reminder))


class Outbox:
    """Sends orders.

    Args:
        send: says something to one agent.
        time: the two clocks.
        wall_s: the wall clock.
        products: what this plant can make.
        strategists: all of the plant. Each hears everything, and whoever holds an order answers.
        definition_of: a product as people have defined it; None for one that is made as the plant file says.
        parts_of: the parts below it, as far as people have defined them.
    """

    def __init__(
        self,
        *,
        send: Callable[[str, Message], None],
        time: TimeScale,
        wall_s: Callable[[], float],
        products: Collection[str],
        strategists: Collection[str] = (STRATEGIST,),
        definition_of: Callable[[str], ProductDefinition | None] = lambda _product: None,
        parts_of: Callable[[str], tuple[PartDefinition, ...]] = lambda _product: (),
    ) -> None:
        self._send, self._time, self._wall_s, self._products = send, time, wall_s, products
        self._strategists = strategists
        self._definition_of, self._parts_of = definition_of, parts_of
        self._reminders = Reminders()
        self._strange: set[str] = set()
        """Orders of which it was said that this plant cannot make them: such as an earlier plant file could."""
        self._news = asyncio.Event()
        self._wakes_s: float | None = None
        """When `run` looks again by itself; None for never."""

    def ask(self, orders: Iterable[Order]) -> None:
        """Send open orders again, or take them back again, except those for which an answer is awaited."""
        for order in orders:
            if order.id in self._reminders:
                continue
            if order.being_revoked:
                self.revoke(order)
            else:
                self.release(order)

    def follow(self, order: Order) -> None:
        """Somebody else has changed an order: what is repeated about it must not be what held before."""
        said, kind = self._reminders.get(order.id), _kind(order)
        is_same = said is None or (type(said) is kind and _release(said) in {None, order.releases})
        if said is None or (is_same and (kind is not OrderReleased or _change(said) >= order.change)):
            return
        self._reminders.forget(order.id)
        if kind is OrderCancelled:
            self.cancel(order.id)
        elif kind is not None:
            self.ask([order])

    def release(self, order: Order) -> None:
        """Let the strategist have an order, with what is still to be delivered of it."""
        if strange := order.strange_to(self._products):
            # Panels show it as long as it lasts (`dray.gateway.live.projection.orders`).
            if order.id not in self._strange:
                self._strange.add(order.id)
                _log.error("order %s waits: this plant does not make %s", order.id, ", ".join(strange))
            return
        items = zip(order.items, order.wanted_outstanding, strict=True)
        wanted_s = order.due_at_s if order.wanted_at_s is None else order.wanted_at_s
        due_s = self._time.to_plant_s(self._wall_s() if wanted_s is None else wanted_s)
        message = OrderReleased(
            order=order.id,
            # An item that is delivered keeps its place: goals name items by their index.
            items=tuple(
                OrderItem(
                    item.product,
                    outstanding,
                    self._definition_of(item.product),
                    item.delivered,
                    self._parts_of(item.product),
                )
                for item, outstanding in items
            ),
            due_s=due_s + (NO_DUE_S if wanted_s is None else 0.0),
            release=order.releases,
            change=order.change,
        )
        self._say(order.id, message)

    def revoke(self, order: Order) -> None:
        """Let the strategist stop working at an order, and say what is outstanding of it."""
        self._say(order.id, OrderRevoked(order=order.id, release=order.releases))

    def cancel(self, order: str) -> None:
        """Let the strategist drop an order."""
        self._say(order, OrderCancelled(order=order))

    def awaits(self, answer: Answer) -> bool:
        """Whether the strategist is asked for this answer until it is `answered`."""
        return self._reminders.awaits(answer)

    def answered(self, answer: Answer) -> None:
        """The strategist has answered, and what has to be written down of it is."""
        self._reminders.answered(answer)

    async def run(self) -> None:
        """Repeat what is not answered, until cancelled."""
        clock = asyncio.get_running_loop()
        while True:
            self._news.clear()
            next_s = self._wakes_s = self._reminders.next_s()
            with suppress(TimeoutError):
                async with asyncio.timeout_at(next_s):
                    await self._news.wait()
            self._say_due(clock.time())

    def _say(self, order: str, message: Message) -> None:
        now_s = asyncio.get_running_loop().time()
        self._reminders.add(order, message, now_s)
        self._say_due(now_s)
        next_s = self._reminders.next_s()
        if next_s is not None and (self._wakes_s is None or next_s < self._wakes_s):
            self._news.set()

    def _say_due(self, now_s: float) -> None:
        for message in self._reminders.due(now_s):
            for strategist in self._strategists:
                self._send(strategist, message)


def _kind(order: Order) -> type[OrderReleased | OrderRevoked | OrderCancelled] | None:
    """What the strategist is to be told of an order that is as it is now; None for nothing."""
    if order.status is OrderStatus.CANCELLED:
        return OrderCancelled
    if order.status not in OPEN:
        return None
    return OrderRevoked if order.being_revoked else OrderReleased


def _release(message: Message) -> int | None:
    """Which release of an order something is about; None for all of them."""
    return getattr(message, "release", None)


def _change(message: Message) -> int:
    """Which change of an order something is about; 0 for none."""
    change: int = getattr(message, "change", 0)
    return change


def _is_over(answer: Answer) -> bool:
    """Whether nothing is made of the order any more: then a later change has come too late."""
    return isinstance(answer, OrderTaken) and answer.fulfilled
