"""The outbox: sends released orders, revocations and cancellations to the strategist.

The bus does not guarantee delivery, so messages are repeated with growing pauses until answered. All state
here is also in SQL: answered messages are forgotten. Every reconciliation
(`dray.gateway.orders.reconciliation`) sends open orders again with what is outstanding, or their revocations;
a strategist that knows them ignores that.

Where a plant has several strategists, all get the messages. The holder of an order answers; when it is
silent, the next holder does (`dray.protocol.strategist.order_holding`).
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
"""Wall seconds before the first repetition, and maximum between later ones; the pause doubles. A strategist
may be away for hours, and should get its orders soon after its return."""

SAID_A_TURN = 400
TURN_S = 1.0
"""Maximum messages per turn of one second. The inbox of a strategist that is busy for ten seconds holds 4,096
messages, and all orders of a large plant may need a repetition at once."""

NO_DUE_S = 8 * 3600.0
"""Factory seconds within which an order without a due time is wanted: a shift."""

Answer = OrderTaken | CancellationTaken | RevocationTaken
"""The strategist's answers to repeated messages."""

ANSWERS: dict[type[Answer], type[Message]] = {
    OrderTaken: OrderReleased,
    CancellationTaken: OrderCancelled,
    RevocationTaken: OrderRevoked,
}
"""Answer -> the message that it answers."""

_log = logging.getLogger(__name__)


class Reminder:
    """A message to repeat until it is answered."""

    __slots__ = ("due_s", "message", "pause_s")

    def __init__(self, message: Message, now_s: float) -> None:
        self.message = message
        self.due_s, self.pause_s = now_s, PAUSE_S[0]

    def say(self, now_s: float) -> Message:
        """Return the message and set the time of the next repetition."""
        self.due_s = now_s + self.pause_s
        self.pause_s = min(2 * self.pause_s, PAUSE_S[1])
        return self.message


class Reminders:
    """The messages to repeat, and when. Pure; bounded by open orders and recently cancelled ones.

    At most SAID_A_TURN messages go out in TURN_S; the rest waits for the next turns, oldest first.

    All times are on any clock that never goes back.
    """

    def __init__(self) -> None:
        self._reminders: dict[str, Reminder] = {}
        self._queue: list[tuple[float, int, str, Reminder]] = []
        """A heap by due time; an answered message leaves it when its time comes."""
        self._numbers = count()
        self._turn_s = float("-inf")
        self._said = 0
        """Number of messages sent in the turn that began at `_turn_s`."""

    def __contains__(self, order: str) -> bool:
        return order in self._reminders

    def add(self, order: str, message: Message, now_s: float) -> None:
        """Repeat a message until it is answered; replaces an older one for the order."""
        self._reminders[order] = Reminder(message, now_s)
        self._put(order, self._reminders[order])

    def get(self, order: str) -> Message | None:
        """The message being repeated for an order; None without any."""
        reminder = self._reminders.get(order)
        return None if reminder is None else reminder.message

    def forget(self, order: str) -> None:
        """Stop repeating for an order; harmless when nothing is repeated."""
        self._reminders.pop(order, None)

    def awaits(self, answer: Answer) -> bool:
        """Whether a message is repeated until this answer comes."""
        reminder = self._reminders.get(answer.order)
        return (
            reminder is not None
            and isinstance(reminder.message, ANSWERS[type(answer)])
            and _release(reminder.message) == _release(answer)
            and (_is_over(answer) or _change(answer) >= _change(reminder.message))
        )

    def answered(self, answer: Answer) -> bool:
        """Take the strategist's answer; returns whether a message was waiting for it."""
        if not self.awaits(answer):
            return False
        del self._reminders[answer.order]
        return True

    def due(self, now_s: float) -> list[Message]:
        """The messages due now; sets their next times."""
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
        """When the next message is due; None for never."""
        next_s = self._first_s()
        if next_s is None or self._said < SAID_A_TURN:
            return next_s
        return max(next_s, self._turn_s + TURN_S)

    def _first_s(self) -> float | None:
        """When the first message is due, ignoring the limit per turn; None without any."""
        while self._queue and self._reminders.get(self._queue[0][2]) is not self._queue[0][3]:
            heappop(self._queue)
        return self._queue[0][0] if self._queue else None

    def _put(self, order: str, reminder: Reminder) -> None:
        heappush(self._queue, (reminder.due_s, next(self._numbers), order, reminder))


class Outbox:
    """Sends orders.

    Args:
        send: sends a message to one agent.
        time: plant clock and wall clock.
        wall_s: the wall clock.
        products: products that this plant can make.
        strategists: all strategists of the plant. Each gets everything; the holder of an order answers.
        definition_of: people's definition of a product; None for one of the plant file.
        parts_of: the parts below it that people have defined.
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
        """Orders already logged as impossible in this plant, for example after a change of the plant file."""
        self._news = asyncio.Event()
        self._wakes_s: float | None = None
        """When `run` wakes by itself; None for never."""

    def ask(self, orders: Iterable[Order]) -> None:
        """Send open orders or their revocations again, except those awaiting an answer."""
        for order in orders:
            if order.id in self._reminders:
                continue
            if order.being_revoked:
                self.revoke(order)
            else:
                self.release(order)

    def follow(self, order: Order) -> None:
        """Replace repeated messages about an order that another gateway has changed."""
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
        """Send an order to the strategist, with what is still to be delivered."""
        if strange := order.strange_to(self._products):
            # Panels show it while it lasts (`dray.gateway.live.projection.orders`).
            if order.id not in self._strange:
                self._strange.add(order.id)
                _log.error("order %s waits: this plant does not make %s", order.id, ", ".join(strange))
            return
        items = zip(order.items, order.wanted_outstanding, strict=True)
        wanted_s = order.due_at_s if order.wanted_at_s is None else order.wanted_at_s
        due_s = self._time.to_plant_s(self._wall_s() if wanted_s is None else wanted_s)
        message = OrderReleased(
            order=order.id,
            # A delivered item keeps its place: goals name items by their index.
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
        """Ask the strategist to stop working at an order and to report what is outstanding."""
        self._say(order.id, OrderRevoked(order=order.id, release=order.releases))

    def cancel(self, order: str) -> None:
        """Ask the strategist to drop an order."""
        self._say(order, OrderCancelled(order=order))

    def awaits(self, answer: Answer) -> bool:
        """Whether this answer is awaited and not yet marked as `answered`."""
        return self._reminders.awaits(answer)

    def answered(self, answer: Answer) -> None:
        """Note that the strategist's answer is stored."""
        self._reminders.answered(answer)

    async def run(self) -> None:
        """Repeat unanswered messages until cancelled."""
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
    """The kind of message that an order's present state needs; None for none."""
    if order.status is OrderStatus.CANCELLED:
        return OrderCancelled
    if order.status not in OPEN:
        return None
    return OrderRevoked if order.being_revoked else OrderReleased


def _release(message: Message) -> int | None:
    """The release of an order that a message is about; None for all."""
    return getattr(message, "release", None)


def _change(message: Message) -> int:
    """The change of an order that a message is about; 0 for none."""
    change: int = getattr(message, "change", 0)
    return change


def _is_over(answer: Answer) -> bool:
    """Whether the order has ended, so that a later change is too late."""
    return isinstance(answer, OrderTaken) and answer.fulfilled
