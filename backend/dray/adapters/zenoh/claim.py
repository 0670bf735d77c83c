"""A claim: a role that only one process of a plant may have at a time, and the first keeps.

For an agent, in contrast, the latest life counts, since its journal has the knowledge of the earlier ones.

With certificates a claim is signed, and counts only if its agent matches its name. A process that has seen a claim may
replay it after its end. This is good enough for a simulated floor, and for nothing more important.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import zenoh

from dray.adapters.spares import Spares
from dray.adapters.zenoh.bus import ZenohBus
from dray.adapters.zenoh.tokens import Tokens


class Claim:
    """Holds a claim until it is ended, or its bus is closed.

    A later claimant is told about an earlier claim, however late their link comes about. If two computers' clocks differ by more than
    the time between their starts, the wrong one counts as the first.

    Args:
        bus: the bus of this process.
        name: the claimed role; with certificates, a name in the process's own certificate.
        lost: called on the loop of the bus when another process was first.
    """

    def __init__(self, bus: ZenohBus, name: str, lost: Callable[[], None]) -> None:
        self._bus, self._lost = bus, lost
        self._claims = Tokens(f"{bus.keys.plant}/claim", bus.seals, bus.refuse)
        # Never twice the same. The first claim counts, so the spare is the later one.
        self._own, spare = self._claims.pair_of(name, time.time_ns() // 1000)
        see = bus.on_zenohs_thread(self._see)
        liveliness = bus.inner.liveliness()
        self._others = liveliness.declare_subscriber(self._claims.all_of(name), see, history=True)
        self._token = liveliness.declare_token(self._claims.key(self._own))
        self._spares = Spares(bus.inner)
        self._spares.of_token(self._claims.key(spare))

    def end(self) -> None:
        """Give up the claim."""
        self._spares.end()
        self._token.undeclare()
        self._others.undeclare()

    def _see(self, sample: zenoh.Sample) -> None:
        """On Zenoh's threads."""
        if sample.kind != zenoh.SampleKind.PUT:
            return
        other = self._claims.read(str(sample.key_expr))
        if other is not None and self._own.replaces(other):
            self._bus.arrivals.order(self._lost)
