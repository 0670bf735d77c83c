"""Alarms do what a naive twin does."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from dray.protocol.runtime.events import NEVER_S
from dray.protocol.runtime.timers import Timers

NAMES = st.sampled_from("abcd")
TIMES_S = st.integers(min_value=0, max_value=8).map(float)
STEPS = st.lists(
    st.one_of(
        st.tuples(st.just("set"), NAMES, TIMES_S),
        st.tuples(st.just("clear"), NAMES, st.just(0.0)),
        st.tuples(st.just("due"), st.just(""), TIMES_S),
    ),
    max_size=40,
)


class Twin:
    """The same, as slowly and plainly as can be."""

    def __init__(self) -> None:
        self.alarms: list[tuple[str, float]] = []
        """In the order in which they were set."""

    def set(self, name: str, at_s: float) -> None:
        self.clear(name)
        self.alarms.append((name, at_s))

    def clear(self, name: str) -> None:
        self.alarms = [alarm for alarm in self.alarms if alarm[0] != name]

    def due(self, now_s: float) -> list[str]:
        due = [alarm for alarm in self.alarms if alarm[1] <= now_s]
        self.alarms = [alarm for alarm in self.alarms if alarm[1] > now_s]
        return [name for name, _ in sorted(due, key=lambda alarm: alarm[1])]

    @property
    def next_s(self) -> float:
        return min((at_s for _, at_s in self.alarms), default=NEVER_S)


@given(STEPS)
def test_alarms_sound_as_a_naive_twin_says(steps: list[tuple[str, str, float]]) -> None:
    timers, twin = Timers(), Twin()
    for kind, name, at_s in steps:
        if kind == "set":
            timers.set(name, at_s)
            twin.set(name, at_s)
        elif kind == "clear":
            timers.clear(name)
            twin.clear(name)
        else:
            assert timers.due(at_s) == twin.due(at_s)
        assert timers.next_s == twin.next_s
        assert {each for each in "abcd" if timers.is_set(each)} == {each for each, _ in twin.alarms}
