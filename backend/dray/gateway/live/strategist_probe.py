"""The strategist probe: whether the plant's strategists are alive.

A single strategist sends no heartbeat and is silent in a quiet factory. The probe therefore asks each for
events with impossible numbers. The strategist answers with its existing numbers, like every agent.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Collection, Mapping

from dray.messages import EventsAsked, Message
from dray.messages.keys import STRATEGIST

ASK_EVERY_S = 10.0
"""Wall seconds between two requests of two small messages each."""

SILENCE_S = 3.5 * ASK_EVERY_S
"""Wall seconds of silence after which a strategist counts as absent: three missing answers."""

BEYOND = 2**53
"""A number that no event has, so the answer holds none."""


class StrategistProbe:
    """Notes when each strategist was heard.

    Args:
        send: sends a message to one agent.
        strategists: all strategists of the plant.
    """

    def __init__(
        self, send: Callable[[str, Message], None], strategists: Collection[str] = (STRATEGIST,)
    ) -> None:
        self._send = send
        self._heard_s: dict[str, float | None] = dict.fromkeys(strategists)
        self._began_s: float | None = None
        """Time of the first request."""

    def heard(self, strategist: str) -> None:
        """Note a message of a strategist."""
        if strategist in self._heard_s:
            self._heard_s[strategist] = _now_s()

    @property
    def silent_s(self) -> float | None:
        """Wall seconds since any strategist was heard; None if none ever was."""
        heard_s = [at_s for at_s in self._heard_s.values() if at_s is not None]
        return _now_s() - max(heard_s) if heard_s else None

    @property
    def there(self) -> bool:
        """Whether any strategist was heard lately: then no order waits."""
        return any(self.presence().values())

    @property
    def away(self) -> tuple[str, ...]:
        """Strategists not heard for `SILENCE_S` after the first request."""
        if self._began_s is None or _now_s() - self._began_s <= SILENCE_S:
            return ()
        return tuple(strategist for strategist, there in self.presence().items() if not there)

    def presence(self) -> Mapping[str, bool]:
        """Per strategist, whether it was heard lately."""
        latest_s = _now_s() - SILENCE_S
        return {
            strategist: at_s is not None and at_s >= latest_s for strategist, at_s in self._heard_s.items()
        }

    async def run(self) -> None:
        """Send requests until cancelled."""
        self._began_s = _now_s()
        while True:
            for strategist in self._heard_s:
                self._send(strategist, EventsAsked(incarnation=1, first=BEYOND, last=BEYOND))
            await asyncio.sleep(ASK_EVERY_S)


def _now_s() -> float:
    return asyncio.get_running_loop().time()
