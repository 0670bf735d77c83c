"""The strategist probe: whether the plant's strategists are there.

One alone has no heartbeat, and in a quiet factory it tells nothing. So each is asked now and then for events that
cannot be; it answers with the numbers that there are, as every agent does.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Collection, Mapping

from dray.messages import EventsAsked, Message
from dray.messages.keys import STRATEGIST

ASK_EVERY_S = 10.0
"""Wall seconds between two questions: two small messages each."""

SILENCE_S = 3.5 * ASK_EVERY_S
"""Unheard for so long, it is taken for absent: three answers are missing."""

BEYOND = 2**53
"""No event has this number: the answer holds none."""


class StrategistProbe:
    """Keeps in mind when each strategist was heard.

    Args:
        send: says something to one agent.
        strategists: all of the plant.
    """

    def __init__(
        self, send: Callable[[str, Message], None], strategists: Collection[str] = (STRATEGIST,)
    ) -> None:
        self._send = send
        self._heard_s: dict[str, float | None] = dict.fromkeys(strategists)
        self._began_s: float | None = None
        """When it was first asked."""

    def heard(self, strategist: str) -> None:
        """It has said something."""
        if strategist in self._heard_s:
            self._heard_s[strategist] = _now_s()

    @property
    def silent_s(self) -> float | None:
        """Wall seconds since any of them was heard; None when none ever was."""
        heard_s = [at_s for at_s in self._heard_s.values() if at_s is not None]
        return _now_s() - max(heard_s) if heard_s else None

    @property
    def there(self) -> bool:
        """Whether any of them was heard lately: then no order waits."""
        return any(self.presence().values())

    @property
    def away(self) -> tuple[str, ...]:
        """Those that were not heard lately, or not at all since they have been asked for that long."""
        if self._began_s is None or _now_s() - self._began_s <= SILENCE_S:
            return ()
        return tuple(strategist for strategist, there in self.presence().items() if not there)

    def presence(self) -> Mapping[str, bool]:
        """Which of them were heard lately."""
        latest_s = _now_s() - SILENCE_S
        return {
            strategist: at_s is not None and at_s >= latest_s for strategist, at_s in self._heard_s.items()
        }

    async def run(self) -> None:
        """Ask, until cancelled."""
        self._began_s = _now_s()
        while True:
            for strategist in self._heard_s:
                self._send(strategist, EventsAsked(incarnation=1, first=BEYOND, last=BEYOND))
            await asyncio.sleep(ASK_EVERY_S)


def _now_s() -> float:
    return asyncio.get_running_loop().time()
