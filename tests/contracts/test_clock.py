"""The conformance suite of `dray.ports.Clock`: every clock runs all of it.

A new clock is one more world: a loop, and the clock on it.
"""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable, Coroutine
from typing import Any

import pytest

from dray.adapters.system_clock import SLEW_FRAC, SystemClock
from dray.ports import Clock
from dray_sim.clock.computer import ComputerClock
from dray_sim.clock.loop import JUMP, Pace, VirtualLoop, paced


class World:
    """A clock and the loop that it runs on. No world's time is the wall's, so nobody waits for it.

    Args:
        pace: of the virtual loop.
        make: the clock on that loop.
        slow_frac: by how much the clock may be slower than the loop.
    """

    clock: Clock

    def __init__(self, pace: Pace, make: Callable[[VirtualLoop], Clock], slow_frac: float = 0.0) -> None:
        self._pace = pace
        self._make = make
        self._slow_frac = slow_frac

    def run(self, test: Coroutine[Any, Any, None]) -> None:
        loop = VirtualLoop(self._pace)
        self.clock = self._make(loop)
        with asyncio.Runner(loop_factory=lambda: loop) as runner:
            runner.run(test)

    async def pass_time(self, seconds: float) -> None:
        """Let `seconds` of the clock pass, and some more for rounding."""
        await asyncio.sleep(seconds / (1.0 - self._slow_frac) + 0.01)


def unix_clock(loop: VirtualLoop) -> Clock:
    # The computer's clock runs with the loop, from some day in our time.
    return SystemClock(loop, unix_s=lambda: 1.75e9 + loop.time())


