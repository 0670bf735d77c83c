"""When silence of one agent means that what is shown of it is a memory: as the agents themselves judge it."""

from __future__ import annotations

WORKING_BEAT_S, IDLE_BEAT_S = 1.0, 5.0
"""Who carries something speaks every second of factory time, everybody else every five."""

BEATS = 3

SLACK_S = 0.5

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
