"""Virtual time at a pace: what happens when, by a clock on the wall."""

from __future__ import annotations

import asyncio
import selectors
import threading
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dray_sim.clock import loop as loop_module
from dray_sim.clock.loop import (
    JUMP,
    VirtualLoop,
    clock,
    paced,
    run,
)


class Wall(selectors.SelectSelector):
    """Real time as the test wants it: a selector whose sleep moves a clock of its own."""

    def __init__(self) -> None:
        super().__init__()
        self.now_s = 1000.0
        self.naps_s: list[float] = []

    def read(self) -> float:
        return self.now_s

    def select(self, timeout: float | None = None) -> list[Any]:
        assert timeout is not None
        self.naps_s.append(timeout)
        self.now_s += timeout
        return super().select(0)


def run_on(wall: Wall, speed: float, main: Callable[[VirtualLoop], Any], start_s: float = 0.0) -> Any:
    """Run `main` paced against the test's own real time."""
    loop = VirtualLoop(paced(speed), start_s, selector=wall, wall_s=wall.read)
    with asyncio.Runner(loop_factory=lambda: loop) as runner:
        return runner.run(main(loop))


def test_a_paced_instant_begins_when_real_time_has_come_that_far() -> None:
    wall = Wall()

    async def main(loop: VirtualLoop) -> list[tuple[float, float]]:
        seen: list[tuple[float, float]] = []
        for seconds in (10.0, 20.0, 25.0):
            await asyncio.sleep(seconds - loop.time() + 3.0)
            seen.append((loop.time(), wall.now_s))
        return seen

    seen = run_on(wall, 5.0, main, start_s=3.0)
    assert [virtual_s for virtual_s, _ in seen] == pytest.approx([13.0, 23.0, 28.0])
    assert [wall_s for _, wall_s in seen] == pytest.approx([1002.0, 1004.0, 1005.0])


def test_a_paced_loop_that_is_behind_skips_nothing_and_says_so() -> None:
    wall = Wall()

    async def main(loop: VirtualLoop) -> list[tuple[float, float]]:
        seen: list[tuple[float, float]] = []

        def tick(number: int) -> None:
            if number == 3:
                wall.now_s += 4.0  # as long as four ticks take
            seen.append((loop.time(), loop.lag_s))

        for number in range(1, 11):
            loop.clock.call_at(float(number), tick, number)
        await asyncio.sleep(10.5)
        return seen

    seen = run_on(wall, 1.0, main)
    assert [virtual_s for virtual_s, _ in seen] == [float(number) for number in range(1, 11)]
    lags_s = [lag_s for _, lag_s in seen]
    assert lags_s == pytest.approx([0, 0, 0, 3, 2, 1, 0, 0, 0, 0], abs=1e-6)


def test_a_paced_loop_that_may_stand_does_not_catch_up_and_says_for_how_long() -> None:
    wall = Wall()
    stood_s: list[float] = []

    async def main(loop: VirtualLoop) -> list[tuple[float, float]]:
        loop.stood = stood_s.append
        seen: list[tuple[float, float]] = []

        def tick(number: int) -> None:
            if number == 3:
                wall.now_s += 4.0  # as long as four ticks take
            if number == 7:
                wall.now_s += 1.5  # half a second is caught up
            seen.append((loop.time(), wall.now_s))

        for number in range(1, 11):
            loop.clock.call_at(float(number), tick, number)
        await asyncio.sleep(10.5)
        return seen

    seen = run_on(wall, 1.0, main)
    assert [virtual_s for virtual_s, _ in seen] == [float(number) for number in range(1, 11)]
    assert sum(stood_s) == pytest.approx(3.0)
    # The fourth tick comes at once, the fifth a second after it, as ever.
    assert [wall_s - 1000.0 for _, wall_s in seen] == pytest.approx([1, 2, 7, 7, 8, 9, 11.5, 11.5, 12, 13])


def test_what_comes_from_outside_to_a_loop_that_is_behind_comes_after_all_that_it_has_done() -> None:
    wall = Wall()
    stood_s: list[float] = []

    async def main(loop: VirtualLoop) -> tuple[float, float]:
        loop.stood = stood_s.append
        came: list[float] = []

        def late() -> None:
            wall.now_s += 0.4  # less than what a loop stands for
            loop.call_soon_threadsafe(lambda: came.append(loop.clock.now_s()))

        loop.clock.call_at(2.0, late)
        for number in range(3, 30):
            loop.clock.call_at(2.0 + number / 100.0, print)
        await asyncio.sleep(3.0)
        # By the clock on the wall it came 2.4 s after the beginning: what is done for it is not told from before.
        return came[0], came[0] + sum(stood_s)

    at_s, told_s = run_on(wall, 1.0, main)
    assert at_s == pytest.approx(2.0)
    assert told_s == pytest.approx(2.4)


