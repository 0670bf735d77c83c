"""The clock of a simulated computer: what it shows after somebody has set it."""

from __future__ import annotations

import itertools

import pytest

from dray.adapters.system_clock import SLEW_FRAC
from dray_sim.clock.computer import ComputerClock
from dray_sim.clock.loop import VirtualClock


class Bench:
    """A computer clock, and the right time, which goes on when the test says so."""

    def __init__(self) -> None:
        self.plant = VirtualClock(1000.0)
        self.clock = ComputerClock(self.plant)
        self.called: list[tuple[str, float]] = []

    def pass_time(self, until_s: float) -> None:
        heap = self.plant.heap
        while heap and heap[0][0] <= until_s:
            heap.sort(key=lambda entry: entry[:2])
            self.plant.time_s, _, call, args = heap.pop(0)
            call(*args)
            heap.sort(key=lambda entry: entry[:2])
        self.plant.time_s = until_s

    def ask(self, name: str, when_s: float) -> None:
        self.clock.call_at(when_s, lambda: self.called.append((name, self.clock.now_s())))


def test_it_shows_the_right_time_until_it_is_set() -> None:
    bench = Bench()
    bench.pass_time(1234.5)
    assert (bench.clock.now_s(), bench.clock.ahead_s) == (1234.5, 0.0)


@pytest.mark.parametrize("by_s", [30.0, -30.0])
def test_it_drifts_to_where_it_was_set_and_back_when_it_is_set_right(by_s: float) -> None:
    bench = Bench()
    bench.clock.step(by_s)
    assert bench.clock.ahead_s == 0.0
    bench.pass_time(1100.0)
    assert bench.clock.ahead_s == pytest.approx(by_s / 3.0)
    bench.pass_time(1500.0)
    assert bench.clock.now_s() == pytest.approx(1500.0 + by_s)
    bench.clock.step(-by_s)
    bench.pass_time(2000.0)
    assert bench.clock.now_s() == pytest.approx(2000.0)


@pytest.mark.parametrize("by_s", [30.0, -30.0])
def test_it_never_goes_back_and_calls_at_the_time_that_it_shows(by_s: float) -> None:
    bench = Bench()
    bench.clock.step(by_s)
    for number in range(8):
        bench.ask(f"{number}", 1000.0 + 1.5 * number)
    seen = [bench.clock.now_s()]
    for tick in range(200):
        if tick == 50:
            bench.clock.step(-3 * by_s)
        bench.pass_time(1000.0 + 0.1 * tick)
        seen.append(bench.clock.now_s())
    assert seen == sorted(seen)
    assert all(
        later - earlier <= 0.1 * (1.0 + SLEW_FRAC) + 1e-6 for earlier, later in itertools.pairwise(seen)
    )
    assert [name for name, _ in bench.called] == [f"{number}" for number in range(8)]
    for number, (_, at_s) in enumerate(bench.called):
        assert at_s == pytest.approx(1000.0 + 1.5 * number, abs=1e-6)


def test_a_process_that_is_started_begins_with_the_computer_s_time() -> None:
    bench = Bench()
    bench.clock.step(-30.0)
    bench.ask("of the life before", 1001.0)
    bench.clock.begin_life()
    assert bench.clock.now_s() == 970.0
    bench.ask("of this life", 980.0)
    bench.pass_time(1100.0)
    assert bench.called == [("of this life", 980.0)]
