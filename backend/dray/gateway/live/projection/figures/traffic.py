"""Traffic: how often vehicles have passed each lane lately.

Counted when a heartbeat says that a vehicle has passed another node: along the way that it had told before,
and from there by the lane that leads on. A heartbeat that was lost may leave a passage uncounted, never one
too many.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import pairwise

import msgspec

from dray.gateway.live.projection.figures.sliding_window import Window
from dray.messages import AtvHeartbeat
from dray.plant.model import Lane

WINDOW_SLOTS = (300.0, 12)
"""An hour of factory time: length of a slot in seconds, and how many."""

WINDOW_S = WINDOW_SLOTS[0] * WINDOW_SLOTS[1]


class LaneTraffic(msgspec.Struct, frozen=True, gc=False):
    """How often one lane was passed, in its direction."""

    start: str
    end: str
    passes: int


class Traffic:
    """Passages per lane over the last hour.

    Args:
        lanes: the plant's; only these are counted, so there is an end to what is remembered.
    """

    def __init__(self, lanes: Iterable[Lane]) -> None:
        self._passes: dict[tuple[str, str], Window] = {}
        for lane in lanes:
            self._passes[lane.start, lane.end] = Window(*WINDOW_SLOTS)
            if lane.both_ways:
                self._passes[lane.end, lane.start] = Window(*WINDOW_SLOTS)

    def follow(self, before: AtvHeartbeat | None, now: AtvHeartbeat) -> None:
        """Count what a vehicle has passed between two heartbeats."""
        if before is None or before.node == now.node or before.incarnation != now.incarnation:
            return
        for lane in pairwise(_passed(before, now.node)):
            window = self._passes.get(lane)
            if window is not None:
                window.add(now.at_s, 1)

    def lanes(self, now_s: float) -> Iterator[LaneTraffic]:
        """Those that were passed at all.

        Args:
            now_s: plant clock.
        """
        for (start, end), window in self._passes.items():
            (passes,) = window.sums(now_s, 1)
            if passes:
                yield LaneTraffic(start, end, int(passes))


def _passed(before: AtvHeartbeat, node: str) -> tuple[str, ...]:
    """The nodes from where it was to `node`; it may have turned off its way right at the beginning."""
    if node in before.way:
        return (before.node, *before.way[: before.way.index(node) + 1])
    return (before.node, node)