def clock_that_is_set(by_s: float) -> Callable[[VirtualLoop], Clock]:
    """The clock on a computer whose own is set by so much, again and again."""

    def make(loop: VirtualLoop) -> Clock:
        return SystemClock(loop, unix_s=lambda: 1.75e9 + loop.time() + by_s * (loop.time() // 0.7))

    return make


def computer_that_is_set(by_s: float) -> Callable[[VirtualLoop], Clock]:
    """The simulated clock of a computer, which is set by so much, again and again."""

    def make(loop: VirtualLoop) -> Clock:
        clock = ComputerClock(loop.clock)

        def step() -> None:
            clock.step(by_s)
            loop.call_later(0.7, step)

        step()
        return clock

    return make


FAST = paced(1e6)
"""A second in a microsecond: paced, and yet nobody waits."""

WORLDS = {
    "jump": lambda: World(JUMP, lambda loop: loop.clock),
    "paced": lambda: World(FAST, lambda loop: loop.clock),
    "system": lambda: World(JUMP, unix_clock),
    "system, set forward": lambda: World(JUMP, clock_that_is_set(3600.0), SLEW_FRAC),
    "system, set back": lambda: World(JUMP, clock_that_is_set(-3600.0), SLEW_FRAC),
    "computer": lambda: World(JUMP, lambda loop: ComputerClock(loop.clock)),
    "computer, set forward": lambda: World(JUMP, computer_that_is_set(3600.0), SLEW_FRAC),
    "computer, set back": lambda: World(JUMP, computer_that_is_set(-3600.0), SLEW_FRAC),
}


@pytest.fixture(params=list(WORLDS.values()), ids=list(WORLDS))
def world(request: pytest.FixtureRequest) -> World:
    made: World = request.param()
    return made


async def test_callbacks_run_in_the_order_of_their_times(world: World) -> None:
    seen: list[float] = []
    start_s = world.clock.now_s()
    for after_s in (3.0, 1.0, 2.0, 0.5):
        world.clock.call_at(start_s + after_s, lambda after_s=after_s: seen.append(after_s))  # type: ignore[misc]
    await world.pass_time(3.0)
    assert seen == [0.5, 1.0, 2.0, 3.0]


async def test_equal_times_run_in_the_order_of_the_calls(world: World) -> None:
    seen: list[int] = []
    when_s = world.clock.now_s() + 1.0
    for number in range(100):
        world.clock.call_at(when_s, lambda number=number: seen.append(number))  # type: ignore[misc]
    await world.pass_time(1.0)
    assert seen == list(range(100))


async def test_no_callback_runs_before_its_time(world: World) -> None:
    seen: list[tuple[float, float]] = []

    def note(when_s: float) -> None:
        seen.append((when_s, world.clock.now_s()))

    start_s = world.clock.now_s()
    for tenths in range(50):
        when_s = start_s + tenths / 10
        world.clock.call_at(when_s, lambda when_s=when_s: note(when_s))  # type: ignore[misc]
    await world.pass_time(5.0)
    assert len(seen) == 50
    assert all(now_s >= when_s for when_s, now_s in seen)


async def test_now_never_goes_back(world: World) -> None:
    seen: list[float] = []

    def note() -> None:
        seen.append(world.clock.now_s())
        if len(seen) < 50:
            world.clock.call_at(seen[-1] + 0.1 * (len(seen) % 3), note)

    note()
    await world.pass_time(10.0)
    assert len(seen) == 50
    assert seen == sorted(seen)


async def test_a_wait_takes_as_long_as_it_should_whatever_time_the_computer_shows(world: World) -> None:
    loop, seen = asyncio.get_running_loop(), list[float]()
    began_s = loop.time()
    for after_s in (1.0, 10.0, 100.0):
        world.clock.call_at(world.clock.now_s() + after_s, lambda: seen.append(loop.time() - began_s))
    await world.pass_time(100.0)
    assert seen == [pytest.approx(after_s, rel=0.12) for after_s in (1.0, 10.0, 100.0)]


async def test_a_time_that_is_past_means_as_soon_as_possible(world: World) -> None:
    await world.pass_time(5.0)
    seen: list[float] = []
    start_s = world.clock.now_s()
    world.clock.call_at(start_s - 3.0, lambda: seen.append(world.clock.now_s()))
    assert seen == []
    await world.pass_time(0.0)
    assert len(seen) == 1
    assert start_s <= seen[0] <= start_s + 0.01


async def test_a_time_that_is_past_does_not_overtake(world: World) -> None:
    seen: list[str] = []
    now_s = world.clock.now_s()
    world.clock.call_at(now_s, lambda: seen.append("first"))
    world.clock.call_at(now_s - 10.0, lambda: seen.append("second"))
    await world.pass_time(0.0)
    assert seen == ["first", "second"]


async def test_callbacks_never_run_inside_call_at(world: World) -> None:
    seen: list[str] = []

    def outer() -> None:
        world.clock.call_at(world.clock.now_s(), lambda: seen.append("inner"))
        seen.append("outer")

    world.clock.call_at(world.clock.now_s(), outer)
    await world.pass_time(0.0)
    assert seen == ["outer", "inner"]


async def test_callbacks_run_on_the_loop_of_the_caller(world: World) -> None:
    seen: list[asyncio.AbstractEventLoop] = []
    world.clock.call_at(world.clock.now_s() + 1.0, lambda: seen.append(asyncio.get_running_loop()))
    await world.pass_time(1.0)
    assert seen == [asyncio.get_running_loop()]


async def test_an_earlier_call_asked_for_later_comes_first(world: World) -> None:
    seen: list[str] = []
    start_s = world.clock.now_s()
    world.clock.call_at(start_s + 2.0, lambda: seen.append("asked first"))
    await world.pass_time(0.5)
    world.clock.call_at(start_s + 1.0, lambda: seen.append("asked later"))
    await world.pass_time(2.0)
    assert seen == ["asked later", "asked first"]


async def test_infinity_means_never(world: World) -> None:
    seen: list[str] = []
    world.clock.call_at(math.inf, lambda: seen.append("never"))
    await world.pass_time(1e4)
    assert seen == []


async def test_a_time_that_is_no_number_is_refused(world: World) -> None:
    with pytest.raises(ValueError, match="not a number"):
        world.clock.call_at(math.nan, lambda: None)
