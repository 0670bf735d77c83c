"""When silence becomes failure: pure arithmetic.

An agent says itself how often it speaks (by its status), so its silence can be judged by anybody
who hears it. The bound is

    bound_s = MISSES * interval_s + JITTER_S

A heartbeat may be lost MISSES - 1 times in a row, and the next one late by JITTER_S, before its
sender is suspected.
"""

from __future__ import annotations

from dray.messages import AtvHeartbeat

WORKING_INTERVAL_S = 1.0
"""A working agent beats at 1 Hz: a takeover is due within a few seconds of its death."""

IDLE_INTERVAL_S = 5.0
"""An idle one at 0.2 Hz: nobody waits for it, so it need not load the network (paper, 3.2)."""

MISSES = 3
"""At 5 % loss three misses in a row come once in 8,000 heartbeats."""

JITTER_S = 0.5
"""More than the latency of a loaded WLAN, less than half a working interval."""


def atv_interval_s(heartbeat: AtvHeartbeat) -> float:
    """How long after this heartbeat the next one is due."""
    return WORKING_INTERVAL_S if heartbeat.task is not None else IDLE_INTERVAL_S


def bound_s(interval_s: float) -> float:
    """How long somebody who beats every `interval_s` may be silent without being suspected."""
    return MISSES * interval_s + JITTER_S
