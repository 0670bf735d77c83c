"""An agent's pulse: regular, numbered, and not in step with everybody else's."""

from __future__ import annotations

from dray.protocol.runtime.heartbeat_timer import HeartbeatTimer
from dray.protocol.runtime.life import BEAT, Life
from dray.protocol.runtime.timers import Timers, spread_frac


def beat(pulse: HeartbeatTimer, timers: Timers, now_s: float) -> float:
    """Beat at a time; returns when the next one is due."""
    assert timers.due(now_s) == [BEAT]
    pulse.count()
    pulse.go_on(5.0, now_s)
    return timers.next_s


def test_heartbeats_are_numbered_from_1() -> None:
    pulse = HeartbeatTimer("M1", Life())
    assert [pulse.count(), pulse.count(), pulse.seq] == [1, 2, 2]


def test_the_first_interval_is_shorter_by_a_part_that_follows_from_the_name() -> None:
    life = Life()
    pulse = HeartbeatTimer("ATV3", life)
    life.beat_soon(10.0)
    second_s = beat(pulse, life.timers, 10.0)
    assert second_s == 10.0 + 5.0 * (0.5 + spread_frac("ATV3") / 2)
    assert beat(pulse, life.timers, second_s) == second_s + 5.0


def test_a_change_brings_the_next_heartbeat_forward() -> None:
    life = Life()
    pulse = HeartbeatTimer("ATV3", life)
    life.beat_soon(10.0)
    beat(pulse, life.timers, 10.0)
    life.beat_soon(11.0)
    assert beat(pulse, life.timers, 11.0) == 16.0


def test_agents_that_are_started_together_are_spread_over_the_whole_span() -> None:
    parts = sorted(spread_frac(f"ATV{number}") for number in range(1, 101))
    assert 0.0 <= parts[0] < 0.1
    assert 0.9 < parts[-1] < 1.0
