"""The strategist probe: whether the strategist is there.

It has no heartbeat, and in a quiet factory it tells nothing. So it is asked now and then for events that
cannot be; it answers with the numbers that there are, as every agent does.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable

from dray.messages import EventsAsked, Message
from dray.messages.keys import STRATEGIST

ASK_EVERY_S = 10.0
"""Wall seconds between two questions: two small messages each."""

SILENCE_S = 3.5 * ASK_EVERY_S
"""Unheard for so long, it is taken for absent: three answers are missing."""

BEYOND = 2**53
"""No event has this number: the answer holds none."""


class StrategistProbe:
    """Keeps in mind when the strategist was heard.

    Args:
        send: says something to one agent.
    """

    def __init__(self, send: Callable[[str, Message], None]) -> None:
        self._send = send
        self._heard_s: float | None = None

    def heard(self) -> None:
        """It has said something."""
        self._heard_s = _now_s()

    @property
    def silent_s(self) -> float | None:
        """Wall seconds since it was heard; None when it never was."""
        return None if self._heard_s is None else _now_s() - self._heard_s

    @property
    def there(self) -> bool:
        """Whether it was heard lately."""
        silent_s = self.silent_s
        return silent_s is not None and silent_s <= SILENCE_S

    async def run(self) -> None:
        """Ask, until cancelled."""
        while True:
            self._send(STRATEGIST, EventsAsked(incarnation=1, first=BEYOND, last=BEYOND))
            await asyncio.sleep(ASK_EVERY_S)


def _now_s() -> float:
    return asyncio.get_running_loop().time()
