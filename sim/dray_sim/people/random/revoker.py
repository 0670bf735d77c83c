"""Managers who change their minds: some orders are revoked, at any moment of their lives, and published again."""

from __future__ import annotations

import asyncio
from collections.abc import Iterable
from dataclasses import dataclass

from dray.messages import (
    Message,
    OrderItem,
    OrderReleased,
    OrderRevoked,
    OrderTaken,
    RevocationTaken,
)
from dray.messages.keys import STRATEGIST
from dray.ports import Bus
from dray.protocol.runtime.events import NEVER_S
from dray_sim.clock.loop import VirtualClock
from dray_sim.people.demand import Order

NAME = "revision"
"""Its name on the bus. The name is in the traces of runs, and so it stays."""

AGAIN_S = 5.0
"""Interval between two repetitions of an unanswered message."""


@dataclass(frozen=True, slots=True)
class Revocation:
    """An order that is taken back.

    Attributes:
        order: which, as it was placed.
        times_s: when it is taken back, and when it is published again (plant clock); once or oftener.
    """

    order: Order
    times_s: tuple[tuple[float, float], ...]


class Revoker:
    """Revokes orders, and publishes their outstanding parts again.

    Like the gateway it publishes only after the strategist's answer, with the quantities of that answer and what has
    arrived; and never what was cancelled.

    Args:
        bus: joined at once.
        clock: the plant's clock.
        strategists: receive the messages.
        cancellations: times and orders (see `Canceller.cancel`).
    """

    def __init__(
        self,
        bus: Bus,
        clock: VirtualClock,
        strategists: tuple[str, ...] = (STRATEGIST,),
        cancellations: Iterable[tuple[float, str]] = (),
    ) -> None:
        self._session = bus.join(NAME, self._on_message)
        self._clock, self._strategists = clock, strategists
        self._cancelled_s = {order: at_s for at_s, order in cancellations}
        self._waiting: dict[tuple[type[Message], str, int], asyncio.Future[Message]] = {}

    async def revoke(self, revocations: Iterable[Revocation]) -> None:
        """Revoke and publish all orders; returns when the last one was taken again."""
        async with asyncio.TaskGroup() as group:
            for each in revocations:
                group.create_task(self._revoke(each))

    async def _revoke(self, revocation: Revocation) -> None:
        order, items = revocation.order, revocation.order.items
        for release, (back_s, again_s) in enumerate(revocation.times_s, 1):
            await self._until(back_s)
            back = await self._say(OrderRevoked(order.id, release), RevocationTaken, order.id, release)
            if isinstance(back, RevocationTaken) and back.outstanding:
                items = tuple(
                    OrderItem(item.product, outstanding, arrived=item.quantity - outstanding)
                    for item, outstanding in zip(order.items, back.outstanding, strict=True)
                )
            if not any(item.quantity for item in items):
                return
            await self._until(again_s)
            if self._cancelled_s.get(order.id, NEVER_S) <= self._clock.now_s():
                return
            again = OrderReleased(order=order.id, items=items, due_s=order.due_s, release=release + 1)
            await self._say(again, OrderTaken, order.id, release + 1)

    async def _until(self, at_s: float) -> None:
        await asyncio.sleep(max(0.0, at_s - self._clock.now_s()))

    async def _say(self, message: Message, answer: type[Message], order: str, release: int) -> Message:
        """Say it until it is answered; returns the answer."""
        key = answer, order, release
        heard: asyncio.Future[Message] = asyncio.get_running_loop().create_future()
        self._waiting[key] = heard
        while not heard.done():
            for strategist in self._strategists:
                self._session.send(strategist, message)
            await asyncio.wait((heard,), timeout=AGAIN_S)
        del self._waiting[key]
        return heard.result()

    def _on_message(self, _sender: str, message: Message) -> None:
        if isinstance(message, OrderTaken | RevocationTaken):
            heard = self._waiting.get((type(message), message.order, message.release))
            if heard is not None and not heard.done():
                heard.set_result(message)