def test_building_takes_no_virtual_time() -> None:
    wall = Wall()

    async def main(loop: VirtualLoop) -> tuple[float, float]:
        wall.now_s += 30.0  # as long as it takes to build something large
        assert loop.due_s() == 5.0
        await asyncio.sleep(1.0)
        return loop.time(), loop.lag_s

    assert run_on(wall, 2.0, main, start_s=5.0) == pytest.approx((6.0, 0.0))
    assert wall.now_s == pytest.approx(1030.5)


def test_real_time_counts_from_when_somebody_has_read_both_clocks() -> None:
    wall = Wall()

    async def main(loop: VirtualLoop) -> tuple[float, float]:
        wall.now_s += 30.0  # built
        loop.begin()
        read_s = loop.time(), wall.now_s
        wall.now_s += 0.5  # told to others, before the loop sleeps first
        await asyncio.sleep(2.0)
        return loop.time() - read_s[0], wall.now_s - read_s[1]

    virtual_s, wall_s = run_on(wall, 2.0, main, start_s=5.0)
    assert (virtual_s, wall_s) == pytest.approx((2.0, 1.0))


def test_what_comes_from_outside_sees_the_time_that_real_time_stands_for() -> None:
    wall = Wall()

    async def main(loop: VirtualLoop) -> float:
        come = loop.create_future()
        loop.clock.call_at(100.0, print)

        def from_outside() -> None:
            come.set_result(loop.clock.now_s())

        real_select = wall.select

        def select(timeout: float | None = None) -> list[Any]:
            # Half way through its sleep somebody calls.
            loop.call_soon_threadsafe(from_outside)
            wall.select = real_select  # type: ignore[method-assign]
            return real_select(0.5 * (timeout or 0.0))

        wall.select = select  # type: ignore[method-assign]
        return await come  # type: ignore[no-any-return]

    assert run_on(wall, 2.0, main) == pytest.approx(50.0)


def test_a_thread_wakes_a_paced_loop_that_has_nothing_to_do() -> None:
    async def main() -> str:
        loop = asyncio.get_running_loop()
        come = loop.create_future()
        thread = threading.Thread(target=lambda: loop.call_soon_threadsafe(come.set_result, "come"))
        thread.start()
        result: str = await come
        thread.join()
        return result

    assert run(main(), paced(1.0)) == "come"


def test_a_busy_paced_loop_still_looks_at_its_sockets() -> None:
    wall = Wall()

    async def main(loop: VirtualLoop) -> int:
        def tick() -> None:
            wall.now_s += 0.001
            loop.clock.call_at(loop.clock.now_s() + 0.001, tick)

        tick()
        await asyncio.sleep(1.0)
        return len(wall.naps_s)

    looks = run_on(wall, 1000.0, main)
    assert looks >= 1.0 / loop_module.BURST_S * 0.5


plans = st.lists(
    st.tuples(
        st.sampled_from(["clock", "sleep", "later"]),
        st.integers(0, 20).map(lambda tenths: tenths / 10),
        st.integers(0, 3),
    ),
    max_size=12,
)


async def carry_out(plan: list[tuple[str, float, int]]) -> list[tuple[float, int]]:
    """Ask to be called back in several ways, some of the calls asking again; note what happens when."""
    seen: list[tuple[float, int]] = []
    loop = asyncio.get_running_loop()

    def call(way: str, seconds: float, more: int, number: int) -> None:
        if way == "clock":
            clock().call_at(clock().now_s() + seconds, happen, way, seconds, more, number)
        elif way == "later":
            loop.call_later(seconds, happen, way, seconds, more, number)
        else:
            tasks.append(asyncio.create_task(sleep(way, seconds, more, number)))

    async def sleep(way: str, seconds: float, more: int, number: int) -> None:
        await asyncio.sleep(seconds)
        happen(way, seconds, more, number)

    def happen(way: str, seconds: float, more: int, number: int) -> None:
        seen.append((clock().now_s(), number))
        if more:
            call(way, seconds, more - 1, number + 100)

    tasks: list[asyncio.Task[None]] = []
    for number, (way, seconds, more) in enumerate(plan):
        call(way, seconds, more, number)
    await asyncio.sleep(100.0)
    return seen


@settings(deadline=None)
@given(plans)
def test_all_paces_give_the_same_order_at_the_same_times(plan: list[tuple[str, float, int]]) -> None:
    jumped = run(carry_out(plan), JUMP)
    assert jumped == run_on(Wall(), 3.0, lambda loop: carry_out(plan))
    assert [at_s for at_s, _ in jumped] == sorted(at_s for at_s, _ in jumped)
