"""Health: the state of each part of a gateway.

A gateway is ready when it can take orders: its database can be read and written, and it is on the bus. A
missing strategist or a late historian is reported, but does not make the gateway unready.
"""

from __future__ import annotations

import asyncio
import time

import msgspec

from dray.errors import UnavailableError
from dray.gateway.live.peer import Peer
from dray.gateway.live.strategist_probe import StrategistProbe
from dray.store import Historian, Store

PATIENCE_S = 2.0
"""Maximum wait for the database's answer in seconds: shorter than the wait of those who ask."""

BEHIND_S = 30.0
"""Lag in seconds from which the historian counts as behind: a burst is written within a second or two."""

DATABASE, BUS, HISTORIAN, STRATEGIST = "database", "bus", "historian", "strategist"

NEEDED = frozenset({DATABASE, BUS})
"""Parts needed to take orders."""


class Part(msgspec.Struct, frozen=True, omit_defaults=True):
    """The state of one part."""

    ok: bool
    reason: str = ""
    """Reason why it is not ok."""
    behind_s: float | None = None
    """Historian only: seconds that the oldest unwritten event has waited."""
    waiting: int | None = None
    """Historian only: number of unwritten events."""
    silent_s: float | None = None
    """Strategist only: seconds since any strategist was heard."""


class Health:
    """Examines the parts.

    Args:
        store: the database.
        peer: the connection to the bus.
        strategist_probe: tells when the strategist was heard.
        historian: None where it runs elsewhere.

    Attributes:
        database_s: duration of the database's last answer; None when there was none.
    """

    def __init__(
        self, store: Store, peer: Peer, strategist_probe: StrategistProbe, historian: Historian | None
    ) -> None:
        self._store, self._peer, self._strategist_probe, self._historian = (
            store,
            peer,
            strategist_probe,
            historian,
        )
        self.database_s: float | None = None

    async def examine(self) -> dict[str, Part]:
        """Every part by its name."""
        parts = {DATABASE: await self._ping(), BUS: self._bus(), STRATEGIST: self._strategist()}
        if self._historian is not None:
            parts[HISTORIAN] = _history(self._historian)
        return parts

    async def _ping(self) -> Part:
        began_s, self.database_s = time.perf_counter(), None
        try:
            async with asyncio.timeout(PATIENCE_S), self._store.read() as work:
                await work.ping()
        except UnavailableError:
            return Part(ok=False, reason="it does not answer")
        except TimeoutError:
            return Part(ok=False, reason=f"it has not answered within {PATIENCE_S:g} s")
        self.database_s = time.perf_counter() - began_s
        if self._historian is not None and self._historian.failing:
            return Part(ok=False, reason="it cannot be written")
        return Part(ok=True)

    def _bus(self) -> Part:
        return Part(ok=True) if self._peer.joined else Part(ok=False, reason="the gateway is not on it")

    def _strategist(self) -> Part:
        silent_s = self._strategist_probe.silent_s
        if silent_s is None:
            return Part(ok=False, reason="nothing was heard of it yet")
        silent_s = round(silent_s, 1)
        away = self._strategist_probe.away
        if not self._strategist_probe.there:
            return Part(ok=False, reason="nothing is heard of it; orders wait for it", silent_s=silent_s)
        if away:
            reason = f"nothing is heard of {', '.join(away)}; the others go on with its orders"
            return Part(ok=True, reason=reason, silent_s=silent_s)
        return Part(ok=True, silent_s=silent_s)


def _history(historian: Historian) -> Part:
    behind_s, waiting = round(historian.behind_s, 1), historian.waiting
    if historian.failing:
        reason = "it cannot write to the database"
    elif behind_s > BEHIND_S:
        reason = "it does not keep up"
    else:
        reason = ""
    return Part(ok=not reason, reason=reason, behind_s=behind_s, waiting=waiting)
