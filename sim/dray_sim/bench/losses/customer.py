"""A customer who orders over REST, and sends every order until it is answered."""

from __future__ import annotations

import asyncio
import http.client
import time
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from datetime import UTC, datetime
from http import HTTPStatus
from urllib.error import HTTPError, URLError
from urllib.request import ProxyHandler, Request, build_opener

import msgspec

from dray.gateway.live.timescale import TimeScale
from dray_sim.people.demand import Order

AGAIN_S = 0.5
"""An order that was not answered is sent again after this long."""

ANSWER_S = 10.0
"""Longest wait for an answer: a gateway that is killed in the middle of one closes the connection at once."""

PATIENCE_S = 120.0
"""Longest time for one order: a killed gateway restarts in some seconds."""

_LATER = frozenset({HTTPStatus.CONFLICT, HTTPStatus.TOO_MANY_REQUESTS, HTTPStatus.SERVICE_UNAVAILABLE})
"""Answers after which the customer tries again later."""


NO_ANSWER = "no answer"


@dataclass(frozen=True, slots=True)
class Placing:
    """The course of placing one order.

    Attributes:
        waited_s: until it was answered, or given up (wall clock).
        before: failures before the answer, by kind: a status, or no answer.
    """

    waited_s: float
    before: Counter[str]


class _Answer(msgspec.Struct):
    """The fields of the answer to an order that are read."""

    id: str


class Customer:
    """Places a demand.

    Args:
        url: the gateway's.
        token: of the customer.
        time: the plant's clock and the wall's.

    Attributes:
        accepted: the id of every order that was answered with 201, by the customer's own reference.
        refused: why others were not, by reference.
        waited_s: how long the answer to the slowest took of those placed at their times (wall clock).
    """

    def __init__(self, url: str, token: str, time: TimeScale) -> None:
        self.accepted: dict[str, str] = {}
        self.refused: dict[str, str] = {}
        self.waited_s = 0.0
        self._url, self._token, self._time = f"{url}/api/orders", token, time
        self._stopped = asyncio.Event()
        # No proxy: the gateway is on this machine.
        self._open: Callable[..., http.client.HTTPResponse] = build_opener(ProxyHandler({})).open

    async def place(self, demand: Iterable[Order], begin_s: float) -> None:
        """Place orders at their times until `stop`; returns when all that were placed are answered.

        Args:
            demand: with times from 0 on.
            begin_s: when that is (plant clock).
        """
        async with asyncio.TaskGroup() as group:
            for order in demand:
                due_s = self._time.to_wall_s(begin_s + order.at_s) - time.time()
                if await self._stopped_within(due_s):
                    return
                group.create_task(self._place(order))

    def stop(self) -> None:
        """Place no more."""
        self._stopped.set()

    async def _stopped_within(self, wait_s: float) -> bool:
        try:
            async with asyncio.timeout(max(0.0, wait_s)):
                await self._stopped.wait()
        except TimeoutError:
            return False
        return True

    async def _place(self, order: Order) -> None:
        placing = await self.order(order)
        self.waited_s = max(self.waited_s, placing.waited_s)

    async def order(self, order: Order) -> Placing:
        """Place one order now, and send it until it is answered."""
        began_s = time.time()
        due_s = began_s + (order.due_s - order.at_s) / self._time.speed
        draft = {
            "customer": "Benchmark",
            "reference": order.id,
            "items": [{"product": item.product, "quantity": item.quantity} for item in order.items],
            "due_at": datetime.fromtimestamp(due_s, UTC).isoformat(),
        }
        body = msgspec.json.encode(draft)
        before: Counter[str] = Counter()
        while came := await asyncio.to_thread(self._send, order.id, body):
            before[came] += 1
            if time.time() > began_s + PATIENCE_S:
                self.refused[order.id] = f"not answered in {PATIENCE_S:.0f} s"
                break
            await asyncio.sleep(AGAIN_S)
        return Placing(time.time() - began_s, before)

    def _send(self, reference: str, body: bytes) -> str:
        """The failure because of which the order should be sent again; empty when it was answered."""
        headers = {
            "Authorization": f"Bearer {self._token}",
            "Content-Type": "application/json",
            "Idempotency-Key": reference,
        }
        request = Request(self._url, body, headers, method="POST")  # noqa: S310 - an address of ours
        try:
            with self._open(request, timeout=ANSWER_S) as answer:
                self.accepted[reference] = msgspec.json.decode(answer.read(), type=_Answer).id
        except HTTPError as error:
            with error:
                if error.code in _LATER:
                    return str(error.code)
                self.refused[reference] = error.read().decode(errors="replace")
        except (URLError, OSError, http.client.HTTPException):
            # The gateway is away, or went away before it answered.
            return NO_ANSWER
        return ""
