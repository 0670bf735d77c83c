"""An agent's pulse: regular, numbered, and not in step with everybody else's."""

from __future__ import annotations

from dray.protocol.runtime.life import BEAT, Life
from dray.protocol.runtime.timers import spread_frac


def beat(life: Life, now_s: float) -> float:
    """Beat at a time; returns when the next one is due."""
    assert life.timers.due(now_s) == [BEAT]
    life.count_beat()
    life.beat_again(5.0, now_s)
    return life.timers.next_s


def test_heartbeats_are_numbered_from_1() -> None:
    life = Life("M1")
    assert [life.count_beat(), life.count_beat(), life.beats] == [1, 2, 2]


def test_the_first_interval_is_shorter_by_a_part_that_follows_from_the_name() -> None:
    life = Life("ATV3")
    life.beat_soon(10.0)
    second_s = beat(life, 10.0)
    assert second_s == 10.0 + 5.0 * (0.5 + spread_frac("ATV3") / 2)
    assert beat(life, second_s) == second_s + 5.0


def test_a_change_brings_the_next_heartbeat_forward() -> None:
    life = Life("ATV3")
    life.beat_soon(10.0)
    beat(life, 10.0)
    life.beat_soon(11.0)
    assert beat(life, 11.0) == 16.0


def test_agents_that_are_started_together_are_spread_over_the_whole_span() -> None:
    parts = sorted(spread_frac(f"ATV{number}") for number in range(1, 101))
    assert 0.0 <= parts[0] < 0.1
    assert 0.9 < parts[-1] < 1.0
