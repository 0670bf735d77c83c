"""What is told of each name once a minute at most."""

from __future__ import annotations

from dray.protocol.runtime.throttle import NAMES_KEPT, TOLD_EVERY_S, Throttle


def test_each_name_passes_once_a_minute() -> None:
    throttle = Throttle()
    passed = [now_s for now_s in range(3 * int(TOLD_EVERY_S)) if throttle.passes("ATV1", float(now_s))]
    assert passed == [0, 60, 120]
    assert throttle.passes("ATV2", 179.0)


def test_a_clock_that_was_set_back_holds_nothing_up() -> None:
    throttle = Throttle()
    assert throttle.passes("ATV1", 1000.0)
    assert throttle.passes("ATV1", 10.0)
    assert not throttle.passes("ATV1", 11.0)


def test_the_name_that_was_told_of_longest_ago_is_forgotten_first() -> None:
    throttle = Throttle()
    for number in range(NAMES_KEPT):
        assert throttle.passes(str(number), 0.0)
    assert not throttle.passes("0", 1.0), "it is heard again, and is the newest now"
    assert throttle.passes("one more", 1.0)
    assert not throttle.passes("0", 2.0)
    assert throttle.passes("1", 2.0)
