"""A witness of a run: a scenario can wait for a message, and look back at earlier ones.

It hears every message at once and takes no part. It keeps only the requested kinds, within a bound.
"""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from dray.messages import AtvHeartbeat, Event, MachineHeartbeat, Message

T = TypeVar("T")

KEPT = 100_000
"""Most kept messages of one kind: more than an hour of a busy plant has of the rarer requested kinds."""


@dataclass(frozen=True, slots=True)
class Seen(Generic[T]):
    """One utterance: a message, or the fact in an event."""

    at_s: float
    agent: str
    """The sender."""
    said: T


@dataclass(slots=True, eq=False)
class _Waiter:
    kind: type[Any]
    by: str
    where: Callable[[Any], bool]
    found: asyncio.Future[Seen[Any]]


class Witness:
    """A `Listener` for scenarios.

    Args:
        kinds: classes of facts and messages to keep.

    Attributes:
        atvs, machines: the last heartbeat of each, as it was said.
    """

    def __init__(self, *kinds: type[Any]) -> None:
        self.atvs: dict[str, AtvHeartbeat] = {}
        self.machines: dict[str, MachineHeartbeat] = {}
        self._kept: dict[type[Any], deque[Seen[Any]]] = {kind: deque(maxlen=KEPT) for kind in kinds}
        self._waiters: list[_Waiter] = []

    def on_message(self, at_s: float, sender: str, _address: str, message: Message) -> None:
        """Note one utterance."""
        if type(message) is AtvHeartbeat:
            self.atvs[message.atv] = message
        elif type(message) is MachineHeartbeat:
            self.machines[message.machine] = message
        said = message.fact if type(message) is Event else message
        kept = self._kept.get(type(said))
        if kept is not None:
            kept.append(Seen(at_s, sender, said))
        if self._waiters:
            self._answer(at_s, sender, said)

    def all(self, kind: type[T], *, since_s: float = 0.0) -> list[Seen[T]]:
        """Kept messages of this kind, oldest first."""
        return [seen for seen in self._kept[kind] if seen.at_s >= since_s]

    async def first(
        self,
        kind: type[T],
        where: Callable[[T], bool] = lambda _said: True,
        *,
        by: str = "",
        within_s: float,
    ) -> Seen[T] | None:
        """Wait for the next one of this kind.

        Args:
            kind: class of a fact or a message.
            where: selects messages.
            by: said by this agent; empty for anybody.
            within_s: how long to wait.

        Returns:
            The message, or None after the timeout.
        """
        waiter = _Waiter(kind, by, where, asyncio.get_running_loop().create_future())
        self._waiters.append(waiter)
        try:
            return await asyncio.wait_for(waiter.found, within_s)
        except TimeoutError:
            return None
        finally:
            if waiter in self._waiters:
                self._waiters.remove(waiter)

    def _answer(self, at_s: float, sender: str, said: object) -> None:
        for waiter in [each for each in self._waiters if type(said) is each.kind]:
            if waiter.by in {"", sender} and not waiter.found.done() and waiter.where(said):
                waiter.found.set_result(Seen(at_s, sender, said))
                self._waiters.remove(waiter)
