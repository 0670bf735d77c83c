"""A history that cannot grow for ever."""

from __future__ import annotations

from dray.protocol.runtime.bounded_map import BoundedMap


def test_the_oldest_entry_goes_when_there_is_one_too_many() -> None:
    newest: BoundedMap[str, int] = BoundedMap(2)
    for number, name in enumerate("abc"):
        newest[name] = number
    assert newest == {"b": 1, "c": 2}


def test_an_entry_that_is_set_again_keeps_its_age() -> None:
    newest: BoundedMap[str, int] = BoundedMap(2)
    for name in "aba":
        newest[name] = len(newest)
    newest["c"] = 3
    assert newest == {"b": 1, "c": 3}
