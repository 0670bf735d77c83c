"""A simulated manager: closes lanes, nodes and areas, makes lanes slow or one-way, and opens them again.

The manager repeats the whole list like a gateway: signed, with a number that grows with every decision. A closure with
an end is opened by each vehicle's own clock. Any other closure holds until the manager withdraws it.
"""

from __future__ import annotations

import asyncio
from collections.abc import Iterable
from dataclasses import dataclass

from msgspec.structs import replace

from dray.adapters.security.signing import SigningKey
from dray.messages import Closure, Message
from dray.messages.keys import Keys
from dray.ports import Bus, Clock

NAME = "floor-manager"
"""The manager's name on the bus, and in the closures."""

SAY_EVERY_S = 5.0
"""Interval of the repetitions (s). Vehicles that were out of reach learn the list from them."""


@dataclass(frozen=True, slots=True)
class Closing:
    """A closure and its times.

    Attributes:
        closure: the closure, without its end.
        at_s: time of the decision (plant clock).
        until_s: end (plant clock).
        tells_end: whether the list names the end.
    """

    closure: Closure
    at_s: float
    until_s: float
    tells_end: bool

    @property
    def told(self) -> Closure:
        """The closure in the form of the list."""
        return replace(self.closure, until_s=self.until_s) if self.tells_end else self.closure


class FloorManager:
    """Carries out planned closures.

    Args:
        bus: the bus; the manager joins it at once.
        clock: the plant's clock.
        keys: the plant's bus keys.
        authority: key that signs the lists.
    """

    def __init__(self, bus: Bus, clock: Clock, keys: Keys, authority: SigningKey) -> None:
        self._session = bus.join(NAME, self._on_message)
        self._clock, self._key, self._authority = clock, keys.closures, authority

    async def close(self, closings: Iterable[Closing]) -> None:
        """Carry out all closings, and repeat the present list until this task is cancelled."""
        closings = tuple(closings)
        changes_s = sorted({each.at_s for each in closings} | {each.until_s for each in closings})
        number = 0
        while True:
            now_s = self._clock.now_s()
            past = sum(at_s <= now_s for at_s in changes_s)
            if past:
                if past != number:
                    number = past
                    held = [each.told for each in closings if each.at_s <= now_s < each.until_s]
                    said = self._authority.close(number, held)
                self._session.publish(self._key, said)
            next_s = min([at_s for at_s in changes_s if at_s > now_s], default=float("inf"))
            await asyncio.sleep(min(SAY_EVERY_S if past else float("inf"), next_s - now_s))

    def _on_message(self, _sender: str, _message: Message) -> None:
        """Ignore all messages."""
