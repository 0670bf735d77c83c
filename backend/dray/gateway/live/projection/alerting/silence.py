"""When silence of one agent means that what is shown of it is a memory: as the agents themselves judge it.

It is judged against the newest that was heard of the plant, and not against the gateway's clock alone. A simulation that
runs slower than was asked for, a gateway with more to read than it can, a network that holds everything up: all of
them make everybody's words old alike, and nobody is suspected for that. It is said once, of the plant.
"""

from __future__ import annotations

from collections.abc import Iterable
from heapq import nlargest

WORKING_BEAT_S, IDLE_BEAT_S = 1.0, 5.0
"""Who carries something speaks every second of factory time, everybody else every five."""

BEATS = 3

SLACK_S = 0.5

COMPANY = 4
"""Of fewer agents it cannot be told whether they are silent or nobody can be heard."""

WITNESSES = 2
"""The plant is as far as so many say: one whose clock is ahead must not make all others look silent."""

LEAST_S = 2.0
"""Wall seconds, however fast the factory runs: what is on its way to the gateway is not lost yet."""


def bound_s(*, working: bool, speed: float) -> float:
    """The silence that counts as failure, in factory seconds.

    Args:
        working: whether it carries something.
        speed: factory seconds per real second.
    """
    beat_s = WORKING_BEAT_S if working else IDLE_BEAT_S
    return max(LEAST_S * speed, BEATS * beat_s + SLACK_S)


def heard_until_s(told_s: Iterable[float], now_s: float) -> float:
    """How far the plant was heard, on its own clock; never beyond now.

    Args:
        told_s: of every agent, the time of its newest heartbeat.
        now_s: the present time on the plant's clock.
    """
    newest = nlargest(COMPANY, told_s)
    if len(newest) < COMPANY:
        return now_s
    return min(newest[WITNESSES - 1], now_s)
