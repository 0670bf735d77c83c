"""Traffic: how often vehicles passed each lane, and how long they stood there on their way.

A passage counts when a heartbeat names a node further along the way told before, or the next lane from there.
A lost heartbeat may leave a passage uncounted, but never adds one. A vehicle waits when two heartbeats in a
row place it standing on the same lane with a way ahead, for any reason.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import pairwise

from dray.gateway.live.projection.figures.sliding_window import Window
from dray.gateway.live.projection.figures.time_use import SILENCE_S
from dray.messages import AtvHeartbeat
from dray.plant.model import Lane
from dray.store.factory.lane_traffic import LaneTraffic

WINDOW_SLOTS = (300.0, 12)
"""One hour of factory time: slot length in seconds, and number of slots."""

WINDOW_S = WINDOW_SLOTS[0] * WINDOW_SLOTS[1]

Ends = tuple[str, str]
"""A lane with its direction, by its nodes."""

LaneTotals = dict[Ends, LaneTraffic]


class _Lane:
    """The traffic of one lane: since the beginning, and over the last hour."""

    __slots__ = ("passes", "passes_lately", "waited_lately_s", "waited_s", "waits", "waits_lately")

    def __init__(self) -> None:
        self.passes = self.waits = 0
        self.waited_s = 0.0
        self.passes_lately, self.waits_lately = Window(*WINDOW_SLOTS), Window(*WINDOW_SLOTS)
        self.waited_lately_s = Window(*WINDOW_SLOTS)

    def passed(self, at_s: float) -> None:
        self.passes += 1
        self.passes_lately.add(at_s, 1)

    def waited(self, at_s: float, wait_s: float, *, is_new: bool) -> None:
        self.waited_s += wait_s
        self.waited_lately_s.add(at_s, wait_s)
        if is_new:
            self.waits += 1
            self.waits_lately.add(at_s, 1)


class Traffic:
    """The traffic of every lane.

    Args:
        lanes: the plant's lanes; only these are counted, which bounds the memory.
    """

    def __init__(self, lanes: Iterable[Lane]) -> None:
        self._lanes: dict[Ends, _Lane] = {}
        for lane in lanes:
            self._lanes[lane.start, lane.end] = _Lane()
            if lane.both_ways:
                self._lanes[lane.end, lane.start] = _Lane()
        self._waiting: dict[str, Ends] = {}
        """Per vehicle, the lane where it waits. Bounded because only admitted vehicles are followed."""

    def follow(self, before: AtvHeartbeat | None, now: AtvHeartbeat) -> None:
        """Count the lanes that a vehicle passed between two heartbeats, and its wait."""
        if before is None or before.incarnation != now.incarnation:
            self._waiting.pop(now.atv, None)
            return
        if before.node != now.node:
            for ends in pairwise(_passed(before, now.node)):
                if (lane := self._lanes.get(ends)) is not None:
                    lane.passed(now.at_s)
        if now.speed_mps:
            if self._waiting:
                self._waiting.pop(now.atv, None)
            return
        here = _standing(now)
        wait_s = now.at_s - before.at_s
        if here is None or here != _standing(before) or not 0.0 < wait_s <= SILENCE_S:
            self._waiting.pop(now.atv, None)
        elif (lane := self._lanes.get(here)) is not None:
            lane.waited(now.at_s, wait_s, is_new=self._waiting.get(now.atv) != here)
            self._waiting[now.atv] = here

    def lanes(self, now_s: float) -> Iterator[LaneTraffic]:
        """The last hour of every lane that had traffic.

        Args:
            now_s: plant clock.
        """
        for (start, end), lane in self._lanes.items():
            (passes,), (waits,) = lane.passes_lately.sums(now_s, 1), lane.waits_lately.sums(now_s, 1)
            (waited_s,) = lane.waited_lately_s.sums(now_s, 1)
            if passes or waited_s:
                yield LaneTraffic(start, end, int(passes), int(waits), waited_s)

    def totals(self) -> LaneTotals:
        """The totals since the beginning of every lane that had traffic."""
        return {
            ends: LaneTraffic(*ends, lane.passes, lane.waits, lane.waited_s)
            for ends, lane in self._lanes.items()
            if lane.passes or lane.waited_s
        }


def lanes_added(before: LaneTotals, after: LaneTotals) -> Iterator[LaneTraffic]:
    """The difference of two totals, for lanes that had traffic between them."""
    for ends, now in after.items():
        then = before.get(ends, LaneTraffic(*ends))
        if now != then:
            yield LaneTraffic(
                *ends, now.passes - then.passes, now.waits - then.waits, now.waited_s - then.waited_s
            )


def _standing(heartbeat: AtvHeartbeat) -> Ends | None:
    """The lane on which a vehicle stands with a way ahead; None otherwise."""
    if heartbeat.speed_mps or not heartbeat.way:
        return None
    return heartbeat.node, heartbeat.way[0]


def _passed(before: AtvHeartbeat, node: str) -> tuple[str, ...]:
    """The nodes from the last node to `node`; the vehicle may have left its way at the very start."""
    if node in before.way:
        return (before.node, *before.way[: before.way.index(node) + 1])
    return (before.node, node)
