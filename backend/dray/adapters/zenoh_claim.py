"""A claim: what only one process of a plant may be at a time, and the first keeps.

An agent is another matter: there the latest life counts, since its journal has all that the one before knew.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import zenoh
from zenoh.handlers import Callback

from dray.adapters.crossing import Crossing


class Claim:
    """Holds a claim until it is ended, or its session is closed.

    Whoever meets an earlier claim is told, however late the links to it come about. Two computers whose clocks differ
    by more than the time between their starts take the wrong one for the first.

    Args:
        session: of this process.
        arrivals: to the loop of `lost`.
        key: what is claimed, as a path of chunks without wildcards.
        lost: called when another one was first.
    """

    def __init__(
        self, session: zenoh.Session, arrivals: Crossing, key: str, lost: Callable[[], None]
    ) -> None:
        # Never twice the same.
        self._begun = time.time_ns()
        self._arrivals, self._lost = arrivals, lost
        see = Callback(self._see, indirect=False)
        self._others = session.liveliness().declare_subscriber(f"{key}/*", see, history=True)
        self._token = session.liveliness().declare_token(f"{key}/{self._begun}")

    def end(self) -> None:
        """Leave it to others."""
        self._token.undeclare()
        self._others.undeclare()

    def _see(self, sample: zenoh.Sample) -> None:
        """On Zenoh's threads."""
        begun = str(sample.key_expr).rpartition("/")[2]
        if sample.kind == zenoh.SampleKind.PUT and begun.isdecimal() and int(begun) < self._begun:
            self._arrivals.order(self._lost)
