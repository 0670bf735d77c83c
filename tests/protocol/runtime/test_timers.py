"""An agent's alarms."""

from __future__ import annotations

from dray.protocol.runtime.events import NEVER_S
from dray.protocol.runtime.timers import Timers


def test_without_alarms_nobody_is_woken() -> None:
    timers = Timers()
    assert timers.next_s == NEVER_S
    assert timers.due(1e9) == []


def test_the_earliest_alarm_is_the_next() -> None:
    timers = Timers()
    timers.set("late", 9.0)
    timers.set("early", 3.0)
    timers.set("middle", 5.0)
    assert timers.next_s == 3.0


def test_an_alarm_is_due_at_its_very_moment_and_not_before() -> None:
    timers = Timers()
    timers.set("tea", 3.0)
    assert timers.due(2.999) == []
    assert timers.is_set("tea")
    assert timers.due(3.0) == ["tea"]


def test_a_due_alarm_sounds_once() -> None:
    timers = Timers()
    timers.set("tea", 3.0)
    timers.due(4.0)
    assert timers.due(5.0) == []
    assert not timers.is_set("tea")
    assert timers.next_s == NEVER_S


def test_alarms_that_are_due_together_come_by_time_and_then_as_they_were_set() -> None:
    timers = Timers()
    for name, at_s in (("b", 2.0), ("a", 2.0), ("first", 1.0), ("later", 7.0)):
        timers.set(name, at_s)
    assert timers.due(3.0) == ["first", "b", "a"]
    assert timers.next_s == 7.0


def test_setting_an_alarm_again_moves_it_both_ways() -> None:
    timers = Timers()
    timers.set("tea", 3.0)
    timers.set("tea", 8.0)
    assert timers.next_s == 8.0
    timers.set("tea", 1.0)
    assert timers.next_s == 1.0
    assert timers.due(10.0) == ["tea"]


def test_moving_the_earliest_alarm_back_uncovers_the_next_one() -> None:
    timers = Timers()
    timers.set("tea", 3.0)
    timers.set("coffee", 4.0)
    timers.set("tea", 5.0)
    assert timers.next_s == 4.0


def test_a_cleared_alarm_is_silent() -> None:
    timers = Timers()
    timers.set("tea", 3.0)
    timers.set("coffee", 4.0)
    timers.clear("tea")
    assert timers.next_s == 4.0
    assert timers.due(10.0) == ["coffee"]


def test_clearing_what_was_never_set_is_harmless() -> None:
    timers = Timers()
    timers.clear("tea")
    timers.set("coffee", 4.0)
    timers.clear("tea")
    assert timers.next_s == 4.0


def test_an_alarm_may_be_set_anew_while_the_due_ones_are_seen_to() -> None:
    timers = Timers()
    timers.set("beat", 1.0)
    for name in timers.due(1.0):
        timers.set(name, 2.0)
    assert timers.next_s == 2.0
