"""A manager who closes lanes, nodes and areas, makes lanes slow or one-way, and opens them again.

Like a gateway he says the whole list again and again, signed, under a number that grows with every decision. Some
closures carry their end, and vehicles open them by their own clocks; the others hold until he withdraws them.
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
"""His name on the bus, and the person in whose name he closes."""

SAY_EVERY_S = 5.0
"""Interval between two repetitions of the list, from which vehicles that were out of reach learn it."""


@dataclass(frozen=True, slots=True)
class Closing:
    """A closure and its times.

    Attributes:
        closure: as vehicles are told of it, without its end.
        at_s: when it is decided (plant clock).
        until_s: when it ends.
        tells_end: whether vehicles are told so from the beginning.
    """

    closure: Closure
    at_s: float
    until_s: float
    tells_end: bool

    @property
    def told(self) -> Closure:
        """The closure as the list has it."""
        return replace(self.closure, until_s=self.until_s) if self.tells_end else self.closure


class FloorManager:
    """Closes and opens.

    Args:
        bus: joined at once.
        clock: the plant's clock.
        keys: the plant's keys.
        authority: signs his lists.
    """

    def __init__(self, bus: Bus, clock: Clock, keys: Keys, authority: SigningKey) -> None:
        self._session = bus.join(NAME, self._on_message)
        self._clock, self._key, self._authority = clock, keys.closures, authority

    async def close(self, closings: Iterable[Closing]) -> None:
        """Carry out all closings, and repeat the present list until cancelled."""
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
