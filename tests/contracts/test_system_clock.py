"""What only the clock in service has to bear: the computer's clock is set, by people and by NTP."""

from __future__ import annotations

import asyncio

import pytest

from dray.adapters.system_clock import MAX_NAP_S, SystemClock
from dray_sim.loop import run


class Computer:
    """A computer's clock that runs with the loop and can be set."""

    def __init__(self) -> None:
        self.offset_s = 1.75e9

    def unix_s(self) -> float:
        return self.offset_s + asyncio.get_running_loop().time()


def clock_on(computer: Computer) -> SystemClock:
    return SystemClock(asyncio.get_running_loop(), unix_s=computer.unix_s)


def test_a_clock_that_is_set_back_stands_until_time_has_caught_up() -> None:
    async def main() -> None:
        computer = Computer()
        clock = clock_on(computer)
        before_s = clock.now_s()
        computer.offset_s -= 60.0
        assert clock.now_s() == before_s
        await asyncio.sleep(59.0)
        assert clock.now_s() == before_s
        await asyncio.sleep(2.0)
        assert clock.now_s() > before_s

    run(main())


def test_a_call_waits_for_its_time_though_the_clock_was_set_back() -> None:
    async def main() -> None:
        computer = Computer()
        clock = clock_on(computer)
        when_s = clock.now_s() + 5.0
        seen: list[float] = []
        clock.call_at(when_s, lambda: seen.append(clock.now_s()))
        computer.offset_s -= 60.0
        await asyncio.sleep(64.0)
        assert seen == []
        await asyncio.sleep(2.0)
        assert len(seen) == 1
        assert seen[0] >= when_s

    run(main())


def test_a_call_that_a_set_clock_made_due_waits_no_longer_than_a_nap() -> None:
    async def main() -> None:
        computer = Computer()
        clock = clock_on(computer)
        seen: list[str] = []
        clock.call_at(clock.now_s() + 3600.0, lambda: seen.append("due"))
        computer.offset_s += 7200.0
        await asyncio.sleep(MAX_NAP_S + 0.1)
        assert seen == ["due"]

    run(main())


def test_a_callback_that_fails_does_not_hold_up_the_others() -> None:
    async def main() -> None:
        faults: list[object] = []
        asyncio.get_running_loop().set_exception_handler(
            lambda _, context: faults.append(context["exception"])
        )
        clock = clock_on(Computer())
        seen: list[str] = []

        def fail() -> None:
            raise ZeroDivisionError

        when_s = clock.now_s() + 1.0
        clock.call_at(when_s, fail)
        clock.call_at(when_s, lambda: seen.append("other"))
        await asyncio.sleep(2.0)
        assert seen == ["other"]
        assert [type(fault) for fault in faults] == [ZeroDivisionError]

    run(main())


def test_a_clock_of_another_speed_begins_at_its_epoch_and_calls_at_its_own_times() -> None:
    async def main() -> None:
        computer, loop = Computer(), asyncio.get_running_loop()
        epoch_s = computer.unix_s()
        clock = SystemClock(loop, unix_s=computer.unix_s, speed=20.0, epoch_s=epoch_s)
        assert clock.now_s() == epoch_s
        seen: list[float] = []
        clock.call_at(epoch_s + 60.0, lambda: seen.append(computer.unix_s()))
        await asyncio.sleep(2.9)
        assert (seen, clock.now_s()) == ([], pytest.approx(epoch_s + 58.0))
        await asyncio.sleep(0.2)
        assert seen == [pytest.approx(epoch_s + 3.0, abs=0.01)]

    run(main())
