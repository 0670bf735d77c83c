"""Impostors: agents that speak in a vehicle's name without its key. Their requests change nothing, and people are told."""

from __future__ import annotations

from dray.messages.fact import NameMisused
from dray.protocol.runtime.life import Life
from dray.protocol.runtime.throttle import Throttle

ANOTHERS_KEY = "a request without the signature of the vehicle that holds places under this name"


class Impostors:
    """Reports impostors to people, for all tables of one agent."""

    def __init__(self, life: Life) -> None:
        self._life = life
        self._throttle = Throttle()

    def tell(self, atv: str, now_s: float) -> None:
        """Report a request in this vehicle's name that is not its own."""
        self._life.ignore(ANOTHERS_KEY)
        if self._throttle.passes(atv, now_s):
            self._life.record(NameMisused(atv))
