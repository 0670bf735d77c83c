"""The clock on the wall of a process that holds a simulated factory and the gateway which shows it.

Both go by one clock, so that neither runs ahead of the other: the factory's loop is paced by it, and all that the
gateway tells people is told in it.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from selectors import BaseSelector
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from dray.adapters.crossing import Crossing
    from dray_sim.clock.loop import VirtualLoop

Met = Callable[["VirtualLoop", "Crossing"], None]
"""Called with the factory's loop, and with what crosses from there to the gateway's."""


def _nothing_more(_loop: VirtualLoop, _outbound: Crossing) -> None:
    """Nobody moves a clock that goes by itself."""


@dataclass(frozen=True, slots=True)
class Wall:
    """A clock on the wall.

    Attributes:
        now_s: unix seconds; never goes back; callable from any thread.
        selector: what the factory's loop waits with; None for the system's best one.
        met: told on the gateway's loop, once that and the factory know one another.
    """

    now_s: Callable[[], float]
    selector: BaseSelector | None = None
    met: Met = _nothing_more


def steady_wall() -> Wall:
    """The computer's clock as it is now, and then without whatever sets that one."""
    ahead_s = time.time() - time.monotonic()
    return Wall(lambda: ahead_s + time.monotonic())
