"""Virtual time as fast as possible: what happens, and in which order."""

from __future__ import annotations

import asyncio
import math

import pytest

from dray_sim.clock import loop as loop_module
from dray_sim.clock.loop import (
    DeadlockError,
    Pace,
    StandstillError,
    clock,
    run,
)


def test_a_year_of_sleep_takes_no_time() -> None:
    async def main() -> float:
        await asyncio.sleep(365 * 86_400)
        return clock().now_s()

    # Slept for real, it would never come to its end.
    assert run(main(), start_s=5.0) == 5.0 + 365 * 86_400


def test_the_loop_and_its_clock_show_one_time() -> None:
    async def main() -> None:
        for _ in range(3):
            await asyncio.sleep(0.25)
            assert asyncio.get_running_loop().time() == clock().now_s()

    run(main())


def test_asyncio_and_the_clock_share_one_order() -> None:
    async def main() -> list[str]:
        seen: list[str] = []

        async def sleeper(seconds: float, name: str) -> None:
            await asyncio.sleep(seconds)
            seen.append(name)

        loop = asyncio.get_running_loop()
        tasks = [asyncio.create_task(sleeper(2.0, "sleep 2")), asyncio.create_task(sleeper(1.0, "sleep 1"))]
        clock().call_at(1.5, seen.append, "clock 1.5")
        loop.call_later(0.5, seen.append, "later 0.5")
        loop.call_at(1.75, seen.append, "at 1.75")
        await asyncio.gather(*tasks)
        return seen

    assert run(main()) == ["later 0.5", "sleep 1", "clock 1.5", "at 1.75", "sleep 2"]


def test_time_stands_while_anybody_is_ready() -> None:
    async def main() -> None:
        for _ in range(1000):
            await asyncio.sleep(0)
        assert clock().now_s() == 0.0

    run(main())


def test_all_of_an_instant_happens_before_the_tasks_that_it_wakes() -> None:
    async def main() -> list[str]:
        seen: list[str] = []
        waiting = asyncio.get_running_loop().create_future()
        clock().call_at(1.0, seen.append, "first")
        clock().call_at(1.0, waiting.set_result, None)
        clock().call_at(1.0, seen.append, "second")
        await waiting
        seen.append("task")
        return seen

    assert run(main()) == ["first", "second", "task"]


def test_a_timeout_comes_in_virtual_time() -> None:
    async def main() -> float:
        with pytest.raises(TimeoutError):
            await asyncio.wait_for(asyncio.Event().wait(), 30.0)
        return clock().now_s()

    assert run(main()) == 30.0


def test_cancelled_timers_do_not_pile_up() -> None:
    async def main() -> int:
        for _ in range(5000):
            asyncio.get_running_loop().call_later(1e6, print).cancel()
        return len(clock().heap)

    assert run(main()) < 3 * loop_module.MIN_CANCELLED


def test_forgetting_cancelled_timers_keeps_all_others() -> None:
    async def main() -> list[int]:
        seen: list[int] = []
        loop = asyncio.get_running_loop()
        for number in range(1000):
            loop.call_later(1000 - number, seen.append, number)
            clock().call_at(1000 - number, seen.append, number)
            for _ in range(5):
                loop.call_later(500.0, print).cancel()
        await asyncio.sleep(1001)
        return seen

    assert run(main()) == [number for number in reversed(range(1000)) for _ in range(2)]


def test_everybody_waiting_for_nobody_is_a_deadlock() -> None:
    async def main() -> None:
        await asyncio.sleep(7.0)
        await asyncio.Event().wait()

    with pytest.raises(DeadlockError, match=r"deadlock at 7\.000000 s.* 1 tasks wait") as caught:
        run(main())
    assert caught.value.now_s == 7.0


def test_a_wait_for_ever_alone_is_a_deadlock() -> None:
    async def main() -> None:
        clock().call_at(math.inf, print)
        await asyncio.sleep(math.inf)

    with pytest.raises(DeadlockError):
        run(main())


def test_a_call_back_at_once_again_and_again_is_a_standstill(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(loop_module, "MAX_STEPS_PER_INSTANT", 500)

    async def main() -> None:
        def again() -> None:
            clock().call_at(0.0, again)

        await asyncio.sleep(3.0)
        again()
        await asyncio.sleep(1.0)

    with pytest.raises(StandstillError, match=r"stands at 3\.000000 s.*again"):
        run(main())


def test_a_task_that_never_waits_is_a_standstill(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(loop_module, "MAX_STEPS_PER_INSTANT", 500)

    async def main() -> None:
        while True:  # noqa: ASYNC110 (this is the mistake)
            await asyncio.sleep(0)

    with pytest.raises(StandstillError):
        run(main())


def test_many_steps_in_many_instants_are_no_standstill(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(loop_module, "MAX_STEPS_PER_INSTANT", 500)

    async def main() -> None:
        for _ in range(100):
            for _ in range(100):
                await asyncio.sleep(0)
            await asyncio.sleep(0.001)

    run(main())


def test_an_error_in_a_callback_of_the_clock_ends_the_run() -> None:
    async def main() -> None:
        clock().call_at(1.0, lambda: 1 / 0)
        await asyncio.sleep(2.0)

    with pytest.raises(ZeroDivisionError):
        run(main())


def test_a_run_ends_with_its_main_task_and_cancels_the_others() -> None:
    ended: list[str] = []

    async def other() -> None:
        try:
            await asyncio.sleep(1e9)
        finally:
            ended.append("other")

    async def main() -> str:
        task = asyncio.create_task(other())
        await asyncio.sleep(1.0)
        assert not task.done()
        return "result"

    assert run(main()) == "result"
    assert ended == ["other"]


def test_there_is_no_clock_outside_a_virtual_loop() -> None:
    async def main() -> None:
        with pytest.raises(RuntimeError, match="no virtual loop"):
            clock()

    asyncio.run(main())


@pytest.mark.parametrize("speed", [0.0, -1.0, math.nan])
def test_a_pace_goes_forward(speed: float) -> None:
    with pytest.raises(ValueError, match="speed must be above 0"):
        Pace(speed)
