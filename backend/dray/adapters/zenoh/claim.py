"""A claim: what only one process of a plant may be at a time, and the first keeps.

An agent is another matter: there the latest life counts, since its journal has all that the one before knew.

With certificates a claim is signed, and only that of the agent whose name it has counts. Whoever has seen a claim may
say it again when it has ended: this is good enough for a floor that is simulated, and for nothing that more depends on.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import zenoh

from dray.adapters.zenoh.bus import ZenohBus
from dray.adapters.zenoh.tokens import Tokens


class Claim:
    """Holds a claim until it is ended, or its bus is closed.

    Whoever meets an earlier claim is told, however late the links to it come about. Two computers whose clocks differ
    by more than the time between their starts take the wrong one for the first.

    Args:
        bus: of this process.
        name: what is claimed; with certificates, one that the process's own certificate names.
        lost: called on the loop of the bus when another one was first.
    """

    def __init__(self, bus: ZenohBus, name: str, lost: Callable[[], None]) -> None:
        self._bus, self._lost = bus, lost
        self._claims = Tokens(f"{bus.keys.plant}/claim", bus.seals, bus.refuse)
        # Never twice the same.
        self._own = self._claims.of(name, time.time_ns() // 1000)
        see = bus.on_zenohs_thread(self._see)
        liveliness = bus.inner.liveliness()
        self._others = liveliness.declare_subscriber(self._claims.all_of(name), see, history=True)
        self._token = liveliness.declare_token(self._claims.key(self._own))

    def end(self) -> None:
        """Leave it to others."""
        self._token.undeclare()
        self._others.undeclare()

    def _see(self, sample: zenoh.Sample) -> None:
        """On Zenoh's threads."""
        if sample.kind != zenoh.SampleKind.PUT:
            return
        other = self._claims.read(str(sample.key_expr))
        if other is not None and self._own.replaces(other):
            self._bus.arrivals.order(self._lost)
