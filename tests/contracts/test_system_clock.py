"""What only the clock in service has to bear: the computer's clock is set, by people and by NTP."""

from __future__ import annotations

import asyncio
import math
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dray.adapters.system_clock import SLEW_FRAC, SystemClock
from dray.protocol.liveness.suspicion import WORKING_INTERVAL_S, bound_s
from dray_sim.clock.loop import run


class Computer:
    """A computer's clock that runs with the loop and can be set."""

    def __init__(self) -> None:
        self.offset_s = 1.75e9

    def unix_s(self) -> float:
        return self.offset_s + asyncio.get_running_loop().time()


def clock_on(computer: Computer) -> SystemClock:
    return SystemClock(asyncio.get_running_loop(), unix_s=computer.unix_s)


@pytest.mark.parametrize("by_s", [-60.0, 60.0])
def test_a_clock_that_was_set_is_followed_a_tenth_faster_or_slower(by_s: float) -> None:
    async def main() -> None:
        computer = Computer()
        clock = clock_on(computer)
        before_s = clock.now_s()
        computer.offset_s += by_s
        assert clock.now_s() == before_s
        pace = 1.0 + math.copysign(SLEW_FRAC, by_s)
        shown_s = [before_s]
        for second in range(1, 601):
            await asyncio.sleep(1.0)
            shown_s.append(clock.now_s())
            assert shown_s[-1] == pytest.approx(before_s + pace * second)
        assert clock.behind_s == pytest.approx(0.0, abs=1e-3)
        await asyncio.sleep(100.0)
        assert clock.now_s() == pytest.approx(computer.unix_s())

    run(main())


def test_beats_go_on_when_the_clock_is_set_back() -> None:
    async def main() -> None:
        computer = Computer()
        clock, beats = clock_on(computer), list[float]()

        def beat() -> None:
            beats.append(asyncio.get_running_loop().time())
            clock.call_at(clock.now_s() + 1.0, beat)

        beat()
        await asyncio.sleep(5.5)
        computer.offset_s -= 3600.0
        await asyncio.sleep(60.0)
        assert max(after - before for before, after in pairwise(beats)) < 1.2

    run(main())


@settings(deadline=None)  # A slow machine is no failure.
@given(
    steps=st.lists(
        st.tuples(st.integers(1, 120), st.floats(-1e5, 1e5, allow_nan=False)), min_size=1, max_size=20
    )
)
def test_no_step_makes_a_failure_detector_suspect_somebody_who_beats(steps: list[tuple[int, float]]) -> None:
    """Beats come once a second by the time that passes; the failure detector keeps the time by the clock."""

    async def main() -> None:
        computer = Computer()
        clock, failed = clock_on(computer), list[float]()
        heard_s = clock.now_s()

        def look() -> None:
            if clock.now_s() >= heard_s + bound_s(WORKING_INTERVAL_S):
                failed.append(clock.now_s())
            clock.call_at(heard_s + bound_s(WORKING_INTERVAL_S), look)

        look()
        for seconds, by_s in steps:
            for second in range(seconds):
                await asyncio.sleep(1.0)
                if second % 3 == 0:  # Two of three are lost.
                    heard_s = clock.now_s()
            computer.offset_s += by_s
        assert failed == []

    run(main())


def test_a_step_is_counted_once_and_told_and_drift_is_none(caplog: pytest.LogCaptureFixture) -> None:
    async def main() -> None:
        computer = Computer()
        clock = clock_on(computer)
        for _ in range(100):
            await asyncio.sleep(1.0)
            computer.offset_s += 0.0005  # As much as NTP shifts in a second.
            clock.now_s()
        assert clock.steps == 0
        for number, by_s in enumerate((3600.0, -3600.0, 2.0), 1):
            computer.offset_s += by_s
            for _ in range(10):
                await asyncio.sleep(1.0)
                clock.now_s()
            assert clock.steps == number
        assert clock.behind_s == pytest.approx(0.0, abs=1.1)

    run(main())
    assert [record.getMessage()[:44] for record in caplog.records] == [
        "the computer's clock was set by +3600.0 s; t",
        "the computer's clock was set by -3600.0 s; t",
        "the computer's clock was set by +2.0 s; the ",
    ]


def test_a_call_that_is_far_off_does_not_come_early_when_the_clock_is_set_forward() -> None:
    async def main() -> None:
        computer = Computer()
        clock, loop = clock_on(computer), asyncio.get_running_loop()
        seen: list[float] = []
        when_s = clock.now_s() + 3600.0
        clock.call_at(when_s, lambda: seen.append(clock.now_s()))
        computer.offset_s += 7200.0
        await asyncio.sleep(3600.0 / (1.0 + SLEW_FRAC) - 1.0)
        assert seen == []
        await asyncio.sleep(2.0)
        assert seen == [pytest.approx(when_s, abs=0.01)]
        assert loop.time() == pytest.approx(3600.0 / 1.1 + 1.0)

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
