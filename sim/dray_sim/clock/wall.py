"""The clock on the wall of a process that holds a simulated factory and the gateway which shows it.

Both use one clock, so that neither runs ahead of the other. It paces the factory's loop, and the gateway shows all
times in it.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from selectors import BaseSelector, DefaultSelector, SelectorKey
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from dray.adapters.crossing import Crossing
    from dray_sim.clock.loop import VirtualLoop

Met = Callable[["VirtualLoop", "Crossing"], None]
"""Called with the factory's loop, and with the crossing from there to the gateway's."""


UNHEARD = 100
"""Most messages that wait for the gateway while the clock hurries: it must hear all of them, and soon."""

GIVE_WAY_S = 0.002
"""Real seconds that the factory leaves to a gateway with more to take."""


def _nothing_more(_loop: VirtualLoop, _outbound: Crossing) -> None:
    """Do nothing: a clock that goes by itself needs no help."""


def _as_ever(_hurries: bool) -> None:
    """Do nothing: this clock cannot hurry."""


@dataclass(frozen=True, slots=True)
class Wall:
    """A clock on the wall.

    Attributes:
        now_s: unix seconds; never goes back; callable from any thread.
        selector: with which the factory's loop waits; None for the system's best one.
        met: told on the gateway's loop, once that and the factory know one another.
        hurry: whether time in which the factory has nothing to do is passed over; called on the factory's thread.
        stands: whether the factory's clock stands where its computer is too slow for it; else it catches up (`VirtualLoop.stood`).
    """

    now_s: Callable[[], float]
    selector: BaseSelector | None = None
    met: Met = _nothing_more
    hurry: Callable[[bool], None] = _as_ever
    stands: bool = False


def steady_wall() -> Wall:
    """The computer's clock as of now, without later adjustments of it."""
    ahead_s = time.time() - time.monotonic()
    return Wall(lambda: ahead_s + time.monotonic())


class HurryingClock:
    """The computer's clock, which skips the factory's sleeps while it hurries, and so runs ahead.

    The events in the factory and their order stay the same. The gateway, which goes by this clock, too, hears it
    sooner.

    Attributes:
        wall: hand it to the factory and the gateway.
    """

    def __init__(self) -> None:
        self._ahead_s = time.time() - time.monotonic()
        self._hurries = False
        self._outbound: Crossing | None = None
        self.wall = Wall(self._now_s, _Sleeper(self.pass_over), self._meet, self._hurry, stands=True)

    def pass_over(self, sleep_s: float | None) -> float | None:
        """How long the factory really sleeps instead of `sleep_s` (real seconds; None for until something comes)."""
        if not self._hurries or not sleep_s:
            return sleep_s
        if self._outbound is not None and self._outbound.waiting > UNHEARD:
            return min(sleep_s, GIVE_WAY_S)
        self._ahead_s += sleep_s
        return 0.0

    def _now_s(self) -> float:
        return self._ahead_s + time.monotonic()

    def _meet(self, _loop: VirtualLoop, outbound: Crossing) -> None:
        self._outbound = outbound

    def _hurry(self, hurries: bool) -> None:
        self._hurries = hurries


class _Sleeper(DefaultSelector):
    """Sleeps as long as it is told.

    Args:
        really_s: the real duration of a sleep.
    """

    def __init__(self, really_s: Callable[[float | None], float | None]) -> None:
        super().__init__()
        self._really_s = really_s

    def select(self, timeout: float | None = None) -> list[tuple[SelectorKey, int]]:
        return super().select(self._really_s(timeout))
